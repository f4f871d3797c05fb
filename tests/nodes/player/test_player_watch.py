"""While a bag player plays, what a slow node holds up is waited for."""

from types import SimpleNamespace

import pytest
from ddh_twin_py.nodes.player.player_watch import GONE, PlayerWatch

from ddh_msgs.msg import PlayerStatus


class Heard:
    """A node that hears one player."""

    players = 1

    def create_subscription(self, kind, topic, take, profile):
        self.take = take
        return SimpleNamespace(topic_name=f"/ddh/{topic}")

    def count_publishers(self, topic):
        return self.players if topic == "/ddh/bag_player/status" else 0

    def wall(self):
        return 100.0


@pytest.mark.parametrize(("told", "wall", "plays", "paused"), [
    ({}, 100.0, True, False), ({}, 100.1 + GONE, False, False), ({"ended": True}, 100.0, False, False),
    ({"paused": True}, 100.0, False, True), ({"paused": True, "ended": True}, 100.0, False, False),
    ({"paused": True}, 100.1 + GONE, False, False),
])
def test_more_comes_as_long_as_the_player_plays_and_nothing_while_somebody_holds_it(told, wall, plays, paused):
    node = Heard()
    watch = PlayerWatch(node)
    assert not watch.plays(100.0) and not watch.paused(100.0), "nobody has spoken"
    node.take(PlayerStatus(**told))
    assert (watch.plays(wall), watch.paused(wall)) == (plays, paused)
    held = (told.get("paused") or told.get("ended")) and wall == 100.0
    assert watch.holds(wall) is bool(held), "nothing is due of one that is paused or at its end and still there"
    node.players = 0
    assert not watch.plays(100.0) and not watch.paused(100.0) and not watch.holds(100.0), "it has left"
