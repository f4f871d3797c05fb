"""One telemetry stream in `/diagnostics`: age, rate, stops and clock, counts of every cause."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Set

import numpy as np

from ddh_twin_py.nodes.base.inputs import Input
from ddh_twin_py.nodes.base.node_base import AGAIN, TwinNode
from ddh_twin_py.nodes.feeds.telemetry_feed import TelemetryFeed
from ddh_twin_py.nodes.tasks.health import PAUSED, Health, Report, judge_age, judge_publishers
from ddh_twin_py.nodes.tasks.silent_inputs import SilentInputs
from ddh_twin_py.nodes.tasks.stops import CAME_BACK, MOST_STEPS, SETTLES, Stops, StopsTold
from ddh_twin_py.telemetry.causes import Cause
from ddh_twin_py.telemetry.clocks.stream_line import APART
from ddh_twin_py.telemetry.screening.screening import StreamScreen
from ddh_twin_py.telemetry.spans import UNSTAMPED
from ddh_twin_py.telemetry.ticks import LONGEST_GAP

SHOWN_FOR = 10.0
"""s of wall time for which a cause that struck is still shown in the level."""
DROPPED = {"late": "too late, dropped", "old_clock": "of the time before a clock jump, dropped", "other_clock": "of another clock, dropped"}
"""What the aligner leaves out, by cause."""
_PLAIN = {
    Cause.NOT_A_NUMBER: "not a number",
    Cause.INFINITE: "infinite",
    Cause.OUT_OF_RANGE: "out of range",
    Cause.WRONG_UNIT: "unit suspect",
    Cause.STUCK: "stuck",
    Cause.SATURATED: "at full scale",
    Cause.REPEATED: "repeated",
    Cause.OUT_OF_ORDER: "out of order",
    Cause.CLOCK_JUMP: "clock jumped back",
    Cause.GAP: "stopped and came back",
}
_ASTRAY = 10.0  # s off the others, from which a stamp is not late but of another clock; the same one where it is late by less more or less
_ASKED = "; is a clock wrong, or do two machines publish there?"
_JUMPED = "has a clock that jumped back"
_SETTLED_PERIODS = 3.0  # usual steps of a topic, after which it is known what a stop was, where that is later than `SETTLES`
_STOOD = 5.0  # s of wall time between two judgements of a second, after which this process may have missed something
_RATE_SAMPLES = 20  # expected ones, before a rate is judged
_RATE_SHARE = 0.8  # of the expected rate, below which messages are missing
_ERRORS = (Cause.WRONG_UNIT,)
_UNSAID = (Cause.OUT_OF_ORDER, Cause.CLOCK_JUMP)  # harmless; said of the clock of all, or of this topic's as what is dropped
_BREAKS = {"gap", "clock_jump", "other_clock"}  # where data time is no time that went by


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
        self._named: deque[float] = deque(maxlen=MOST_STEPS)  # s of wall time at which a step of its clock was logged
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
            if _JUMPED not in finding.message and CAME_BACK not in finding.message:
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
        if len(self._named) == MOST_STEPS and wall - self._named[0] < AGAIN:
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


def add_streams(
    health: Health, node: TwinNode, feed: TelemetryFeed, required: Iterable[str], limit: float,
    held: Callable[[float], bool], pauses: Callable[[], int], silent: SilentInputs,
) -> None:
    """A judge for every telemetry stream of a feed; arguments as of `StreamJudge`."""
    needed, told = set(required), StopsTold(node)
    for topic in feed.screens:
        health.add(topic, StreamJudge(node, feed, topic, topic in needed, limit, held, pauses, told, silent))
