"""Which messages of a bag are due when, what of its place is told meanwhile, and how long listeners held it up."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.bags.arrival import time_gone_by
from ddh_twin_py.nodes.player.flow_control import FlowControl
from ddh_twin_py.nodes.player.playback import Playback
from ddh_twin_py.sources.raw_bag import RawBlock

S = 1_000_000_000
TOPIC, LISTENER = "/ddh/drive/telemetry", "/ddh/listener"
STAMPS = np.arange(4000) * 10_000_000 + 10**18  # ns, 40 s
LOOK = 0.005  # s


class Bag:
    """Messages with these log times, ns, in blocks of 300; each message is its number."""

    def __init__(self, log_time):
        self._log_time, self._due = log_time, time_gone_by(log_time)[0]
        self.begin_ns, self.end_ns = int(self._due[0]), int(self._due[-1])
        self.duration = (self.end_ns - self.begin_ns) * 1e-9

    def blocks(self, start_ns):
        for rows in np.split(np.arange(self._due.size), range(300, self._due.size, 300)):
            rows = rows[self._due[rows] >= start_ns]
            if rows.size:
                yield RawBlock(np.zeros(rows.size, np.int64), self._log_time[rows], self._due[rows], rows.tolist())


class Played:
    """A bag played on a clock that the test moves, to one listener."""

    def __init__(self, rate, log_time=STAMPS, **how):
        self.now, self.sent, self.behind, self.flow = 0.0, [], 0, FlowControl(1.0)
        self.report(0)
        self.playback = Playback(Bag(log_time), self.flow, lambda: self.now, rate, **how)
        self.playback.start(self.now)

    def report(self, taken):
        """The listener has so many messages."""
        self.flow.report(LISTENER, {TOPIC: int(STAMPS[taken - 1]) if taken else 0}, self.now, taken)

    def send(self, block):
        for number, due in zip(block.messages, block.due.tolist(), strict=True):
            self.flow.sent(TOPIC, int(STAMPS[number]), due)
        self.sent += block.messages

    def look(self, seconds=LOOK):
        """A look at what is due so long after the last; which messages it sent."""
        before, self.now = len(self.sent), self.now + seconds
        self.playback.look(self.now)
        if not self.playback.paused:
            self.behind += self.playback.advance(self.now, self.send)
        return self.sent[before:]

    def taken_at_once(self, seconds):
        """Looks for so long, all taken as soon as it is sent; what was sent."""
        before = len(self.sent)
        for _ in range(round(seconds / LOOK)):
            if self.look():
                self.report(self.sent[-1] + 1)
        return self.sent[before:]


@pytest.mark.parametrize(("rate", "sent"), [(1.0, 200), (3.0, 600), (0.25, 50)])
def test_what_is_sent_follows_the_wall_clock_at_the_rate(rate, sent):
    played = Played(rate)
    assert len(played.taken_at_once(2.0)) == pytest.approx(sent, abs=1) and played.sent == list(range(len(played.sent)))
    assert played.playback.position == pytest.approx(2.0 * rate)
    assert played.playback.since_begin(played.now) == pytest.approx((2.0 * rate, 2.0))


def test_full_speed_sends_bursts_until_the_listener_is_a_lead_behind():
    played = Played(0.0)
    assert played.look() == list(range(26)) and played.look() == list(range(26, 51))  # 0.25 s each
    for _ in range(10):
        played.look()
    assert played.playback.position == pytest.approx(1.0) and len(played.sent) == 101
    played.report(50)
    assert played.look()[-1] == 125 and played.look()[-1] == 150 and played.look() == []
    assert not played.behind  # there is no rate to be behind


def test_where_the_recorders_clock_was_set_back_the_rate_is_kept():
    log_times = STAMPS.copy()
    log_times[2000:] -= 10 * S
    played, most = Played(1.0, log_times), 0
    assert played.playback.duration == pytest.approx(39.98)
    while not played.playback.sent_all and played.now < 60.0:
        most = max(most, len(played.look()))
        played.report(len(played.sent))
    assert most <= 2 and len(played.sent) == 4000 and played.now == pytest.approx(40.0, abs=0.1)
    assert played.playback.position == pytest.approx(played.playback.duration)


def test_a_place_ahead_of_what_was_sent_is_never_told():
    """A listener that takes 6 times real time where 100 are asked for."""
    played, taken = Played(100.0), 0
    while not played.playback.sent_all and played.now < 20.0:
        played.look()
        if len(played.sent) < STAMPS.size:
            assert played.playback.stamp_ns < STAMPS[len(played.sent)]
        taken = min(len(played.sent), taken + 3)
        played.report(taken)
    assert played.now == pytest.approx(40.0 / 6.0, rel=0.05) and len(played.sent) == STAMPS.size
    assert played.behind and played.flow.held_by(played.now, 100.0)[0] == "slow"


def test_what_a_slow_listener_delayed_is_not_caught_up_once_it_is_a_second():
    played = Played(1.0)
    while not played.behind:
        played.look()
    assert played.now == pytest.approx(2.0, abs=0.02) and len(played.sent) == 101  # 1 s of lead, 1 s behind
    played.report(101)
    assert len(played.taken_at_once(1.0)) == pytest.approx(100, abs=2)


def test_after_a_pause_it_goes_on_from_where_it_stood():
    played = Played(1.0)
    played.taken_at_once(1.0)
    played.playback.pause(True)
    assert played.taken_at_once(5.0) == [] and played.playback.position == pytest.approx(1.0)
    played.playback.pause(False)
    assert len(played.taken_at_once(1.0)) == pytest.approx(100, abs=1) and played.sent == list(range(len(played.sent)))


def test_another_rate_holds_from_then_on():
    played = Played(1.0)
    played.taken_at_once(1.0)
    played.playback.set_rate(4.0)
    played.taken_at_once(1.0)
    assert played.playback.position == pytest.approx(5.0) and played.sent == list(range(len(played.sent)))


def test_a_seek_passes_over_what_lies_between_and_asks_nothing_of_what_was_sent():
    played = Played(0.0)
    for _ in range(10):
        played.look()
    assert played.look() == []  # a lead ahead
    played.playback.seek(30.0)
    assert played.playback.position == pytest.approx(30.0) and played.look()[0] == 3000
    assert played.playback.since_begin(played.now) == pytest.approx((0.25, LOOK))


def test_a_round_begins_at_the_offset_and_is_counted():
    played = Played(0.0, offset=39.0)
    while not played.playback.sent_all:
        played.taken_at_once(LOOK)
    assert played.sent == list(range(3900, 4000)) and played.playback.position == played.playback.duration
    played.playback.ended = True
    assert played.playback.next_round() == 2 and played.playback.next_round() == 3
    assert played.playback.position == pytest.approx(39.0) and not played.playback.sent_all and not played.playback.ended
    assert played.look()[0] == 3900


def test_time_before_the_start_is_none_that_is_behind():
    now = 0.0
    playback = Playback(Bag(STAMPS), FlowControl(1.0), lambda: now, 1.0)
    assert playback.waiting
    now = 20.0
    playback.start(now)
    sent = []
    playback.advance(20.1, lambda block: sent.extend(block.messages))
    assert not playback.waiting and playback.begun == 20.0 and sent == list(range(11))


def test_looks_that_come_late_count_with_the_time_that_went_by():
    """At full speed, on a clock that only sending and `at` move."""
    now, flow = 0.0, SimpleNamespace(jumped=lambda: None, limit=lambda: limit)
    bag = SimpleNamespace(begin_ns=0, end_ns=9 * S, duration=9.0, blocks=lambda start: iter([RawBlock(due, due, due, list(due))]))
    due, limit = np.arange(0, 9 * S, S // 100), None
    playback = Playback(bag, flow, lambda: now, 0.0)

    def send(block):
        nonlocal now
        now += 0.1

    def at(wall, allowed, paused=False):
        nonlocal now, limit
        now, limit = wall, allowed
        playback.look(wall)
        if not paused:
            playback.advance(wall, send)
        return playback.held

    assert at(1.0, None) == at(1.5, 10**9) == 0.0  # all that was due was sent
    assert at(2.0, 6 * 10**8) == 0.0  # 0.1 s of sending, then it waits
    assert at(2.5, 6 * 10**8) == pytest.approx(0.4)  # nothing to send: it waits on
    assert at(3.5, None) == pytest.approx(1.4)
    assert at(4.0, 0) == pytest.approx(1.4)
    assert at(4.005, 0, paused=True) == at(9.0, 0, paused=True) == pytest.approx(1.405)
    assert at(9.005, None) == pytest.approx(1.405)
