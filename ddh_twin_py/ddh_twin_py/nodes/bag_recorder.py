"""Node: records the topics of its namespace into a bag that survives the death of the recorder.

Where the disk can take no more it says so and records nothing from then on; it stays, as a player waits for it.
"""

from __future__ import annotations

from contextlib import suppress
from fnmatch import fnmatchcase
from pathlib import Path

from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.numbering import numbered
from ddh_twin_py.bags.qos import qos_profile
from ddh_twin_py.bags.writer import BagWriter
from ddh_twin_py.nodes.base import progress, qos
from ddh_twin_py.nodes.base.inputs import Input, Inputs
from ddh_twin_py.nodes.base.node_base import POLL_PERIOD, TwinNode, run
from ddh_twin_py.nodes.base.parameters import NodeError, Parameter
from ddh_twin_py.nodes.messages.message_classes import message_class
from ddh_twin_py.nodes.messages.wire import stamp_of
from ddh_twin_py.nodes.tasks.health import Health, Report

_LOOK_PERIOD = 0.2  # s of wall time between two looks for new topics
_DEAF_AFTER, _MOST_DEAF = 10.0, 0.5  # s of wall time, and share of the topics that somebody publishes and that brought nothing in it


class BagRecorder(TwinNode):
    """Subscribes to everything that is wanted, as it appears, and writes it down unread."""

    PARAMETERS = (
        Parameter("bag", "", "Folder to write; it must not exist."),
        Parameter(
            "topics", ("*",),
            "Patterns of topics to record, relative to the namespace (temperature/*) or absolute (/diagnostics).",
        ),
        Parameter("exclude", ("progress", "bag_player/status", "*/transition_event", "*/_action/*"), "Patterns of topics to leave out."),
        Parameter(
            "log_time", "arrival",
            "What orders the bag and paces its playing: the node's clock at arrival, or the header's stamp (for "
            "recording a replay that runs faster than the data; not where stamps jump).",
            choices=("arrival", "stamp"),
        ),
        Parameter(
            "if_exists", "refuse", "What to do where the folder exists: refuse, or number (write to NAME_2, NAME_3 ...).",
            choices=("refuse", "number"),
        ),
    )  # fmt: skip

    def __init__(self) -> None:
        super().__init__("bag_recorder")
        if not self.values["bag"]:
            raise NodeError("parameter bag is empty; it names the folder to write")
        self._writer = BagWriter(self._path())
        self.get_logger().info(f"recording into {self._writer.path}")
        self._inputs = Inputs(self)
        self._types: dict[str, str] = {}
        self._profiles: dict[str, object] = {}  # as offered, by topic
        self._stamped: set[str] = set()
        self._counts: dict[str, int] = {}
        self._failure = ""  # why nothing is recorded any more
        self._since: dict[str, float] = {}  # s, wall clock of the subscription
        self._progress = progress.Progress(self, self._inputs)
        self._health = Health(self)
        self._health.add("recording", self._judge)
        self._look()
        self.every(_LOOK_PERIOD, self._look)
        self.every(POLL_PERIOD, self._poll)

    def _path(self) -> Path:
        if self.values["if_exists"] == "number":
            return next(path for path in numbered(self.values["bag"]) if not path.exists())
        return Path(self.values["bag"])

    # --- topics ------------------------------------------------------------------------------

    def _look(self) -> None:
        """Subscribe to topics that have appeared; follow what their publishers offer."""
        for topic, types in self.get_topic_names_and_types():
            if topic not in self._inputs.all and self._wanted(topic):
                self._subscribe(topic, types)
        self._inputs.adapt()

    def _wanted(self, topic: str) -> bool:
        prefix = self.get_namespace().rstrip("/") + "/"
        relative = topic.removeprefix(prefix) if topic.startswith(prefix) else topic
        return any(fnmatchcase(relative, p) for p in self.values["topics"] if p.startswith("/") == relative.startswith("/")) and not any(
            fnmatchcase(relative, p) for p in self.values["exclude"]
        )

    def _subscribe(self, topic: str, types: list[str]) -> None:
        publishers = self.get_publishers_info_by_topic(topic)
        if not publishers:
            return
        kind = message_class(types[0])
        if kind is None or len(types) > 1:
            why = "its package is not installed" if kind is None else "it is published with several types"
            self.warn_once(topic, f"topic {topic} of type {' and '.join(types)} is not recorded: {why}")
            return
        latched = qos.is_latched(publishers)
        best_effort = qos.wants_best_effort(publishers)
        self._types[topic] = types[0]
        self._profiles[topic] = qos_profile(
            "best_effort" if best_effort else "reliable", "transient_local" if latched else "volatile", depth=10
        )
        if next(iter(kind.get_fields_and_field_types().values()), "") == "std_msgs/Header":
            self._stamped.add(topic)
        self._counts[topic], self._since[topic] = 0, self.wall()
        self._inputs.add(topic, kind, qos.LATCHED if latched else None, reliable=not best_effort)

    # --- recording ---------------------------------------------------------------------------

    def _poll(self) -> None:
        wall = self.wall()
        for entry in self._inputs.all.values():
            messages = self._inputs.take(entry, wall)
            if messages:
                self._record(entry, messages)
        self._progress.tell(wall)

    def _record(self, entry: Input, messages: list[bytes]) -> None:
        """Write messages down, as long as the bag takes them."""
        if not self._failure:
            try:
                self._write(entry, messages)
            except BagError as error:
                self._give_up(error)
        if entry.topic in self._stamped:
            entry.note_stamp(max(map(stamp_of, messages)))

    def _give_up(self, error: BagError) -> None:
        """The bag takes no more: close it as far as that goes, and record nothing from now on."""
        self._failure, self.exit_code = f"{error}; nothing is recorded from here on", 1
        self.get_logger().error(self._failure)
        with suppress(BagError):
            self._writer.close()

    def _write(self, entry: Input, messages: list[bytes]) -> None:
        topic = entry.topic
        kind, profile, stamped = self._types[topic], self._profiles[topic], topic in self._stamped
        now = self.get_clock().now().nanoseconds
        by_stamp = stamped and self.values["log_time"] == "stamp"
        for message in messages:
            stamp = stamp_of(message) if by_stamp else 0  # 0: nobody set it
            self._writer.write_raw(topic, kind, profile, stamp or now, message)
            self._counts[topic] += 1

    def _judge(self, report: Report) -> str:
        report.add("messages", sum(self._counts.values()), "1")
        report.add("topics", len(self._counts), "1")
        if self._failure:
            report.error(self._failure)
            return ""
        if not self._counts:
            report.warn("nothing to record yet")
        deaf = self._deaf()
        if len(deaf) > _MOST_DEAF * len(self._counts):
            said = f"{len(deaf)} of {len(self._counts)} topics are published and bring nothing, such as {deaf[0]}: start the recorder again"
            report.warn(said)
            self.warn_once("deaf", said)
        return str(self._writer.path)

    def _deaf(self) -> list[str]:
        """Topics that somebody publishes and that have brought nothing for some time, as where a killed node has upset the discovery."""
        old = self.wall() - _DEAF_AFTER
        return [topic for topic, count in self._counts.items() if not count and self._since[topic] < old and self.count_publishers(topic)]

    def close(self) -> None:
        self._poll()
        if not self._failure:
            try:
                self._writer.close()
            except BagError as error:
                self._give_up(error)
        kept = {**dict.fromkeys(self._counts, 0), **self._writer.on_disk}
        lost = sum(self._counts.values()) - sum(kept.values())
        listed = ", ".join(f"{topic} {count}" for topic, count in sorted(kept.items())) or "nothing"
        also = f", the last {lost} that came before it failed are lost" if lost else ""
        self.get_logger().info(f"{self._writer.path}: {sum(kept.values())} messages{also}: {listed}")


def main(args: list[str] | None = None) -> int:
    return run(BagRecorder, args)
