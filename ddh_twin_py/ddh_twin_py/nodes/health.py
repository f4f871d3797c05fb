"""Small judgements composed into `/diagnostics`: one status per concern, value beside limit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from ddh_twin_py.nodes import qos
from ddh_twin_py.nodes.inputs import Input
from ddh_twin_py.nodes.node_base import TwinNode
from ddh_twin_py.nodes.telemetry_feed import TelemetryFeed
from ddh_twin_py.telemetry.causes import Cause
from ddh_twin_py.telemetry.clock import Break
from ddh_twin_py.telemetry.screening import StreamScreen
from ddh_twin_py.telemetry.ticks import LONGEST_GAP

PERIOD = 1.0  # s of wall time
HOLD = 10.0
"""s of wall time for which a cause that struck is still shown in the level."""
TOPIC = "/diagnostics"

_PLAIN = {
    Cause.NOT_A_NUMBER: "not a number",
    Cause.INFINITE: "infinite",
    Cause.OUT_OF_RANGE: "out of range",
    Cause.WRONG_UNIT: "unit suspect",
    Cause.STUCK: "stuck",
    Cause.REPEATED: "repeated",
    Cause.OUT_OF_ORDER: "out of order",
    Cause.CLOCK_JUMP: "clock jumped back",
    Cause.GAP: "stopped and came back",
}
PAUSED = "the player is paused"
DROPPED = {"late": "too late, dropped", "old_clock": "of the time before a clock jump, dropped", "other_clock": "of another clock, dropped"}
"""What the aligner leaves out, by cause."""
_ASTRAY = 10_000_000_000  # ns off the others, from which a stamp is not late but of another clock
_ASKED = "; is a clock wrong, or do two machines publish there?"
_JUMPED = "has a clock that jumped back"
_CAME_BACK = "and came back, first after"
_RETURNS = 10.0  # s by which a clock that was alone may come back by less or more
_SETTLES = 5.0  # s of wall time after which it is known whether all streams stopped
_USUAL = 1.5  # usual pauses between messages, after which an input is stale
_RATE_SAMPLES = 20  # expected ones, before a rate is judged
_RATE_SHARE = 0.8  # of the expected rate, below which messages are missing
_ERRORS = (Cause.WRONG_UNIT,)
_HARMLESS = (Cause.OUT_OF_ORDER,)


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


class Stops:
    """How often a stream stopped by itself and came back: where the stamps of all go on much later, that is said of the clock, once."""

    def __init__(self) -> None:
        self._count, self._since, self._alone = 0, 0.0, 0

    def alone(self, count: int, pauses: int, wall: float) -> int:
        """Of so many stops of the stream, those beside the long pauses of all streams; known some seconds, of wall time, later."""
        if count != self._count:
            self._count, self._since = count, wall
        if wall - self._since >= _SETTLES:
            self._alone = max(self._alone, count - pauses)
        return self._alone


class StreamJudge:
    """One input stream: age, counts of every cause, last values beside what is allowed.

    `required`: without it the node cannot do its work. `limit`: s of wall time after which it is
    stale. `held`: whether nothing can come at a wall time, as the player is paused. `pauses`: how often the stamps of
    all streams went on much later. Each cause is logged once, in a sentence, and counted after that.
    """

    def __init__(self, node: TwinNode, feed: TelemetryFeed, topic: str, required: bool, limit: float,
                 held: Callable[[float], bool], pauses: Callable[[], int]) -> None:
        self._node, self._feed, self._topic = node, feed, topic
        self._required, self._limit, self._held, self._pauses = required, limit, held, pauses
        self._stops = Stops()
        self._screen: StreamScreen = feed.screens[topic]
        self._before: dict[str, int] = {}
        self._struck: dict[str, float] = {}
        self._rate = float("nan")  # 1/s of data
        self._rate_from = (0, 0)  # samples, newest stamp in ns

    def __call__(self, report: Report) -> str:
        entry, screen = self._feed.inputs.all[self._topic], self._screen
        wall = self._node.wall()
        limit = max(self._limit, 2.5 * (screen.period or 0.0))
        held = self._held(wall)
        judge_age(report, entry, wall, np.inf if held else limit, self._required and not held)
        judge_publishers(report, entry, self._node)
        counts = screen.health()
        counts["gap"] = self._stops.alone(counts["gap"], self._pauses(), wall)
        counts |= {cause: self._feed.aligner.counts[self._topic, cause] for cause in DROPPED}
        new = {name for name, count in counts.items() if name != "samples" and count != self._before.get(name, 0)}
        self._before = counts
        if new:
            self._log(entry)
        self._struck.update(dict.fromkeys(new, wall))
        self._judge_rate(report, counts["samples"])
        report.add("messages", entry.received, "1")
        report.add("rejected", entry.rejected, "1")
        for cause, plain in _PLAIN.items():
            count = counts[cause.name.lower()]
            report.add(plain, count, "1")
            if cause not in _HARMLESS and self._recent(cause.name.lower(), wall):
                (report.error if cause in _ERRORS else report.warn)(f"{plain} ({count} times)")
        for cause, plain in DROPPED.items():
            report.add(plain, counts[cause], "1")
            if self._recent(cause, wall):
                report.warn(f"{plain} ({counts[cause]} times)")
        self._values(report)
        return PAUSED if held else "well" if entry.received else "not there, not needed"

    def _judge_rate(self, report: Report, samples: int) -> None:
        """Messages per second of data against what is usual on this stream."""
        newest, period = self._screen.newest_ns or 0, self._screen.period
        span = (newest - self._rate_from[1]) * 1e-9
        if period is None or not 0.0 <= span <= LONGEST_GAP or not self._rate_from[0]:
            self._rate_from = samples, newest
        elif span > _RATE_SAMPLES * period:
            self._rate = (samples - self._rate_from[0]) / span
            self._rate_from = samples, newest
        expected = 1.0 / period if period else float("nan")
        report.add("rate in data time", self._rate, "1/s")
        report.add("rate expected", expected, "1/s")
        if self._rate < _RATE_SHARE * expected:
            report.warn(f"messages are missing: {self._rate:.3g} per second instead of {expected:.3g}")

    def _recent(self, name: str, wall: float) -> bool:
        return name in self._struck and wall - self._struck[name] < HOLD

    def _log(self, entry: Input) -> None:
        for finding in self._screen.findings(topic=entry.name):
            if _JUMPED not in finding.message and not (_CAME_BACK in finding.message and self._of_clock(finding.value)):
                cause = (finding.topic, finding.field, finding.first_time)
                self._node.warn_once(cause, finding.message)
        for cause, plain in DROPPED.items():  # what the clock of all did is said once for all streams, see TelemetryNode
            strayed = self._feed.aligner.strayed.get((self._topic, cause))
            if strayed is not None:
                side, asked = "behind" if strayed < 0 else "ahead of", _ASKED if abs(strayed) > _ASTRAY else ""
                off = f"a stamp {abs(strayed) * 1e-9:.3f} s {side} the others" if strayed else "a stamp of a time that is worked off"
                self._node.warn_once((self._topic, cause), f"{entry.name}: {off}: {plain}{asked}")

    def _of_clock(self, stop: float) -> bool:
        """Whether a stop of so many s was none: the clock of all went ahead, or this stream's came back from where it was alone."""
        strayed = self._feed.aligner.strayed.get((self._topic, "other_clock"))
        returned = strayed is not None and abs(stop + strayed * 1e-9) < _RETURNS
        return returned or not self._before["gap"] or bool(self._pauses()) and stop > LONGEST_GAP

    def _values(self, report: Report) -> None:
        last = self._feed.last.get(self._topic)
        if last is None:
            return
        for signal, value in zip(self._screen.signals, last, strict=False):
            report.add(signal.field, float(signal.to_message(value)), signal.message_unit)
            report.add(f"{signal.field} lowest", float(signal.to_message(signal.lowest)), signal.message_unit)
            report.add(f"{signal.field} highest", float(signal.to_message(signal.highest)), signal.message_unit)


def judge_age(report: Report, entry: Input, wall: float, limit: float, required: bool) -> None:
    """Is the input there, and fresh; one that comes with seconds at once is as long as it is used to."""
    limit = max(limit, _USUAL * entry.usual_pause(wall))
    age = np.nan if entry.arrived is None else wall - entry.arrived
    report.add("age", float(age), "s")
    report.add("age limit", float(limit), "s")
    if entry.arrived is None:
        if required:
            report.error(f"no message yet on {entry.name}")
    elif age > limit:
        (report.error if required else report.warn)(f"stale: {age:.1f} s without a message, limit {limit:g} s")


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


def add_streams(
    health: Health, node: TwinNode, feed: TelemetryFeed, required: Iterable[str], limit: float,
    held: Callable[[float], bool], pauses: Callable[[], int],
) -> None:
    """A judge for every telemetry stream of a feed; arguments as of `StreamJudge`."""
    needed = set(required)
    for topic in feed.screens:
        health.add(topic, StreamJudge(node, feed, topic, topic in needed, limit, held, pauses))
