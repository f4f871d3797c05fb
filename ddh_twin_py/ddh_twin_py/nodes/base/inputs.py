"""Subscriptions that are emptied in batches, as raw bytes.

Waking rclpy's executor for every message costs 0.1 ms and more, converting it to Python objects
as much again. Here the middleware queues the messages and the node looks for them every few
milliseconds, takes all that came, and decodes them in bulk: 13 microseconds a message.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import accumulate

from rclpy.callback_groups import CallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.deserialised import deserialised
from ddh_twin_py.telemetry.ticks import REORDER_WINDOW, to_ns

_JUMP = to_ns(REORDER_WINDOW)
_PAUSE = 0.5  # s of wall time without a message that are a pause
_QUIET = SubscriptionEventCallbacks(use_default_callbacks=False)


class NeverExecuted(CallbackGroup):
    """A group whose subscriptions no executor waits for; the node takes the messages itself."""

    def can_execute(self, entity) -> bool:
        return False

    def beginning_execution(self, entity) -> bool:
        return False

    def ending_execution(self, entity) -> None:
        pass


@dataclass
class Input:
    """One subscribed topic.

    `topic` as subscribed, `name` fully qualified. `received` counts messages, `rejected` those of
    them that were not used; `newest_ns` is the newest stamp since the clock jumped back, 0 before
    the first; `arrived` is the wall time of the last message in s, None before the first; `pauses` are the last two, as
    wall time of the message that ended it, and length, s; `told`: it was said that some are left out.
    """

    topic: str
    message_type: type
    profile: QoSProfile | None
    subscription: Subscription
    received: int = 0
    rejected: int = 0
    newest_ns: int = 0
    arrived: float | None = None
    told: bool = False
    pauses: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=2))

    @property
    def name(self) -> str:
        return self.subscription.topic_name

    def note_arrival(self, wall: float) -> None:
        """A message came."""
        if self.arrived is not None and wall - self.arrived > _PAUSE:
            self.pauses.append((wall, wall - self.arrived))
        self.arrived = wall

    def usual_pause(self, wall: float) -> float:
        """s of wall time without a message that are usual of late, as where seconds come at once: the shorter of two pauses; else 0."""
        if len(self.pauses) < 2:
            return 0.0
        (before, first), (_, second) = self.pauses
        usual = min(first, second)
        return usual if wall - before < 4.0 * usual else 0.0

    def note_stamp(self, newest_ns: int) -> None:
        """The newest stamp of what just came; one that lies far back is a clock that jumped."""
        if newest_ns > self.newest_ns or newest_ns < self.newest_ns - _JUMP:
            self.newest_ns = newest_ns


class Inputs:
    """All polled subscriptions of a node.

    A subscription without a profile of its own begins as best effort, which every publisher can
    serve, and asks for reliable delivery once all publishers of its topic offer it; `adapt` looks
    for that and wants to be called a few times a second.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._group = NeverExecuted()
        self.all: dict[str, Input] = {}

    def add(self, topic: str, message_type: type, profile: QoSProfile | None = None, reliable: bool = False) -> Input:
        """Subscribe to a topic; without `profile` the reliability follows the publishers, beginning as `reliable` says."""
        made = self._subscribe(topic, message_type, profile or qos.stream(reliable))
        self.all[topic] = Input(topic, message_type, profile, made)
        return self.all[topic]

    def _subscribe(self, topic: str, message_type: type, profile: QoSProfile) -> Subscription:
        return self._node.create_subscription(
            message_type, topic, _unused, profile, raw=True, callback_group=self._group, event_callbacks=_QUIET
        )

    def adapt(self) -> None:
        """Make each subscription one that all of its publishers can serve."""
        for entry in self.all.values():
            if entry.profile is not None:
                continue
            publishers = self._node.get_publishers_info_by_topic(entry.name)
            if not publishers:
                continue
            best_effort = qos.wants_best_effort(publishers)
            wanted = qos.stream(reliable=not best_effort)
            if entry.subscription.qos_profile.reliability != wanted.reliability:
                self._node.destroy_subscription(entry.subscription)
                entry.subscription = self._subscribe(entry.topic, entry.message_type, wanted)

    def take(self, entry: Input, wall: float) -> list[bytes]:
        """All messages that wait on one input, oldest first, as CDR."""
        return self.take_timed(entry, wall)[0]

    def read(self, entry: Input, messages: Iterable[bytes]) -> list[object]:
        """Messages of an input as objects of its type; what is none is left out, counted, and said once."""
        found = [deserialised(message, entry.message_type) for message in messages]
        self.leave_out(entry, entry.rejected + sum(message is None for message in found))
        return [message for message in found if message is not None]

    def leave_out(self, entry: Input, count: int, why: str = "") -> None:
        """So many messages of an input in all are none of its type, or not sound, as ``why`` says: counted, and said once."""
        if count:
            self.tell_left_out(entry, why)
        entry.rejected = count

    def tell_left_out(self, entry: Input, why: str = "") -> None:
        """Say once that messages of an input are left out."""
        if not entry.told:
            entry.told = True
            why = why or f"a message is no sound {entry.message_type.__name__}"
            self._node.get_logger().warning(f"{entry.name}: {why}; such are left out and counted")

    def take_timed(self, entry: Input, wall: float) -> tuple[list[bytes], list[int]]:
        """The same, and when the middleware got each of them, ns of the computer's clock, never falling; 0 where it does not tell."""
        taken, came = [], []
        handle, message_type = entry.subscription.handle, entry.message_type
        with handle:
            while (message := handle.take_message(message_type, True)) is not None:
                taken.append(message[0])
                came.append(message[1]["received_timestamp"] or 0)
        if taken:
            entry.received += len(taken)
            entry.note_arrival(wall)
        return taken, list(accumulate(came, max))


def _unused(message: bytes) -> None:
    """Subscriptions need a callback; this one is never called."""
