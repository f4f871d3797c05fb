"""What the player sends by when, and what it tells of its place meanwhile."""

import numpy as np
import pytest
from ddh_twin_py.bags.cdr import encode_stamped_floats
from ddh_twin_py.bags.qos import SENSOR_DATA
from ddh_twin_py.bags.writer import BagWriter
from ddh_twin_py.nodes.bag_player import BagPlayer, Channel
from ddh_twin_py.nodes.player.flow_control import FlowControl
from ddh_twin_py.sources.raw_bag import RawBag

TOPIC, LISTENER = "/ddh/drive/telemetry", "/ddh/listener"
STAMPS = np.arange(4000) * 10_000_000 + 10**18  # ns, 40 s
LOOK = 0.005  # s


class Publisher:
    topic_name = TOPIC

    class qos_profile:
        durability = 0

    def publish(self, message):
        pass


class Player(BagPlayer):
    """A player without a node, on a clock that the test moves, with one topic and one listener."""

    def __init__(self, bag, rate):
        self._bag, self.rate, self.paused, self._flow = bag, rate, False, FlowControl(1.0)
        self.now, self.sent, self._held_since, self.said = 0.0, 0, None, []
        self._channels = {0: Channel(Publisher(), True)}
        self.report(0)
        self._begin(0.0)

    def report(self, taken):
        newest = int(STAMPS[taken - 1]) if taken else 0
        self._flow.report(LISTENER, {TOPIC: newest}, self.now, taken)

    def look(self):
        """A look at what is due; how many messages it sent."""
        before, self.now = self.sent, self.now + LOOK
        self._advance(self.now)
        return self.sent - before

    def wall(self):
        return self.now

    def _say(self, wall):
        self._said_at = wall

    def warn_once(self, cause, text):
        self.said += [text] if text not in self.said else []


def bag_of(path, log_times, messages=None):
    """A bag of drive telemetry with these log times, ns; `messages` by number are others than they should be."""
    rows = encode_stamped_floats(STAMPS, np.zeros((STAMPS.size, 6)))
    with BagWriter(path) as writer:
        for i, at in enumerate(log_times.tolist()):
            writer.write_raw(TOPIC, "ddh_msgs/msg/DriveTelemetry", SENSOR_DATA, at, (messages or {}).get(i, rows[i].data))
    return RawBag(path)


def test_where_the_recorders_clock_was_set_back_the_rate_is_kept(tmp_path):
    log_times = STAMPS.copy()
    log_times[2000:] -= 10 * 10**9
    player, most = Player(bag_of(tmp_path / "bag", log_times), 1.0), 0
    assert player.duration == pytest.approx(39.98)
    while not player._ending and player.now < 60.0:
        most = max(most, player.look())
        player.report(player.sent)
    assert most <= 2 and player.sent == 4000 and player.now == pytest.approx(40.0, abs=0.1)
    assert player.position == pytest.approx(player.duration)
