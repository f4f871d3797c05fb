"""Who listens to the player, and how far each has come."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field

from ddh_twin_py.telemetry.ticks import REORDER_WINDOW, to_ns

_JUMP = to_ns(REORDER_WINDOW)  # stamps that step back further are another time
_QUIET = 1.5  # s of wall time; a node that lives tells its progress once a second


class Pending:
    """Messages of one topic that one consumer has not reported yet, by stamp and log time in ns; none while it does not listen."""

    __slots__ = ("_highest", "_listens", "_sent")

    def __init__(self, listens: bool) -> None:
        self._listens = listens
        self.clear()

    def clear(self) -> None:
        """Nothing sent counts any more: the player jumped, or the consumer is given up."""
        self._sent: deque[tuple[int, int]] = deque()
        self._highest: int | None = None

    def sent(self, stamp: int, log_time: int) -> None:
        if not self._listens:
            return
        if self._highest is None or stamp < self._highest - _JUMP:
            self._sent.clear()
            self._highest = stamp
        self._highest = max(self._highest, stamp)
        self._sent.append((stamp, log_time))

    def reported(self, newest: int) -> None:
        """The consumer has got everything up to this stamp, 0: nothing yet; a stamp from before a jump is passed over."""
        self._listens |= newest > 0
        if self._highest is None or newest > self._highest:
            return
        while self._sent and self._sent[0][0] <= newest:
            self._sent.popleft()

    @property
    def oldest(self) -> int | None:
        """Log time of the oldest message that was not reported, None where there is none."""
        return self._sent[0][1] if self._sent else None


@dataclass
class Consumer:
    """A node that tells its progress."""

    name: str
    heard: float  # s of wall time
    received: int = 0  # messages in all; fewer than before is a node that was started anew
    topics: dict[str, Pending] = field(default_factory=dict)

    @property
    def oldest(self) -> int | None:
        return min((p.oldest for p in self.topics.values() if p.oldest is not None), default=None)


class FlowControl:
    """Keeps a player within `lead` seconds of the slowest consumer.

    A consumer that is silent for `silence` seconds of wall time is gone; one that does not get
    on for `patience` seconds although it speaks has lost messages and is not waited for. One that
    was started anew is not asked for what its predecessor had not taken, and one that comes while messages are sent
    owes those of a topic from the first on that it got: its subscriptions are not matched at once.
    """

    def __init__(self, lead: float, silence: float = 4.0, patience: float = 10.0) -> None:
        self._lead = round(lead * 1e9)
        self._silence, self._patience = silence, patience
        self.consumers: dict[str, Consumer] = {}
        self._stuck: dict[str, tuple[int, float]] = {}  # oldest pending, since when
        self._sending = False  # whether anything was sent

    def report(self, name: str, newest_by_topic: dict[str, int], wall: float, received: int = 0) -> None:
        """A consumer's progress: newest stamp in ns by topic, messages in all."""
        consumer = self.consumers.setdefault(name, Consumer(name, wall))
        if received < consumer.received:
            consumer.topics.clear()
        consumer.heard, consumer.received = wall, received
        for topic, newest in newest_by_topic.items():
            consumer.topics.setdefault(topic, Pending(not self._sending)).reported(newest)

    def sent(self, topic: str, stamp: int, log_time: int) -> None:
        self._sending = True
        for consumer in self.consumers.values():
            pending = consumer.topics.get(topic)
            if pending is not None:
                pending.sent(stamp, log_time)

    def jumped(self) -> None:
        """The player goes on from another place."""
        for consumer in self.consumers.values():
            for pending in consumer.topics.values():
                pending.clear()
        self._stuck.clear()

    def slowest(self) -> Consumer | None:
        """The consumer with the oldest message that was not reported."""
        waiting = [c for c in self.consumers.values() if c.oldest is not None]
        return min(waiting, key=lambda c: c.oldest) if waiting else None

    def limit(self) -> int | None:
        """Log time in ns up to which may be sent now, None for any."""
        slowest = self.slowest()
        return None if slowest is None else slowest.oldest + self._lead

    def held_by(self, wall: float, rate: float) -> tuple[str, str]:
        """Cause and sentence where the slowest consumer keeps the player from its rate: a node that is silent is gone, not slow."""
        slowest = self.slowest()
        if wall - slowest.heard > _QUIET:
            return "gone", f"{slowest.name} has said nothing for {_QUIET:g} s, it died or hangs; waiting for it up to {self._silence:g} s"
        return "slow", f"{slowest.name} cannot take {rate:g} times real time; playing as fast as it can"

    def keep(self, names: Collection[str]) -> None:
        """Forget the consumers that are not among these nodes: they were stopped."""
        for name in set(self.consumers) - set(names):
            del self.consumers[name]
            self._stuck.pop(name, None)

    def given_up(self, wall: float) -> list[str]:
        """Why consumers are no longer waited for; to be called now and then."""
        said = []
        for name, consumer in list(self.consumers.items()):
            if wall - consumer.heard > self._silence:
                del self.consumers[name]
                self._stuck.pop(name, None)
                said.append(f"{name} has said nothing for {self._silence:g} s and is not waited for any more")
                continue
            oldest = consumer.oldest
            if oldest is None or self._stuck.get(name, (None, 0.0))[0] != oldest:
                self._stuck[name] = (oldest, wall)
            elif wall - self._stuck[name][1] > self._patience:
                for pending in consumer.topics.values():
                    pending.clear()
                said.append(f"{name} has not got on for {self._patience:g} s, messages to it are lost; going on")
        return said
