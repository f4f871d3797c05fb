"""Node: plays a bag into the graph, as fast as the graph takes it, without loss."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
from rclpy.exceptions import NameValidationException
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock as ClockMessage

from ddh_msgs.msg import NodeProgress
from ddh_twin_py.bags.cdr import MOST_NANOSEC, nanosec_words
from ddh_twin_py.bags.topics import choose_namespace, split_topic
from ddh_twin_py.nodes.base import progress, qos
from ddh_twin_py.nodes.base.inputs import Inputs
from ddh_twin_py.nodes.base.node_base import TwinNode, run
from ddh_twin_py.nodes.base.parameters import NodeError, Parameter
from ddh_twin_py.nodes.base.times import set_time
from ddh_twin_py.nodes.messages.message_classes import message_class
from ddh_twin_py.nodes.messages.wire import STAMPED, nanosec_of, stamp_of
from ddh_twin_py.nodes.player.awaited_listeners import AwaitedListeners
from ddh_twin_py.nodes.player.flow_control import FlowControl
from ddh_twin_py.nodes.player.playback import Playback
from ddh_twin_py.nodes.player.player_control import FASTEST, PlayerControl
from ddh_twin_py.sources.raw_bag import RawBag, RawBlock
from ddh_twin_py.telemetry.signals import MACHINE_FIELDS, RIG_TOPIC, TOPIC_TYPES

STEP = 0.005  # s of wall time between two looks at what is due
_SAY = 2.0  # s of wall time between two lines of progress
_LOOK = 0.05  # s of wall time between two looks at who listens
_NOT_PLAYED = ("/clock", "/rosout", "/parameter_events")


@dataclass(frozen=True)
class Channel:
    """One topic that is played; `stamped`: flow control looks at the header's stamp."""

    publisher: Publisher
    stamped: bool


class BagPlayer(TwinNode):
    """Publishes what a bag holds, and `/clock` in its time."""

    PARAMETERS = (
        Parameter("bag", "", "Bag to play: a rosbag2 folder, or one .mcap or .db3 file."),
        Parameter(
            "rate", 1.0, "Speed against real time; 0 plays as fast as the graph takes it. See the service set_rate.",
            "1", 0.0, FASTEST,
        ),
        Parameter("start_offset", 0.0, "Where to begin, counted from the start of the bag.", "s", 0.0, 1e9),
        Parameter("loop", False, "Begin again at the end. The stamps jump back; listeners start anew."),
        Parameter("paused", False, "Wait for the service pause before the first message."),
        Parameter("clock_rate", 40.0, "How often /clock is published, in wall time; 0: never.", "Hz", 0.0, 1000.0),
        Parameter("namespace", "", "Namespace of the rig in the bag; needed where a bag holds more than one rig."),
        Parameter("topics", ("*",), "Patterns of topics to play, relative to the namespace of the bag, such as temperature/*."),
        Parameter(
            "wait_for_nodes", ("",),
            "Names of nodes of this namespace that must listen before the first message is sent.",
        ),
        Parameter(
            "wait", 5.0,
            "Longest wall time to wait for any listener; nodes of wait_for_nodes get 60 s more, or 900 s where they are there and not "
            "ready (a first start compiles the model), then it is an error.",
            "s", 0.0, 600.0,
        ),
        Parameter(
            "lead", 1.0, "How far in data time the player may run ahead of the slowest node that tells its progress.",
            "s", 0.1, 60.0,
        ),
        Parameter("exit_at_end", True, "End the process at the end of the bag, once everything has been taken."),
    )  # fmt: skip

    def __init__(self) -> None:
        super().__init__("bag_player")
        if not self.values["bag"]:
            raise NodeError("parameter bag is empty; it names the bag to play")
        self._bag = RawBag(self.values["bag"])
        for note in self._bag.notes:
            self.get_logger().warning(f"{self._bag.path} {note}")
        if self.values["start_offset"] > self._bag.duration:
            raise NodeError(
                f"parameter start_offset is {self.values['start_offset']:g} s, {self._bag.path} is {self._bag.duration:.1f} s long"
            )
        self._flow = FlowControl(self.values["lead"])
        self._inputs = Inputs(self)
        self._progress = self._inputs.add(progress.TOPIC, NodeProgress, qos.stream(reliable=True, depth=200))
        self._channels = self._make_channels()
        self._clock_publisher = self.create_publisher(ClockMessage, "/clock", 10)
        self._publish_rig()
        self.sent = 0
        self._awaited = AwaitedListeners(self, self._flow, [channel.publisher for channel in self._channels.values()],
                                         self.values["wait_for_nodes"], self.values["wait"], self.wall())
        self._said_at = self._clock_at = self._checked_at = 0.0
        rate, offset, paused = (self.values[name] for name in ("rate", "start_offset", "paused"))
        self._playback = Playback(self._bag, self._flow, self.wall, rate, offset, paused)
        self._control = PlayerControl(self, self._playback, str(self._bag.path), self.values["loop"])
        self.get_logger().info(
            f"{self._bag.path}: {self._bag.duration:.1f} s, {self._bag.count} messages, {len(self._channels)} topics"
        )
        self.every(STEP, self._step)

    # --- topics ------------------------------------------------------------------------------

    def _make_channels(self) -> dict[int, Channel]:
        channels, types = {}, {}
        played_as = _relative([topic for topic, _ in self._bag.topics], self._namespace())
        for number, ((topic, type_name), relative) in enumerate(zip(self._bag.topics, played_as, strict=True)):
            if topic in _NOT_PLAYED or not any(fnmatchcase(relative, p) for p in self.values["topics"]):
                continue
            kind = message_class(type_name)
            if kind is None:
                self.get_logger().warning(f"{self._bag.path}: topic {topic} is of type {type_name}, which is not installed; not played")
                continue
            if types.setdefault(topic, type_name) != type_name:
                raise NodeError(f"{self._bag.path}: topic {topic} has two types, {types[topic]} and {type_name}")
            profile = qos.LATCHED if relative == RIG_TOPIC else qos.stream(reliable=True)
            stamped = relative in TOPIC_TYPES and relative != RIG_TOPIC
            try:
                channels[number] = Channel(self.create_publisher(kind, relative, profile), stamped)
            except (NameValidationException, ValueError):
                self.get_logger().warning(f"{self._bag.path}: topic {topic} has a name that ROS 2 does not allow; not played")
        if not channels:
            raise NodeError(f"parameter topics is {self.values['topics']}, no topic of {self._bag.path} is named so")
        return channels

    def _namespace(self) -> str | None:
        """Namespace of the rig in the bag, None where that holds no telemetry."""
        if not self.values["namespace"] and not any(split_topic(topic) for topic, _ in self._bag.topics):
            return None
        return choose_namespace(self._bag.path, dict(self._bag.topics), self.values["namespace"] or None, "the parameter namespace")

    def _publish_rig(self) -> None:
        """What is latched comes first, wherever in the bag playing begins."""
        wanted = {n for n, c in self._channels.items() if c.publisher.qos_profile.durability == qos.LATCHED.durability}
        for block in self._bag.blocks():
            for place in np.flatnonzero(np.isin(block.topic, list(wanted))).tolist():
                self._channels[int(block.topic[place])].publisher.publish(block.messages[place])
                wanted.discard(int(block.topic[place]))
            if not wanted:
                return

    # --- playing -----------------------------------------------------------------------------

    def _step(self) -> None:
        wall = self.wall()
        self._playback.look(wall)
        self._take_progress(wall)
        if self._playback.waiting:
            self._begin_when_heard(wall)
            return
        if wall - self._checked_at > 1.0:
            self._checked_at = wall
            self._flow.keep(self._awaited.running())
            for reason in self._flow.given_up(wall):
                self.get_logger().warning(reason)
        if self._playback.sent_all:
            self._end(wall)
        elif not self._playback.paused:
            self._advance(wall)
        if self.values["clock_rate"] and wall - self._clock_at >= 1.0 / self.values["clock_rate"]:
            self._clock_at = wall
            self._tell_clock()

    def _advance(self, wall: float) -> None:
        if self._playback.advance(wall, self._send):
            self.warn_once(*self._flow.held_by(wall, self._playback.rate))
        if wall - max(self._said_at, self._playback.begun) >= _SAY:
            self._say(wall)

    def _send(self, block: RawBlock) -> None:
        for topic, due, message in zip(block.topic.tolist(), block.due.tolist(), block.messages, strict=True):
            channel = self._channels.get(topic)
            if channel is None:
                continue
            if channel.stamped and len(message) < STAMPED:
                said = f"a message on {self._bag.topics[topic][0]} has {len(message)} bytes and no stamp; such are left out"
                self.warn_once(("short", topic), f"{self._bag.path}: {said}")
                continue
            if channel.stamped and (nanosec := nanosec_of(message)) > MOST_NANOSEC:
                said = f"{self._bag.topics[topic][0]}: {nanosec_words(nanosec)}; such are left out"
                self.warn_once(("nanosec", topic), f"{self._bag.path}: {said}")
                continue
            if channel.stamped:
                self._flow.sent(channel.publisher.topic_name, stamp_of(message), due)
            elif channel.publisher.qos_profile.durability == qos.LATCHED.durability:
                continue  # published at the start
            channel.publisher.publish(message)
            self.sent += 1

    def _end(self, wall: float) -> None:
        """Wait until the last message was taken, then loop, exit, or stay."""
        if self._flow.slowest() is not None:
            return
        if self.values["loop"]:
            self.get_logger().info(f"end of the bag, beginning again (round {self._playback.next_round()}); stamps jump back")
            return
        if not self._playback.ended:
            self._playback.ended = True
            data, taken = self._playback.since_begin(wall)
            self.get_logger().info(
                f"end of the bag: {self.sent} messages, {data:.1f} s of data in {taken:.1f} s, {data / taken:.1f} times real time; "
                f"the graph held the player up for {self._playback.held:.1f} s"
            )
            self._control.tell()
            if self.values["clock_rate"]:
                self._tell_clock()  # whoever follows /clock sees the end, however soon the process ends
        self.finished = self.values["exit_at_end"]

    def _say(self, wall: float) -> None:
        self._said_at = wall
        position, duration = self._playback.position, self._playback.duration
        share = 100.0 * position / max(duration, 1e-9)
        data, taken = self._playback.since_begin(wall)
        self.get_logger().info(f"{share:.0f} %, {position:.1f} of {duration:.1f} s, {data / taken:.1f} times real time")

    def _tell_clock(self) -> None:
        message = ClockMessage()
        set_time(message.clock, self._playback.stamp_ns)
        self._clock_publisher.publish(message)

    # --- listeners ---------------------------------------------------------------------------

    def _take_progress(self, wall: float) -> None:
        for message in self._inputs.read(self._progress, self._inputs.take(self._progress, wall)):
            newest = dict(zip(message.topics, message.newest, strict=False))
            self._flow.report(message.node, newest, wall, sum(message.received))

    def _begin_when_heard(self, wall: float) -> None:
        if wall - self._checked_at < _LOOK:
            return
        self._checked_at = wall
        if not self._awaited.are_there(wall):
            return
        self._playback.start(wall)
        rate = self._playback.rate
        names = ", ".join(sorted(self._flow.consumers)) or "nobody that tells its progress"
        self.get_logger().info(f"playing at {f'{rate:g} times real time' if rate else 'full speed'}; waiting for {names}")

    def close(self) -> None:
        self._bag.close()


def _relative(topics: Sequence[str], namespace: str | None) -> list[str]:
    """Names within the rig's namespace; a topic of another namespace, or of a rig in one below, keeps its full name."""
    if namespace is None:
        return list(topics)
    splits = [split for topic in topics if (split := split_topic(topic)) is not None and split[1] in MACHINE_FIELDS]
    below = tuple(f"{rig}/" for rig, _ in splits if rig.startswith(f"{namespace}/"))
    return [topic if topic.startswith(below) else topic.removeprefix(f"{namespace}/") for topic in topics]


def main(args: list[str] | None = None) -> int:
    return run(BagPlayer, args)
