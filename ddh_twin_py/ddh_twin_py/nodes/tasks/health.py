"""Small judgements composed into `/diagnostics`: one status per concern, value beside limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.inputs import Input
from ddh_twin_py.nodes.base.node_base import TwinNode
from ddh_twin_py.telemetry.clocks.clock import Break

PERIOD = 1.0  # s of wall time
TOPIC = "/diagnostics"
PAUSED = "the player is paused"
_STOOD, _TOLD = 10.0, 60.0  # s of wall time without a judgement, from which it is said that the node did nothing, and for which after it
_USUAL = 1.5  # usual pauses between messages, after which an input is stale


class Report:
    """One status in the making; the worst level wins, messages are joined."""

    def __init__(self, name: str, hardware_id: str) -> None:
        self.status = DiagnosticStatus(level=DiagnosticStatus.OK, name=name, hardware_id=hardware_id)
        self._messages: list[str] = []

    def add(self, key: str, value: object, unit: str = "") -> None:
        """A value, its unit in the key."""
        if isinstance(value, float):
            value = f"{value:.6g}"
        self.status.values.append(KeyValue(key=f"{key} [{unit}]" if unit else key, value=str(value)))

    def warn(self, message: str) -> None:
        self._raise(DiagnosticStatus.WARN, message)

    def error(self, message: str) -> None:
        self._raise(DiagnosticStatus.ERROR, message)

    def _raise(self, level: bytes, message: str) -> None:
        self.status.level = max(self.status.level, level)
        self._messages.append(message)

    def finished(self, when_well: str) -> DiagnosticStatus:
        self.status.message = "; ".join(self._messages) or when_well
        return self.status


class Health:
    """Publishes the judgements of a node once a second of wall time."""

    def __init__(self, node: TwinNode) -> None:
        self._node = node
        self._judges: list[tuple[str, Callable[[Report], str]]] = []
        self._publisher = node.create_publisher(DiagnosticArray, TOPIC, qos.DIAGNOSTICS)
        self.hardware_id = ""
        self._judged: float | None = None  # s of wall time
        self._stood = ""  # what is said of the last time that the node did nothing
        self._stood_until = -math.inf  # s of wall time
        self.add("process", self._judge_process)
        node.every(PERIOD, self.publish)

    def add(self, concern: str, judge: Callable[[Report], str]) -> None:
        """A judge fills the report and returns what to say when all is well."""
        self._judges.append((concern, judge))

    def publish(self) -> None:
        name = self._node.get_fully_qualified_name().lstrip("/")
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        for concern, judge in self._judges:
            report = Report(f"{name}: {concern}", self.hardware_id)
            message.status.append(report.finished(judge(report)))
        self._publisher.publish(message)

    def _judge_process(self, report: Report) -> str:
        """Did the node go on all the time; what it did not do is said for a minute, in the log at once."""
        wall = self._node.wall()
        stood, self._judged = wall - (wall if self._judged is None else self._judged), wall
        report.add("pause", stood, "s")
        report.add("pause limit", _STOOD, "s")
        if stood > _STOOD:
            self._stood_until = wall
            self._stood = f"did nothing for {stood:.0f} s, as it was stopped or the computer is too slow; what came meanwhile may be lost"
            self._node.warn_again("stood", f"this node {self._stood}")
        if wall - self._stood_until < _TOLD:
            report.warn(self._stood)
        return "goes on"


def judge_age(report: Report, entry: Input, wall: float, limit: float, required: bool) -> tuple[float, float]:
    """Is the input there, and fresh; one that comes with seconds at once is as long as it is used to.

    Returns:
        age of its last message, NaN where none came, and from which it is stale, s.
    """
    limit = max(limit, _USUAL * entry.usual_pause(wall))
    age = np.nan if entry.arrived is None else wall - entry.arrived
    report.add("age", float(age), "s")
    report.add("age limit", float(limit), "s")
    if entry.arrived is None:
        if required:
            report.error(f"no message yet on {entry.name}")
    elif age > limit:
        (report.error if required else report.warn)(f"stale: {age:.1f} s without a message, limit {limit:g} s")
    return float(age), limit


def judge_publishers(report: Report, entry: Input, node: TwinNode) -> None:
    """Does more than one machine, or more than one twin, speak on the topic."""
    count = node.count_publishers(entry.name)
    report.add("publishers", count, "1")
    report.add("publishers highest", 1, "1")
    if count > 1:
        report.warn(f"{count} publishers on {entry.name}, their messages are mixed (one that was killed counts for up to 20 s)")


def judge_clock(report: Report, jumps: int, breaks: Mapping[Break, int], rests: bool = False) -> str:
    """Did the data's clock jump back, and what became of the state; ``rests``: that goes on after a long pause."""
    kept, reset, pauses = (breaks.get(broken, 0) for broken in (Break.PUT_BACK, Break.OTHER_TIME, Break.PAUSE))
    report.add("backward jumps", jumps, "1")
    report.add("backward jumps expected", 0, "1")
    report.add("backward jumps after which the model went on", kept, "1")
    report.add("long pauses", pauses, "1")
    report.add("model restarts", reset + (0 if rests else pauses), "1")
    if jumps:
        became = " and ".join(f"{words} {_times(count)}" for words, count in (("went on", kept), ("was reset", reset)) if count)
        report.warn(f"jumped back {_times(jumps)}" + (f"; the state {became}" if became else ""))
    return "runs forward"


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
