"""Playing a bag through nodes waits for them as long as the player does, which knows whether one is compiling."""

import time

from ddh_twin_py.cli import live_play


class SlowGraph:
    """Nodes of which the player says after an hour that they are ready."""

    def __init__(self, log):
        self.asked = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def start(self, node, parameters=None, hear=None):
        self.hear = hear

    def check(self, ended=""):
        pass

    def alive(self, node):
        self.asked += 1
        if self.asked == 3:
            self.hear("playing at full speed; waiting for nodes")
        if self.asked == 5:
            self.hear("end of the bag: 7 messages, 2.5 times real time")
        return self.asked < 5

    def processor_seconds(self):
        return 0.0

    def stop(self, *nodes):
        pass


def test_nodes_that_compile_for_long_are_waited_for(monkeypatch, tmp_path):
    clock = iter(range(0, 10**6, 1200))
    monkeypatch.setattr(live_play, "LiveGraph", SlowGraph)
    monkeypatch.setattr(live_play, "lost_messages", lambda bag, recorded: 0)
    monkeypatch.setattr(live_play, "played_topics", lambda bag: ["*"])
    monkeypatch.setattr(time, "sleep", lambda seconds: None)
    monkeypatch.setattr(time, "monotonic", lambda: float(next(clock)))
    played = live_play.play(tmp_path / "bag", tmp_path / "recorded", tmp_path / "log", quiet=True)
    assert (played.sent, played.lost, played.speed) == (7, 0, 2.5)
