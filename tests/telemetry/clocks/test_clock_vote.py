"""The vote on clocks by itself, and what a clock costs that is outvoted."""

import numpy as np
import pytest
from ddh_twin_py.telemetry.alignment.tick_aligner import TickAligner
from ddh_twin_py.telemetry.clocks.clock_vote import ClockVote
from ddh_twin_py.telemetry.clocks.stream_line import Doubt, Line

EPOCH = 1_772_000_000_000_000_000
SECOND = 1_000_000_000
DRIVE, HYDRAULICS = "drive/telemetry", "hydraulics/telemetry"


def told(*stamps):
    """A stream that told by the clock of all at some s, one push after the other."""
    line = Line(1, awaited=True, follows=False)
    for number, stamp in enumerate(stamps, 1):
        line.rise(round(stamp * SECOND), None, number)
        line.told += 1
    return line


def doubted(line, *stamps):
    """The same stream after it told other stamps, s, from push 100 on."""
    doubt = Doubt(round(stamps[0] * SECOND), [0.0], 100, line.newest)
    for stamp in stamps:
        doubt.add(round(stamp * SECOND), [0.0])
    line.doubt = doubt
    return line


def verdict(line, *others, last=False):
    lines = dict(enumerate((line, *others)))
    return ClockVote(lines, window=SECOND // 2, timeout=2 * SECOND).verdict(line, last)


def fast(begin):
    return np.arange(begin, begin + 10.0, 0.1)


def test_a_stream_alone_is_believed_and_one_against_one_that_goes_on_is_not():
    other = told(*fast(100.0))
    other.rise(112 * SECOND, 110 * SECOND, 101)
    assert verdict(doubted(told(*fast(100.0)), *fast(40.0))) is True
    assert verdict(doubted(told(*fast(100.0)), *fast(40.0)), other) is False


def test_streams_that_tell_one_clock_outvote_one_that_goes_on_and_those_of_two_clocks_do_not():
    goes_on = told(*fast(100.0))
    goes_on.rise(112 * SECOND, 110 * SECOND, 101)
    line = doubted(told(*fast(100.0)), *fast(40.0))
    assert verdict(line, doubted(told(*fast(100.0)), *fast(41.0)), goes_on) is True
    assert verdict(line, doubted(told(*fast(100.0)), *fast(70.0)), goes_on) is False


def test_a_vote_is_open_while_a_stream_had_no_time_to_speak_unless_it_is_the_last():
    line, slow = doubted(told(*fast(100.0)), 40.0, 41.0), told(100.0, 104.0, 108.0)
    assert verdict(line, slow) is None
    assert verdict(line, slow, last=True) is True
    line.doubt.add(49 * SECOND, [0.0])
    assert verdict(line, slow) is True


def test_what_is_seconds_late_is_no_clock():
    line = doubted(told(*fast(100.0)), 107.0, 107.4, 107.9)
    assert verdict(line) is None and verdict(line, last=True) is None


@pytest.mark.parametrize(("ahead", "lag", "leaps"), [(1.9, 0.0, False), (2.3, 0.0, True), (700.0, 0.0, True),
                                                     (9.0, 8.0, False), (11.0, 8.0, True)])  # fmt: skip
def test_a_stream_leaps_where_it_leaves_out_seconds_by_which_no_other_lags(ahead, lag, leaps):
    line, other = told(*fast(100.0)), told(*fast(100.0))
    other.rise(110 * SECOND, round((110 + lag) * SECOND), 101)
    vote = ClockVote({"drive": line, "hydraulics": other}, window=SECOND // 2, timeout=2 * SECOND)
    assert vote.leaps(line, line.newest + round(ahead * SECOND), line.newest) is leaps


def test_a_stream_that_was_silent_for_long_or_has_nobody_beside_it_leaps_by_no_seconds():
    line, other = told(*fast(100.0)), told(*fast(100.0))
    vote = ClockVote({"drive": line, "hydraulics": other}, window=SECOND // 2, timeout=2 * SECOND)
    other.rise(130 * SECOND, 130 * SECOND, 101)
    assert not vote.leaps(line, 135 * SECOND, other.newest)
    assert not ClockVote({"drive": line}, SECOND // 2, 2 * SECOND).leaps(line, 115 * SECOND, line.newest)


def test_streams_that_all_are_slow_do_not_leap_with_each_sample():
    line = told(100.0, 112.0, 124.0)
    vote = ClockVote({"ambient": line}, window=SECOND // 2, timeout=SECOND)
    assert not vote.leaps(line, 136 * SECOND, line.newest) and vote.leaps(line, 150 * SECOND, line.newest)


def test_what_was_held_back_before_the_begin_is_no_other_clock():
    """All but the drive come 15 s late at first, and have caught up soon."""
    names = (DRIVE, HYDRAULICS, "temperature/ambient")
    aligner, ticks = TickAligner(dict.fromkeys(names, 1), timeout=2.0, awaited=[DRIVE, HYDRAULICS]), []
    for t in range(1, 3000):  # 20 ms
        for name in names:
            for late in range(4 if name != DRIVE and t < 250 else 1):
                behind = max(0, 750 - 3 * t) if name != DRIVE else 0
                aligner.push(name, EPOCH + (t - behind) * 20_000_000 - (3 - late) * 20_000_000 * (behind > 0), [0.0])
        ticks += aligner.ready()
    ticks += aligner.flush()
    assert not any(tick.restart for tick in ticks) and not any(cause == "clock_jump" for _, cause in aligner.counts)
    assert told_from(ticks, DRIVE, 0, 60) == 2999


@pytest.mark.parametrize(("others", "believed"), [(0, False), (1, True), (3, True)])
def test_streams_that_lie_behind_all_since_they_began_are_believed_where_they_are_more(others, believed):
    ahead, behind = told(*fast(100.0)), []
    for _ in range(1 + others):
        line = told()
        for number, stamp in enumerate(fast(40.0)):
            line.rise(round(stamp * SECOND), round((stamp + 60.0) * SECOND), number)
        behind.append(line)
    vote = ClockVote(dict(enumerate((ahead, *behind))), window=SECOND // 2, timeout=2 * SECOND)
    assert vote.outvotes(behind[0], behind[0].newest, ahead.newest) is believed
    assert not vote.outvotes(behind[0], behind[0].newest, ahead.newest + 20 * SECOND), "nor where they fall behind further"


def parted(off, sensors=("temperature/ambient",), back=40.0):
    """Ticks of 60 s of drive, hydraulics and sensors, those of `off` so many s off from 20 s until `back`; and the aligner."""
    aligner, ticks = TickAligner(dict.fromkeys((DRIVE, HYDRAULICS, *sensors), 1), timeout=2.0, awaited=[DRIVE, HYDRAULICS]), []
    for t in range(1, 3000):  # 20 ms
        for name in (DRIVE, HYDRAULICS, *(sensors if t % 50 == 0 else ())):
            by = off.get(name, 0.0) if 20.0 < 0.02 * t <= back else 0.0
            aligner.push(name, EPOCH + t * 20_000_000 + round(by * SECOND), [0.0])
        ticks += aligner.ready()
    return ticks + list(aligner.flush()), aligner


@pytest.mark.parametrize("ahead", [3.0, 5.0, 8.0, 11.0, 15.0, 19.0])
@pytest.mark.parametrize("alone", [DRIVE, "temperature/ambient"])
def test_a_clock_some_seconds_ahead_costs_no_other_stream_anything(alone, ahead):
    ticks, aligner = parted({alone: ahead})
    assert not any(tick.restart for tick in ticks)
    assert {name for name, _ in aligner.counts} == {alone}
    assert aligner.strayed[alone, "other_clock"] == pytest.approx(ahead * SECOND, abs=SECOND)


def told_from(ticks, stream, begin, end):
    """Samples of a stream in the ticks of some s."""
    return sum(len(tick.samples[stream]) for tick in ticks if EPOCH + begin * SECOND < tick.end_ns <= EPOCH + end * SECOND)


@pytest.mark.parametrize("sensors", [(), ("temperature/ambient",)])
@pytest.mark.parametrize("alone", [DRIVE, HYDRAULICS])
@pytest.mark.parametrize("behind", [-2.6, -4.0, -6.4, -8.0])
def test_a_clock_that_was_put_back_some_seconds_is_no_lag(behind, alone, sensors):
    ticks, aligner = parted({alone: behind}, sensors)
    assert not any(tick.restart for tick in ticks)
    assert {name for name, _ in aligner.counts} == {alone}
    assert aligner.strayed[alone, "other_clock"] == pytest.approx(behind * SECOND, abs=SECOND)
    assert told_from(ticks, alone, 20, 40) == 0 and told_from(ticks, alone, 40, 60) == 999
    (other,) = {DRIVE, HYDRAULICS} - {alone}
    assert told_from(ticks, other, 0, 60) == 2999


@pytest.mark.parametrize("sensors", [(), ("temperature/ambient",)])
@pytest.mark.parametrize("pauses", [(DRIVE,), (DRIVE, HYDRAULICS, "temperature/ambient")])
@pytest.mark.parametrize("lag", [0.0, 5.0])
@pytest.mark.parametrize("pause", [3.0, 8.0, 15.0])
def test_a_pause_of_one_or_of_all_is_no_step_of_a_clock(pause, lag, pauses, sensors):
    """Hydraulics come so late. Nothing is lost; of what lags where all pause, what was waited for."""
    names = (DRIVE, HYDRAULICS, *sensors)
    aligner, ticks = TickAligner(dict.fromkeys(names, 1), timeout=2.0, awaited=[DRIVE, HYDRAULICS]), []
    sent = [(0.02 * t + lag * (name == HYDRAULICS), 0.02 * t, name) for t in range(1, 3000) for name in names
            if (t % 50 == 0 or "ambient" not in name) and not (name in pauses and 30.0 < 0.02 * t < 30.0 + pause)]
    for _, t, name in sorted(sent):
        aligner.push(name, EPOCH + round(t * SECOND), [0.0])
        ticks += aligner.ready()
    ticks += aligner.flush()
    assert not any(cause in ("other_clock", "clock_jump") for _, cause in aligner.counts)
    for name in names if not lag or len(pauses) == 1 else pauses[:1]:
        assert told_from(ticks, name, 10, 60) == sum(t > 10.0 for _, t, sender in sent if sender == name)


def test_after_a_pause_of_all_a_slow_sensor_is_not_waited_for():
    aligner, ticks = TickAligner(dict.fromkeys((DRIVE, HYDRAULICS, "temperature/ambient"), 1), awaited=[DRIVE, HYDRAULICS]), []
    for t in range(1, 3000):  # 20 ms
        if not 30.0 < 0.02 * t < 35.0:
            for name in (DRIVE, HYDRAULICS, *(("temperature/ambient",) if t % 400 == 0 else ())):
                aligner.push(name, EPOCH + t * 20_000_000, [0.0])
            ticks += aligner.ready()
            if 38.0 < 0.02 * t < 60.0:
                assert ticks[-1].end_ns > EPOCH + (0.02 * t - 1.0) * SECOND


@pytest.mark.parametrize(("one", "other"), [(-3600.0, -60.0), (-60.0, -3600.0), (-8.0, -60.0), (-60.0, 60.0)])
def test_of_two_streams_that_jump_to_two_clocks_one_is_believed_and_the_other_named(one, other):
    ticks, aligner = parted({DRIVE: one, HYDRAULICS: other}, sensors=(), back=60.0)
    (restart,) = [tick for tick in ticks if tick.restart]
    assert restart.gap == pytest.approx(one, abs=0.2)
    assert sum(len(tick.samples[DRIVE]) for tick in ticks) == 2999
    assert aligner.counts[HYDRAULICS, "other_clock"] > 1800 and not aligner.counts[HYDRAULICS, "clock_jump"]
