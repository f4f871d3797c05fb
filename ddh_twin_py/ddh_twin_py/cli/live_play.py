"""Play a bag through the nodes, each a process, and record what they publish."""

from __future__ import annotations

import re
import time
from dataclasses import dataclass
from pathlib import Path

from ddh_twin_py.bags.message_types import know
from ddh_twin_py.cli.console import stage
from ddh_twin_py.cli.live_graph import LiveGraph
from ddh_twin_py.cli.twin_nodes import FLUSH_AFTER, MODELS, played_topics
from ddh_twin_py.sources.raw_bag import RawBag
from ddh_twin_py.telemetry.signals import TOPIC_TYPES

OUTPUTS = (
    "hydraulics/state", "hydraulics/prediction", "motor/thermal_state", "temperature/estimates",
    "temperature/residuals", "progress",
)
_START = 60.0  # s that the nodes have to start, and more where they compile
_PROGRESS = "ddh_msgs/msg/NodeProgress"
_PLAYING = 0.85  # share of the time until all is recorded
_PERCENT = re.compile(r"(\d+) %, ")
_END = re.compile(r"end of the bag: (\d+) messages.*?([\d.]+) times real time")


@dataclass(frozen=True)
class Played:
    """What playing came to.

    `sent` messages, `lost` ones that some node did not get, `speed`: data time by wall time, `cores`:
    processor time of all nodes by wall time.
    """

    sent: int
    lost: int
    speed: float
    cores: float


def play(
    bag: str | Path, recorded: str | Path, log: str | Path, rate: float = 0.0, rig_file: str | None = None,
    quiet: bool = False,
) -> Played:
    """Play a bag through model and fusion nodes into another bag.

    Args:
        rate: against real time, 0 is as fast as the nodes take it.

    Raises:
        InputError: where a node dies or is not ready in time.
    """
    said: dict[str, float] = {"sent": 0, "speed": 0.0}
    model = {"flush_after": FLUSH_AFTER} | ({"rig": str(rig_file)} if rig_file else {})
    with LiveGraph(log) as graph:
        with stage("starting the nodes", quiet):
            for node in MODELS:
                graph.start(node, model)
            graph.start("bag_recorder", {"bag": str(recorded), "topics": OUTPUTS, "exclude": [""], "log_time": "stamp"})
            playing: list[float] = []
            graph.start("bag_player", {
                "bag": str(bag), "rate": float(rate), "wait_for_nodes": [*MODELS, "bag_recorder"], "wait": _START,
                "topics": played_topics(bag),
            }, hear=lambda line: _hear(line, said, playing))
            while not playing and graph.alive("bag_player"):  # which ends with an error where nodes are not ready for too long
                graph.check(ended="bag_player")
                time.sleep(0.02)
            graph.check(ended="bag_player")
        with stage(f"playing {bag} through the live nodes", quiet) as progress:
            began, before, used = time.monotonic(), graph.processor_seconds(), 0.0
            while graph.alive("bag_player"):
                graph.check(ended="bag_player")
                progress(_PLAYING * said.get("share", 0.0))
                used = (graph.processor_seconds() - before) / max(time.monotonic() - began, 0.1)
                time.sleep(0.1)
            graph.check(ended="bag_player")
            progress(_PLAYING)
            time.sleep(2.0 * FLUSH_AFTER + 0.6)  # first the models work off what they hold, then the fusion
            graph.check(ended="bag_player")
            graph.stop(*MODELS)
    return Played(int(said["sent"]), lost_messages(bag, recorded), said["speed"], used)


def _hear(line: str, said: dict[str, float], playing: list[float]) -> None:
    if "playing at" in line:
        playing.append(time.monotonic())
    if found := _PERCENT.search(line):
        said["share"] = int(found[1]) / 100.0
    if found := _END.search(line):
        said["sent"], said["speed"] = int(found[1]), float(found[2])


def lost_messages(bag: str | Path, recorded: str | Path) -> int:
    """Messages of the bag that some listener did not get, by the last count that each node told."""
    sent: dict[str, int] = {}
    for topic, count in _counts(bag).items():
        relative = next((name for name in TOPIC_TYPES if topic.endswith("/" + name)), None)
        if relative is not None:
            sent[relative] = count
    lost = 0
    for message in _last_progress(recorded).values():
        for topic, received in zip(message.topics, message.received, strict=True):
            relative = next((name for name in sent if topic.endswith("/" + name)), None)
            if relative is not None:
                lost += max(0, sent[relative] - int(received))
    return lost


def _counts(bag: str | Path) -> dict[str, int]:
    raw = RawBag(bag)
    try:
        counts: dict[str, int] = {}
        for block in raw.blocks():
            for number in block.topic.tolist():
                counts[raw.topics[number][0]] = counts.get(raw.topics[number][0], 0) + 1
        return counts
    finally:
        raw.close()


def _last_progress(recorded: str | Path) -> dict[str, object]:
    """The last message of each node on `progress`."""
    raw = RawBag(recorded)
    try:
        last: dict[str, object] = {}
        store = know(_PROGRESS)
        chosen = {number for number, (topic, _) in enumerate(raw.topics) if topic.endswith("/progress")}
        for block in raw.blocks():
            for number, message in zip(block.topic.tolist(), block.messages, strict=True):
                if number in chosen:
                    told = store.deserialize_cdr(message, _PROGRESS)
                    last[told.node] = told
        return last
    finally:
        raw.close()
