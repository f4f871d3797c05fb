"""Small judgements composed into `/diagnostics`: one status per concern, value beside limit."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Set
from itertools import pairwise

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.inputs import Input
from ddh_twin_py.nodes.base.node_base import AGAIN, TwinNode
from ddh_twin_py.nodes.feeds.telemetry_feed import TelemetryFeed
from ddh_twin_py.nodes.tasks.silent_inputs import SilentInputs
from ddh_twin_py.telemetry.causes import Cause
from ddh_twin_py.telemetry.clocks.clock import Break
from ddh_twin_py.telemetry.clocks.stream_line import APART
from ddh_twin_py.telemetry.screening.screening import StreamScreen
from ddh_twin_py.telemetry.spans import UNSTAMPED
from ddh_twin_py.telemetry.ticks import LONGEST_GAP

PERIOD = 1.0  # s of wall time
SHOWN_FOR = 10.0
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
_ASTRAY = 10.0  # s off the others, from which a stamp is not late but of another clock; the same one where it is late by less more or less
_ASKED = "; is a clock wrong, or do two machines publish there?"
_JUMPED = "has a clock that jumped back"
_CAME_BACK = "and came back, first after"
_TOGETHER = 2.5  # s of wall time within which topics that stopped are named in one line
_RETURNS = 10.0  # s by which a clock that was alone may come back by less or more
SETTLES, _SETTLED_PERIODS = 15.0, 3.0
"""s of wall time, and usual steps of a topic, after which it is known what a stop was; a vote on its clock may take so long."""
_STOOD = 5.0  # s of wall time between two judgements of a second, after which this process may have missed something
_MOST_STEPS = 8  # of a topic's own clock that are remembered, and logged in a minute
_USUAL = 1.5  # usual pauses between messages, after which an input is stale
_RATE_SAMPLES = 20  # expected ones, before a rate is judged
_RATE_SHARE = 0.8  # of the expected rate, below which messages are missing
_ERRORS = (Cause.WRONG_UNIT,)
_UNSAID = (Cause.OUT_OF_ORDER, Cause.CLOCK_JUMP)  # harmless; said of the clock of all, or of this topic's as what is dropped
_BREAKS = {"gap", "clock_jump", "other_clock"}  # where data time is no time that went by


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
    """Stops of a stream by itself: not where the stamps of all went on much later, its own clock was wrong for a while, or we stood still.

    `count` of those that are known, some seconds, of wall time, later; `first` is the length of the first of them, s.
    """

    def __init__(self) -> None:
        self.count, self.first = 0, 0.0
        self._open: list[tuple[float, float]] = []  # wall time and length of those that are not known yet, s
        self._offs: deque[float] = deque(maxlen=_MOST_STEPS)  # s
        self._pauses = 0  # of all until now
        self._paused: list[float] = []  # wall times of the last of them, s, that were no stop of this stream yet

    def clock_was_off(self, off: float) -> None:
        """Its clock, alone, was off by so many s."""
        self._offs.append(off)

    def stood_still(self, length: float) -> None:
        """For so many s this process did nothing, and what came then may be lost."""
        self._offs.append(length)

    def note(self, lengths: Iterable[float], pauses: int, wall: float, settles: float = SETTLES) -> None:
        """Stops of so many s were seen, and so many long pauses of all streams until now; the wait until that is judged is given, s."""
        self._open += [(wall, length) for length in lengths]
        self._paused += [wall] * (pauses - self._pauses)
        self._pauses = pauses
        while self._open and wall - self._open[0][0] >= settles:
            came, length = self._open.pop(0)
            pause = next((at for at in self._paused if abs(at - came) <= settles), None) if length > LONGEST_GAP else None
            if pause is not None:
                self._paused.remove(pause)
            elif not self._of_clock(length):
                self.count, self.first = self.count + 1, self.first or length
        self._paused = [at for at in self._paused if wall - at < 2.0 * settles]

    def _of_clock(self, length: float) -> bool:
        """Whether a stop of so many s is the step of a clock that went off, from one error to another, or back."""
        steps = {*self._offs, *(after - before for before, after in pairwise(self._offs))}
        return any(abs(length - abs(step)) < _RETURNS for step in steps)


class StopsTold:
    """Says in one line which inputs of a node stopped and came back at about the same time, of each input the first time.

    Args:
        node: that logs it.
    """

    def __init__(self, node: TwinNode) -> None:
        self._node = node
        self._known: set[str] = set()
        self._open: dict[str, float] = {}  # s without a sample, by name
        self._since = 0.0

    def note(self, name: str, first: float, wall: float) -> None:
        """An input, by its name, has stopped, the first time for so many s without a sample."""
        if name in self._known:
            return
        self._known.add(name)
        self._since = self._since if self._open else wall
        self._open[name] = first

    def tell(self, wall: float) -> None:
        """Say what is due."""
        if not self._open or wall - self._since < _TOGETHER:
            return
        lengths = self._open.values()
        after = f"{min(lengths):.3f}" if len(lengths) == 1 else f"{min(lengths):.1f} to {max(lengths):.1f}"
        self._node.get_logger().warning(f"{', '.join(self._open)} stopped {_CAME_BACK} {after} s without a sample")
        self._open = {}


class StreamJudge:
    """One input stream: age, counts of every cause, last values beside what is allowed.

    `required`: without it the node cannot do its work. `limit`: s of wall time after which it is
    stale. `held`: whether nothing can come at a wall time, as the player is paused. `pauses`: how often the stamps of
    all streams went on much later. `told`, `silent`: of all inputs of the node. Each cause is logged once, in a sentence, and counted after
    that; each step of a clock that is wrong is logged.
    """

    def __init__(self, node: TwinNode, feed: TelemetryFeed, topic: str, required: bool, limit: float,
                 held: Callable[[float], bool], pauses: Callable[[], int], told: StopsTold, silent: SilentInputs) -> None:
        self._told, self._silent = told, silent
        self._node, self._feed, self._topic = node, feed, topic
        self._required, self._limit, self._held, self._pauses = required, limit, held, pauses
        self._stops = Stops()
        self._screen: StreamScreen = feed.screens[topic]
        self._off, self._off_at = 0.0, -AGAIN  # how far its clock was off the others, s, and when that was found last
        self._named: deque[float] = deque(maxlen=_MOST_STEPS)  # s of wall time at which a step of its clock was logged
        self._judged = node.wall()
        self._before: dict[str, int] = {}
        self._breaks: dict[str, int] = {}
        self._struck: dict[str, float] = {}
        self._rate = float("nan")  # 1/s of data
        self._rate_from = (0, 0)  # samples, newest stamp in ns

    def __call__(self, report: Report) -> str:
        entry, screen = self._feed.inputs.all[self._topic], self._screen
        wall = self._node.wall()
        limit = max(self._limit, 2.5 * (screen.period or 0.0))
        held = self._held(wall)
        age, limit = judge_age(report, entry, wall, np.inf if held else limit, self._required and not held)
        self._silent.note(entry.name, age, limit, wall)
        judge_publishers(report, entry, self._node)
        counts = screen.health()
        counts |= {cause: self._feed.aligner.counts[self._topic, cause] for cause in DROPPED}
        breaks, self._breaks = self._breaks, {name: counts[name] for name in _BREAKS}
        self._judge_rate(report, counts["samples"], breaks == self._breaks)
        counts["gap"] = self._count_stops(wall)
        new = {name for name, count in counts.items() if name != "samples" and count != self._before.get(name, 0)}
        self._before = counts
        if new:
            self._log(entry, new, wall)
        self._told.tell(wall)
        self._struck.update(dict.fromkeys(new, wall))
        report.add("messages", entry.received, "1")
        report.add("rejected", entry.rejected, "1")
        for cause, plain in _PLAIN.items():
            count = counts[cause.name.lower()]
            report.add(plain, count, "1")
            if cause not in _UNSAID and self._recent(cause.name.lower(), wall):
                why = f", {UNSTAMPED}" if cause is Cause.REPEATED and screen.newest_ns == 0 else ""
                (report.error if cause in _ERRORS else report.warn)(f"{plain} ({count} times){why}")
        for cause, plain in DROPPED.items():
            report.add(plain, counts[cause], "1")
            if self._recent(cause, wall):
                report.warn(f"{self._how_far(cause)}{plain} ({counts[cause]} times)")
        if refused := self._feed.alike.refused.get(self._topic):
            report.error(refused)
        self._values(report)
        return PAUSED if held else "well" if entry.received else "not there, not needed"

    def _count_stops(self, wall: float) -> int:
        """How often the stream is known to have stopped by itself."""
        if wall - self._judged > _STOOD:
            self._stops.stood_still(wall - self._judged)
        self._judged = wall
        self._stops.note(self._screen.stops, self._pauses(), wall, max(SETTLES, _SETTLED_PERIODS * (self._screen.period or 0.0)))
        self._screen.stops.clear()
        return self._stops.count

    def _judge_rate(self, report: Report, samples: int, steady: bool) -> None:
        """Messages per second of data against what is usual on this stream; ``steady``: data time was time that went by."""
        newest, period = self._screen.newest_ns or 0, self._screen.period
        span = (newest - self._rate_from[1]) * 1e-9
        if period is None or not steady or not 0.0 <= span <= LONGEST_GAP or not self._rate_from[0]:
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
        return name in self._struck and wall - self._struck[name] < SHOWN_FOR

    def _log(self, entry: Input, new: Set[str], wall: float) -> None:
        for finding in self._screen.findings(topic=entry.name):
            if _JUMPED not in finding.message and _CAME_BACK not in finding.message:
                cause = (finding.topic, finding.field, finding.first_time)
                self._node.warn_once(cause, finding.message)
        if "gap" in new:
            self._told.note(entry.name, self._stops.first, wall)
        for cause in new & DROPPED.keys():  # what the clock of all did is said once for all streams, see TelemetryNode
            off = self._strayed(cause)
            if off is None:
                continue
            said = f"{entry.name}: {self._how_far(cause)}{DROPPED[cause]}"
            if cause != "other_clock" and abs(off) <= _ASTRAY:
                self._node.warn_once((self._topic, cause), said)
            elif self._steps(off, wall, APART + entry.usual_pause(wall) if cause == "other_clock" else _ASTRAY):
                self._name_step(said + _ASKED, wall)

    def _name_step(self, said: str, wall: float) -> None:
        """A step of the topic's clock has its own line, at once; of one that never rests there are a few a minute."""
        if len(self._named) == _MOST_STEPS and wall - self._named[0] < AGAIN:
            self._node.warn_again((self._topic, "clock"), said)
        else:
            self._named.append(wall)
            self._node.get_logger().warning(said)

    def _steps(self, off: float, wall: float, least: float) -> bool:
        """Whether the topic's clock, alone off by so many s, is by another step, s, than it was found to be before."""
        steps = wall - self._off_at > AGAIN or abs(off - self._off) > least
        self._off_at = wall
        if steps:
            self._off = off
            self._stops.clock_was_off(off)
        return steps

    def _strayed(self, cause: str) -> float | None:
        """How far what was last left out lay from where all were, s, None where nothing was."""
        off = self._feed.aligner.strayed.get((self._topic, cause))
        return None if off is None else off * 1e-9

    def _how_far(self, cause: str) -> str:
        """That in words, before the cause; '' where it is not known."""
        off = self._strayed(cause)
        if not off:
            return "" if off is None else "a stamp of an interval that had already been computed: "
        return f"a stamp {abs(off):.3f} s {'behind' if off < 0.0 else 'ahead of'} the others: "

    def _values(self, report: Report) -> None:
        last = self._feed.last.get(self._topic)
        if last is None:
            return
        for signal, value in zip(self._screen.signals, last, strict=False):
            report.add(signal.field, float(signal.to_message(value)), signal.message_unit)
            report.add(f"{signal.field} lowest", float(signal.to_message(signal.lowest)), signal.message_unit)
            report.add(f"{signal.field} highest", float(signal.to_message(signal.highest)), signal.message_unit)


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


def add_streams(
    health: Health, node: TwinNode, feed: TelemetryFeed, required: Iterable[str], limit: float,
    held: Callable[[float], bool], pauses: Callable[[], int], silent: SilentInputs,
) -> None:
    """A judge for every telemetry stream of a feed; arguments as of `StreamJudge`."""
    needed, told = set(required), StopsTold(node)
    for topic in feed.screens:
        health.add(topic, StreamJudge(node, feed, topic, topic in needed, limit, held, pauses, told, silent))
