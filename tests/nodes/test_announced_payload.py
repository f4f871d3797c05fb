"""A payload that a machine announces is held to the same bounds as one that a recording declares."""

from collections import deque
from types import SimpleNamespace

import pytest
from ddh_twin_py.nodes.telemetry_node import TelemetryNode, Unit, known_payload
from ddh_twin_py.rig import LARGEST_PAYLOAD

from ddh_msgs.msg import RigInfo


def said_of(payload):
    """What a node that runs with 149.5 kg warns of, and whether it begins anew."""
    said, anew = [], []
    node = SimpleNamespace(
        rig_info=None, health=SimpleNamespace(), unit=Unit("rig_7", 149.5), warn_once=lambda cause, text: said.append(text),
        warn_again=lambda cause, text: said.append(text) or True, wall=lambda: 0.0, _exchanges=0, _lately=deque(),
        get_logger=lambda: SimpleNamespace(info=lambda text: None, warning=said.append), begin_anew=lambda: anew.append(True),
    )  # fmt: skip
    TelemetryNode._take_rig(node, RigInfo(rig_id="rig_7", payload_mass=payload))
    return said, bool(anew)


@pytest.mark.parametrize("payload", [1e300, 149_500.0, -5.0, float("inf")])
def test_one_out_of_range_is_not_used_and_said(payload):
    assert known_payload(RigInfo(payload_mass=payload)) is None
    assert said_of(payload) == ([f"rig: payload_mass is {payload:g} kg, allowed are above 0 to 100000 kg; it is not used"], False)


@pytest.mark.parametrize("payload", [0.0, float("nan")])
def test_one_that_is_not_known_is_no_fault(payload):
    assert known_payload(RigInfo(payload_mass=payload)) is None and said_of(payload) == ([], False)


def test_one_within_the_range_is_used():
    assert known_payload(RigInfo(payload_mass=LARGEST_PAYLOAD)) == LARGEST_PAYLOAD
    assert said_of(149.5) == ([], False) and said_of(120.0)[1]
