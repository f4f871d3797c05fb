"""Channels that cannot both be right are told live, once two looks say so, and no more once they agree again."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.nodes.tasks.contradiction_watch import ContradictionWatch
from ddh_twin_py.nodes.tasks.health import Report
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.alignment.recording_ticks import align
from diagnostic_msgs.msg import DiagnosticStatus
from support.simulated import simulated


@pytest.fixture(scope="module")
def recording():
    return simulated(1, "mixed", 900.0)[0]


@pytest.fixture
def made():
    """A watch and what it warned of."""
    said = {}
    node = SimpleNamespace(warn_once=said.setdefault, get_namespace=lambda: "/ddh")
    return ContradictionWatch(node, load_rig()), said


def fed(watch, recording):
    """What it tells after each second of the recording, by second."""
    ticks, told = align(recording), {}
    for number in range(0, len(ticks), 20):
        watch.add([ticks.tick(i) for i in range(number, min(number + 20, len(ticks)))])
        told[number // 20] = watch.said
    return told


def swapped(recording, begin, end):
    own = recording.hydraulic
    values, at = own.values.copy(), [own.fields.index(f"pressure_{side}") for side in ("piston_side", "rod_side")]
    rows = (own.time >= begin) & (own.time < end)
    values[np.ix_(rows, at)] = values[np.ix_(rows, at[::-1])]
    return replace(recording, hydraulic=replace(own, values=values))


def test_sound_telemetry_is_not_suspected(made, recording):
    watch, said = made
    assert not any(fed(watch, recording).values()) and not said


def test_exchanged_pressures_are_told_and_no_more_once_they_are_put_right(made, recording):
    watch, said = made
    told = fed(watch, swapped(recording, 0.0, 400.0))
    first, last = min(s for s in told if told[s]), max(s for s in told if told[s])
    assert 180 < first < 310 and 400 < last < 800
    assert "/ddh/hydraulics/telemetry" in told[first][0] and "connectors are likely swapped" in told[first][0] and len(said) == 1
    report = Report("channels", "")
    assert watch.judge(report) and report.status.level == DiagnosticStatus.OK


def test_what_is_told_is_a_warning_in_the_health(made, recording):
    watch, _ = made
    own = recording.hydraulic
    values = own.values * np.where(np.array(own.fields) == "rod_velocity", -1.0, 1.0)
    values[:, own.fields.index("rod_position")] = 0.4 - own.values[:, own.fields.index("rod_position")]
    fed(watch, replace(recording, hydraulic=replace(own, values=values)))
    report = Report("channels", "")
    watch.judge(report)
    status = report.finished("")
    assert status.level == DiagnosticStatus.WARN and "has the wrong sign" in status.message


def test_what_was_told_before_a_jump_is_not_held_against_what_comes_after(made, recording):
    watch, _ = made
    ticks = align(swapped(recording, 0.0, 900.0))
    for number in range(len(ticks)):
        tick = ticks.tick(number)
        watch.add([replace(tick, restart=number % 3000 == 0)])  # each 150 s
    assert watch.said == []
