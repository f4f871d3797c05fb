"""A clock that is set ahead while the rod moves, told from messages that are lost."""

import numpy as np
import pytest
from ddh_twin_py.bags.damage import with_clock_jump, without_samples
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.clocks.set_ahead import clock_set_ahead, set_ahead
from ddh_twin_py.telemetry.recording import Stream
from ddh_twin_py.telemetry.screening.screening import screen_recording
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC

MOVING = 57.0  # s of the paper's cycle, at which the rod is lifted


@pytest.fixture(scope="module")
def cycles(paper):
    return paper.between(0.0, 120.0)


def lost(recording, at, seconds):
    """The same without what all topics told for so long."""
    for topic, _ in recording.streams():
        recording = without_samples(recording, topic, at, at + seconds)
    return recording


def moves(recording, at):
    return abs(np.interp(at, recording.hydraulic.time, recording.hydraulic.column("rod_velocity"))) > 0.02


def test_it_is_told_and_what_is_lost_is_not(cycles, noise):
    at = next(t for t in np.arange(MOVING, 100.0, 0.5) if moves(cycles, t) and moves(cycles, t + 0.5))
    screened = screen_recording(with_clock_jump(cycles, at, 2.0), noise)
    (finding,) = [f for f in screened.findings if f.field == "header.stamp"]
    assert finding.severity == "warning" and (finding.value, finding.first_time) == pytest.approx((2.0, at), abs=0.02)
    assert finding.message.startswith(f"{cycles.path}: the clock was set ahead by 2.0 s at {at:.1f} s: /ddh/{HYDRAULIC_TOPIC} has no stamp")
    assert not clock_set_ahead(cycles) and not clock_set_ahead(without_samples(cycles, DRIVE_TOPIC, at, at + 2.0))
    for seconds in (0.3, 1.0, 2.0, 5.0, 9.0):
        assert not [f for when in np.arange(10.0, 100.0, 3.1) for f in set_ahead(lost(cycles, when, seconds).hydraulic)], seconds


def test_a_stream_that_comes_once_a_second_is_not_set_ahead(paper):
    """The paper's cycle at 1 Hz, whatever the sample that it begins with."""
    drive, hydraulic = paper.drive, paper.hydraulic
    step = round(1.0 / float(np.median(np.diff(hydraulic.time))))
    for begin in range(0, step, 7):
        seldom = Stream(hydraulic.time[begin::step], hydraulic.values[begin::step], hydraulic.fields)
        assert not set_ahead(seldom).size, begin
        slow = Stream(drive.time[begin::step], drive.values[begin::step], drive.fields)
        assert not clock_set_ahead(paper.with_streams({DRIVE_TOPIC: slow, HYDRAULIC_TOPIC: seldom}))


def test_what_is_fast_is_not_compared_until_the_rod_is_placed_anew(cycles):
    at = next(t for t in np.arange(MOVING, 100.0, 0.5) if moves(cycles, t) and moves(cycles, t + 0.5))
    sound, stepped = (Experiment(recording, load_rig()) for recording in (cycles, with_clock_jump(cycles, at, 2.0)))
    assert sum(sound.left_out.values()) < 2.0 < sum(stepped.left_out.values())
    speed = stepped.signals["speed"]
    kept = np.isfinite(speed.measured)
    assert not kept[(speed.time > at + 0.1) & (speed.time < at + 4.0)].any() and kept[speed.time < at - 0.3].all()
