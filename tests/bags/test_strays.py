"""A few stamps that are far from all others cost neither time nor memory: they are left out and said to be."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.gap.recordings.contradictions import contradictions
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.alignment.recording_ticks import align
from ddh_twin_py.telemetry.clocks.strays import strays
from ddh_twin_py.telemetry.recording import Stream

DAY = 86400.0
DRIVE, OIL = "drive/telemetry", "temperature/tank_oil"


@pytest.fixture(scope="module")
def sound(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 40.0)


def moved(recording, by, where=None):
    """Stamps moved by so many seconds where a rule of topic and times says so; everywhere without one."""
    streams = {topic: Stream(s.time + np.where(where(topic, s.time) if where else True, by(s.time) if callable(by) else by, 0.0),
                             s.values, s.fields) for topic, s in recording.streams()}
    return recording.with_streams(streams)


def last_of(*topics):
    return lambda topic, time: (topic in topics) & (time == time.max())


CASES = {
    "the last ten days ahead": (10 * DAY, last_of(DRIVE, "hydraulics/telemetry"), DRIVE, 1, "after"),
    "two in the middle five days ahead": (
        5 * DAY, lambda t, time: (t == DRIVE) & np.isin(np.arange(time.size), [500, 1500]), DRIVE, 2, "after"),
    "one a day behind": (-DAY, lambda t, time: (t == OIL) & (np.arange(time.size) == 5), OIL, 1, "before"),
}


@pytest.mark.parametrize("name", CASES)
def test_stray_stamps_are_left_out_of_every_recording(tmp_path, sound, name):
    by, where, topic, count, side = CASES[name]
    read = read_recording(write_recording(tmp_path / "bag", moved(sound, by, where)))
    (finding,) = [f for f in read.findings if "far " in f.message and f.topic == f"/ddh/{topic}"]
    assert finding.count == count and f"far {side} all others" in finding.message and str(tmp_path / "bag") in finding.message
    stamp = sound.epoch_ns * 1e-9 + by
    assert finding.value == pytest.approx(stamp, abs=60.0) and f"{finding.value:.3f} s" in finding.message
    assert read.duration < 41.0 and read.epoch_ns == pytest.approx(sound.epoch_ns, abs=2e9)
    assert contradictions(read, load_rig()) == contradictions(sound, load_rig())
    intervals = len(align(sound))
    for worked_over in (align(read), replay(read, load_rig()).time, Experiment(read, load_rig()).axis):
        assert intervals - 1 <= len(worked_over) <= intervals


def test_what_is_no_stray(sound):
    stamps = {topic: s.stamps(sound.epoch_ns) for topic, s in sound.streams()}
    assert not any(here.any() for here in strays(stamps).values())
    late = stamps | {OIL: np.append(stamps[OIL][stamps[OIL] < stamps[OIL][0] + 10**9], stamps[OIL][-1] + 70 * 10**9)}
    longer = late | {DRIVE: stamps[DRIVE] * 1 + 0}
    longer[DRIVE] = np.concatenate([stamps[DRIVE], stamps[DRIVE] + 40 * 10**9])
    assert not strays(longer)[OIL].any(), "a sensor that comes back while others went on"
    paused = {topic: np.where(s > s[0] + 20 * 10**9, s + 72000 * 10**9, s) for topic, s in stamps.items()}
    assert not any(here.any() for here in strays(paused).values()), "a pause"
    rare = {OIL: np.arange(5) * 90 * 10**9}
    assert not strays(rare)[OIL].any(), "a sensor that comes seldom"
    assert not strays({OIL: np.empty(0, np.int64)})[OIL].size


def test_a_pause_of_twenty_hours_stays_and_costs_what_its_messages_cost(tmp_path, sound):
    paused = read_recording(write_recording(tmp_path / "bag", moved(sound, 20 * 3600.0, lambda t, time: time > 20.0)))
    assert paused.duration > 72000.0 and not [f for f in paused.findings if "far " in f.message]
    assert contradictions(paused, load_rig()) == contradictions(sound, load_rig())
    result = replay(paused, load_rig())
    assert len(result.time) == pytest.approx(sound.duration / 0.05, abs=5) and result.time[-1] > 72000.0


def test_a_pause_at_every_turn_makes_no_recording_endless(sound):
    often = moved(sound, lambda time: 3600.0 * np.floor(5.0 * time))
    assert len(align(often)) < 1500
    assert contradictions(often, load_rig()) == []
    few = moved(sound, lambda time: 3600.0 * np.floor(0.1 * time))
    assert len(align(few)) == pytest.approx(40.0 / 0.05, abs=8)


def test_stamps_that_jump_back_and_ahead_make_none_endless(sound):
    drive = sound.drive
    wild = replace(sound, drive=Stream(drive.time + np.where(np.arange(drive.time.size) % 5 == 4, DAY, 0.0), drive.values, drive.fields))
    assert len(align(wild)) < 110_000
