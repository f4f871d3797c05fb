"""What open signals point to, and when they do not tell."""

from dataclasses import replace

import pytest
from ddh_twin_py.gap.watch.pointing import PISTON, ROD, pointed_component
from ddh_twin_py.gap.watch.running_test import SignalStatus
from ddh_twin_py.rig import load_rig

NAMES = ("current", PISTON, ROD, "temperature/motor_winding", "temperature/motor_housing", "temperature/tank_oil")
FLOORS = {"current": 0.1, PISTON: 2e4, ROD: 2e4}


@pytest.fixture(scope="module")
def rig():
    return load_rig(None)


def statuses(**changes):
    """All tested and closed; `changes` name signals by the last part of their name."""
    made = []
    for name in NAMES:
        status = SignalStatus(name, 1.0, FLOORS.get(name, 0.2), threshold=6.0, detectable=FLOORS.get(name, 0.2))
        made.append(replace(status, **changes.get(name.split("/")[-1], {})))
    return made


def opened(size):
    return {"opened": True, "statistic": 9.0, "size": size, "size_deviation": 0.1 * abs(size)}


@pytest.mark.parametrize(
    ("changes", "component", "words"),
    [
        ({}, "", ""),
        ({PISTON: opened(3e5)}, "sensor", "a real one would move current by 0.68 A"),
        ({PISTON: opened(3e4)}, "", "too little"),
        ({PISTON: opened(3e5), "current": {"threshold": float("nan")}}, "", "current is not tested yet"),
        ({PISTON: opened(3e5), "current": opened(0.7)}, "", "more than one component"),
        ({ROD: opened(-1e5)}, "sensor", f"would move {PISTON} by 7.5e+04 Pa"),
        ({"motor_winding": opened(3.0), "motor_housing": opened(2.0)}, "motor", "depart together"),
        ({"motor_winding": opened(3.0), "motor_housing": opened(-2.0)}, "", "more than one component"),
        ({"motor_winding": opened(3.0), "motor_housing": opened(2.0), "tank_oil": opened(1.0)}, "", "more than one"),
        ({"motor_winding": opened(3.0)}, "", "more than one component"),
    ],
)
def test_component(rig, changes, component, words):
    found, because = pointed_component(statuses(**changes), rig)
    assert found == component and words in because and bool(because) == bool(changes)
