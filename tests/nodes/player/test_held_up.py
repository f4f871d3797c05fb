"""How long the graph held the player up: the time that went by, however late a look comes."""

from types import SimpleNamespace

import pytest
from ddh_twin_py.nodes.bag_player import BagPlayer


class Looks:
    """The player's look at what is due, at full speed, on a clock that only sending and `at` move."""

    def __init__(self):
        self.now = 0.0
        flow = SimpleNamespace(limit=lambda: self.limit, keep=lambda running: None, given_up=lambda wall: [])
        self.player = player = SimpleNamespace(
            wall=lambda: self.now, _take_progress=lambda wall: None, _running=list, _say=lambda wall: None, values={"clock_rate": 0.0},
            rate=0.0, paused=False, _playing=True, _ending=False, _flow=flow, _checked_at=0.0, _said_at=0.0,
            _position_ns=0, _held=0.0, _anchor_ns=0, _anchor_wall=0.0,
            _held_since=None, _send_until=self.send, _advance=lambda wall: BagPlayer._advance(player, wall),
        )  # fmt: skip

    def send(self, due):
        self.player._position_ns = due
        self.now += 0.1

    def at(self, now, limit, paused=False):
        self.now, self.limit, self.player.paused = now, limit, paused
        BagPlayer._step(self.player)
        return self.player._held


def test_looks_that_come_late_count_with_the_time_that_went_by():
    looks = Looks()
    assert looks.at(1.0, None) == looks.at(1.5, 10**9) == 0.0  # all that was due was sent
    assert looks.at(2.0, 6 * 10**8) == 0.0  # 0.1 s of sending, then it waits
    assert looks.at(2.5, 6 * 10**8) == pytest.approx(0.4)  # nothing to send: it waits on
    assert looks.at(3.5, None) == pytest.approx(1.4)
    assert looks.at(4.0, 0) == pytest.approx(1.4)
    assert looks.at(4.005, 0, paused=True) == looks.at(9.0, 0, paused=True) == pytest.approx(1.405)
    assert looks.at(9.005, None) == pytest.approx(1.405)
