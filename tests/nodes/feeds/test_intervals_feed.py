"""What a model is given where stamps do not go on."""

import pytest
from ddh_twin_py.nodes.feeds.intervals_feed import IntervalsFeed
from ddh_twin_py.telemetry.ticks import Tick

STEP_NS = 50_000_000
START = 1.0  # s, 20 ticks


def ticks(first, last, after=None):
    """Ticks first..last; those that do not follow the one before, ``after``, begin anew."""
    gap = 0.0 if after is None else (first - after) * STEP_NS * 1e-9
    return [Tick(i * STEP_NS, (i + 1) * STEP_NS, i == first and after is not None, {}, gap * (i == first)) for i in range(first, last)]


def batches(feed, given):
    """How each batch begins, and how long it is, of ticks that come one by one."""
    return [(b.first, b.put_back, len(b)) for tick in given for b in feed.add([tick])]


@pytest.fixture
def feed():
    fed = IntervalsFeed(0.05, START)
    batches(fed, ticks(1000, 1100))
    return fed


def test_a_start_waits_for_its_readings_and_what_follows_comes_at_once():
    said = batches(IntervalsFeed(0.05, START), ticks(1000, 1030))
    assert said[0] == (True, False, 21) and said[1:] == [(False, False, 1)] * 8


def test_where_a_clock_was_put_back_a_little_nothing_waits(feed):
    said = batches(feed, ticks(1040, 1050, after=1100))
    assert said[:2] == [(False, False, 1), (True, True, 1)] and said[2:] == [(False, False, 1)] * 8


@pytest.mark.parametrize("back", [500, 2000])
def test_where_stamps_are_of_another_time_a_start_waits_again(feed, back):
    said = batches(feed, ticks(1100 - back, 1130 - back, after=1100) if back < 1100 else ticks(back, back + 30, after=1100))
    assert said[:2] == [(False, False, 1), (True, False, 21)]


def test_another_unit_begins_anew_though_its_clock_was_put_back(feed):
    feed.begin_anew()
    said = batches(feed, ticks(1040, 1070, after=1100))
    assert (True, True) not in {batch[:2] for batch in said} and said[-1] == (False, False, 1)


def test_a_clock_put_back_while_a_start_is_waited_for_goes_on_from_what_was_told():
    said = batches(IntervalsFeed(0.05, START), [*ticks(1000, 1010), *ticks(960, 990, after=1010)])
    assert said[:2] == [(True, False, 10), (True, True, 1)] and said[2:] == [(False, False, 1)] * 28
