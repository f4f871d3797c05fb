"""What the nodes share that live on telemetry: ticks of it, whose it is, what its clock does."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from ddh_msgs.msg import RigInfo
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.node_base import AGAIN, POLL_PERIOD, TwinNode
from ddh_twin_py.nodes.base.progress import Progress
from ddh_twin_py.nodes.feeds.telemetry_feed import TelemetryFeed
from ddh_twin_py.nodes.player.player_watch import PlayerWatch
from ddh_twin_py.nodes.tasks.health import Health, Report, judge_clock
from ddh_twin_py.nodes.tasks.silent_inputs import SilentInputs
from ddh_twin_py.nodes.tasks.stream_judge import add_streams
from ddh_twin_py.rig import PAYLOADS, is_payload
from ddh_twin_py.telemetry.clocks.clock import Break
from ddh_twin_py.telemetry.recording import RigInfo as Rig
from ddh_twin_py.telemetry.signals import RIG_TOPIC
from ddh_twin_py.telemetry.ticks import Tick

ADAPT_PERIOD = 0.25  # s of wall time
_RECENT = 30.0  # s of wall time
_MOST_AT_ONCE = 1000  # ticks between two looks at whether to stop


@dataclass(frozen=True)
class Unit:
    """What a state belongs to: rig id, '' where that is not known, and payload in kg, NaN where that does not matter."""

    rig_id: str = ""
    payload_mass: float = np.nan

    def contradiction(self, told: RigInfo) -> str:
        """What an announcement says that cannot be the same unit, '' if it can."""
        if self.rig_id and told.rig_id and self.rig_id != told.rig_id:
            return f"rig {told.rig_id!r} was announced, this was {self.rig_id!r}"
        if known_payload(told) is not None and known_payload(told) != self.payload_mass and not np.isnan(self.payload_mass):
            return f"a payload of {told.payload_mass:g} kg was announced, this was {self.payload_mass:g} kg"
        return ""


def known_payload(told: RigInfo | None) -> float | None:
    """Announced payload in kg, None where none was, or one that is none."""
    return told.payload_mass if told is not None and is_payload(told.payload_mass) else None


def _refused_payload(told: RigInfo) -> str:
    """That an announced payload is none, '' where it is one, or 0 or NaN, which is not known."""
    if known_payload(told) is not None or told.payload_mass == 0.0 or math.isnan(told.payload_mass):
        return ""
    return f"{RIG_TOPIC}: payload_mass is {told.payload_mass:g} kg, allowed are {PAYLOADS}; it is not used"


def in_words(told: RigInfo) -> str:
    """An announcement in a line; two that say the same are the same in words, also where neither knows the payload."""
    return str(Rig(told.rig_id, told.oil_grade, known_payload(told) or math.nan))


class TelemetryNode(TwinNode, ABC):
    """A node fed with ticks of telemetry; a subclass makes `feed` and does the work in `work`.

    `rests`: its model goes on after a long pause, as that of a unit that rested; else it begins anew with what is read then.
    """

    rests = False
    feed: TelemetryFeed

    def begin(self, required: Collection[str]) -> None:
        """Start looking at the inputs; to be called at the end of the constructor."""
        self.health = Health(self)
        self.player = PlayerWatch(self)
        self.silent = SilentInputs(self, self.player.holds)
        self.breaks: Counter[Break] = Counter()
        add_streams(self.health, self, self.feed, required, self.values["stale_after"], self.player.paused,
                    lambda: self.breaks[Break.PAUSE], self.silent)
        self.health.add("clock", self._judge_clock)
        self.health.add("rig", self._judge_rig)
        self.progress = Progress(self, self.feed.inputs)
        self.rig_info: RigInfo | None = None
        self._exchanges = 0  # times that another rig or payload was announced than that of the state in hand
        self._lately: deque[float] = deque()  # s, wall clock, of those of the last minute
        self.unit: Unit | None = None  # what the state in hand belongs to, None while there is none
        self.create_subscription(RigInfo, RIG_TOPIC, self._take_rig, qos.LATCHED)
        self._last_data: float | None = None
        self._more = False  # whether ticks of what was taken in are left for the next look
        self.every(POLL_PERIOD, self.poll)
        self.every(ADAPT_PERIOD, self.feed.inputs.adapt)

    @property
    def waits_for(self) -> tuple[str, ...]:
        return self.feed.awaited

    def poll(self) -> None:
        """Take in what came, do what can be done, tell how far we are."""
        wall = self.wall()
        if not self._more and self.take(wall):
            self._last_data = wall
            self.feed.align()
            if refused := self.feed.alike.judge():
                self._leave_out(refused)
        ticks = self.feed.ready(_MOST_AT_ONCE)
        self._more = len(ticks) == _MOST_AT_ONCE
        silent = not self._more and self._last_data is not None and wall - self._last_data > self.flush_wait()
        flush = silent and not self.player.plays(wall)
        if flush:
            self._last_data = None
            ticks += self.feed.flush()
        for tick in ticks:
            if tick.restart:
                self._note_restart(tick)
        if ticks or flush:
            self.work(ticks, flush)
        if not self._more:
            self.progress.tell(wall)

    def _leave_out(self, refused: list[str]) -> None:
        """Topics that were used until now are refused, as another is that began alike: what was done with them is forgotten."""
        for topic in refused:
            self.warn_once(("alike", topic), f"{self.feed.inputs.all[topic].name} {self.feed.alike.refused[topic]}")
        if self.unit is not None:
            self.get_logger().warning(f"it begins anew without {', '.join(refused)}")
            self.unit = None
        self.feed.aligner.late.clear()
        self.begin_anew()

    def flush_wait(self) -> float:
        """Wall time without a message after which nothing more is waited for, s."""
        return self.values["flush_after"]

    def take(self, wall: float) -> bool:
        """Take in what waits on all inputs; whether there was anything."""
        return self.feed.take(wall)

    @abstractmethod
    def work(self, ticks: list[Tick], flush: bool) -> None:
        """Do what these ticks allow; ``flush``: nothing more comes for now."""

    def _note_restart(self, tick: Tick) -> None:
        broken = Break.of(tick.gap)
        self.breaks[broken] += 1
        then = {Break.PUT_BACK: "goes on as warm as it is", Break.PAUSE: "goes on as after a rest" if self.rests else "begins anew"}
        said = broken.words(tick.gap)
        if broken is Break.PAUSE and self._came_meanwhile(0.5 * tick.gap):
            said = f"the clock went ahead by {tick.gap:.1f} s"
        self.warn_again(broken, f"{said}, to {tick.start_ns * 1e-9:.3f} s; the model {then.get(broken, 'begins anew')}")

    def _came_meanwhile(self, silence: float) -> bool:
        """Whether telemetry of a machine came without a silence of so many s of wall time just before; a player may leave one out."""
        wall = self.wall()
        silences = (length for entry in self.feed.inputs.all.values() for ended, length in entry.pauses if wall - ended < _RECENT)
        return not self.player.plays(wall) and max(silences, default=0.0) < silence

    @property
    def jumps(self) -> int:
        """How often the data's clock jumped back."""
        return sum(count for (_, cause), count in self.feed.aligner.counts.items() if cause == "clock_jump")

    def _judge_clock(self, report: Report) -> str:
        return judge_clock(report, self.jumps, self.breaks, self.rests)

    def _take_rig(self, message: RigInfo) -> None:
        before = self.rig_info
        self.rig_info = message
        self.health.hardware_id = message.rig_id
        if refused := _refused_payload(message):
            self.warn_once(refused, refused)
        if before is None or in_words(before) != in_words(message):
            contradiction = self.unit.contradiction(message) if self.unit is not None else ""
            if not contradiction or self.warn_again(contradiction, f"{contradiction}; it begins anew"):
                self.get_logger().info(f"rig {in_words(message)}")
            if contradiction:
                self._exchanges += 1
                self._lately.append(self.wall())
                self.unit = None
                self.begin_anew()
            elif self.unit is not None and not self.unit.rig_id:
                self.unit = replace(self.unit, rig_id=message.rig_id)

    def _judge_rig(self, report: Report) -> str:
        """Which rig was announced, and whether others are by turns."""
        while self._lately and self.wall() - self._lately[0] > AGAIN:
            self._lately.popleft()
        report.add("changes of the rig", self._exchanges, "1")
        if len(self._lately) > 1:
            report.warn(f"what is announced of the rig changed {len(self._lately)} times within a minute, last to "
                        f"{in_words(self.rig_info)}, and all began anew each time; do two machines publish on "
                        f"{self.resolve_topic_name(RIG_TOPIC)}?")
        return in_words(self.rig_info) if self.rig_info is not None else "not announced"

    @property
    def rig_id(self) -> str:
        """As announced, '' while it was not."""
        return self.rig_info.rig_id if self.rig_info is not None else ""

    def begin_anew(self) -> None:
        """Forget the state: another rig, or another payload, was announced."""
