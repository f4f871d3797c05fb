"""What the rig file knows of sensors' errors is taken off in the nodes as in replay."""

import numpy as np
import pytest
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.writer import write_rig
from nodes.processes import NodeProcess, stamp_ns, wait_for
from support.erring import ERRORS, erring

from ddh_msgs.msg import ResidualArray

pytestmark = pytest.mark.live
SPACE = "/erring"


def test_the_node_compares_what_replay_compares(short_recording, listener, tmp_path):
    rig = load_rig().with_values(ERRORS)
    bag = write_recording(tmp_path / "bag", erring(short_recording))
    found = listener.collect(ResidualArray, f"{SPACE}/hydraulics/residuals")
    with NodeProcess("hydraulic_model", SPACE, rig=str(write_rig(tmp_path / "rig.yaml", rig)), flush_after=0.5) as node:
        with NodeProcess("bag_player", SPACE, bag=str(bag), rate=0.0, wait_for_nodes=["hydraulic_model"]) as player:
            assert player.ends() == 0, player.text
        wait_for(lambda: sum(m.source == "free_run" for m in found) >= 395, 20.0, "residuals")
        node.stop()
    result = replay(short_recording, load_rig())
    ends = np.rint(result.time * 1e9).astype(np.int64) + short_recording.epoch_ns
    for signal in ("current", "torque", "electrical_power", "rod_position", "rod_velocity", "pressure_piston_side"):
        for message in (m for m in found if m.source == "free_run"):
            k = np.searchsorted(ends, stamp_ns(message))
            row = next(r for r in message.residuals if r.signal == signal)
            assert row.measured == pytest.approx(result.measured[signal][k], rel=1e-9, abs=1e-9), (signal, k)
