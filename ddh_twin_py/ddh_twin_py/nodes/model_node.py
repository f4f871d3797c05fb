"""What the nodes that run a model on telemetry share."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ddh_msgs.msg import RigInfo, TemperatureEstimateArray
from ddh_twin_py.estimation.fusion.catch_up import FOLLOWS, CatchUp
from ddh_twin_py.estimation.fusion.inputs import Readings
from ddh_twin_py.estimation.fusion.start import START, FirstReadings, air_at_start, start_temperature
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.node_base import POLL_PERIOD, TwinNode
from ddh_twin_py.nodes.base.parameters import Parameter
from ddh_twin_py.nodes.base.progress import Progress
from ddh_twin_py.nodes.feeds.intervals_feed import Batch, IntervalsFeed
from ddh_twin_py.nodes.feeds.telemetry_feed import TelemetryFeed, field_count
from ddh_twin_py.nodes.messages.conversion import to_kelvin
from ddh_twin_py.nodes.messages.wire import BulkParser
from ddh_twin_py.nodes.player.player_watch import PlayerWatch
from ddh_twin_py.nodes.tasks.health import Health, Report, add_streams, judge_clock
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.clocks.clock import Break
from ddh_twin_py.telemetry.clocks.stream_line import LONGEST_LAG
from ddh_twin_py.telemetry.recording import RigInfo as Rig
from ddh_twin_py.telemetry.signals import RIG_TOPIC, TEMPERATURE_PREFIX, TEMPERATURE_SENSORS, ZERO_CELSIUS
from ddh_twin_py.telemetry.ticks import INTERVAL, REORDER_WINDOW, Samples, Tick
from ddh_twin_py.twin.ambient import AmbientTracker
from ddh_twin_py.twin.sensor_errors import take_off_sensor_errors, temperature_zero_errors

ADAPT_PERIOD = 0.25  # s of wall time
_RECENT = 30.0  # s of wall time
_MOST_AT_ONCE = 1000  # ticks between two looks at whether to stop
TEMPERATURE_TOPICS = tuple(TEMPERATURE_PREFIX + sensor for sensor in TEMPERATURE_SENSORS)
AMBIENT_TOPIC = TEMPERATURE_PREFIX + "ambient"
FUSED_TOPIC = "temperature/estimates"

RIG = Parameter("rig", "", "Rig sheet (YAML); entries left out are those of the reference sheet. Empty: the reference sheet.")
STALE_AFTER = Parameter("stale_after", 2.0, "Wall time without a message after which an input is called stale.", "s", 0.1, 3600.0)
TWIN_PARAMETERS = (
    RIG,
    Parameter("interval", INTERVAL, "Length of one interval of data; outputs come once for each.", "s", 0.01, 1.0),
    Parameter(
        "reorder_window", REORDER_WINDOW,
        "How late a message may be and is still sorted in; outputs lag behind the data by this. "
        "Streams that go on further back have a clock that jumped.", "s", 0.05, 10.0,
    ),
    STALE_AFTER,
    Parameter(
        "flush_after", 2.0,
        "Wall time without any message after which the last intervals are worked off without waiting for more.",
        "s", 0.2, 60.0,
    ),
)  # fmt: skip
MODEL_PARAMETERS = (
    *TWIN_PARAMETERS,
    Parameter(
        "stream_timeout", 2.0,
        "How much data time an interval waits for a stream that has stopped; after that it is not waited for. One that goes on behind the "
        f"others is waited for up to {LONGEST_LAG:g} s longer.",
        "s", 0.1, 60.0,
    ),
    Parameter(
        "start", START,
        "Length of data whose temperature readings tell where the model starts; nothing is published before. A sensor that is silent "
        "then moves the model by its first reading, and again where the next ones say otherwise.",
        "s", 0.0, 60.0,
    ),
)  # fmt: skip


def rig_path(given: str) -> str | None:
    """A path, or None for the reference sheet."""
    return given or None


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
    """Announced payload in kg, None where none was."""
    return told.payload_mass if told is not None and 0.0 < told.payload_mass < np.inf else None


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
        self.breaks: Counter[Break] = Counter()
        add_streams(self.health, self, self.feed, required, self.values["stale_after"], self.player.paused,
                    lambda: self.breaks[Break.PAUSE])
        self.health.add("clock", self._judge_clock)
        self.progress = Progress(self, self.feed.inputs)
        self.rig_info: RigInfo | None = None
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
        told = Rig(message.rig_id, message.oil_grade, known_payload(message) or math.nan)
        if before is None or str(told) != str(Rig(before.rig_id, before.oil_grade, known_payload(before) or math.nan)):
            self.get_logger().info(f"rig {told}")
            contradiction = self.unit.contradiction(message) if self.unit is not None else ""
            if contradiction:
                self.get_logger().warning(f"{contradiction}; it begins anew")
                self.unit = None
                self.begin_anew()
            elif self.unit is not None and not self.unit.rig_id:
                self.unit = replace(self.unit, rig_id=message.rig_id)

    @property
    def rig_id(self) -> str:
        """As announced, '' while it was not."""
        return self.rig_info.rig_id if self.rig_info is not None else ""

    def begin_anew(self) -> None:
        """Forget the state: another rig, or another payload, was announced."""


class ModelNode(TelemetryNode):
    """A model that runs on intervals; a subclass says how it is made and what it publishes."""

    payload_matters = False

    def __init__(self, name: str, topics: Collection[str], awaited: Collection[str], extra: Iterable[Parameter] = ()) -> None:
        super().__init__(name, (*MODEL_PARAMETERS, *extra))
        values = self.values
        self.rig = load_rig(rig_path(values["rig"]))
        self.interval = values["interval"]
        self.feed = TelemetryFeed(
            self, self.rig, (*topics, *TEMPERATURE_TOPICS), awaited, self.interval, values["reorder_window"],
            values["stream_timeout"],
        )  # fmt: skip
        self._intervals = IntervalsFeed(self.interval, values["start"])
        self._fused_input = self.feed.inputs.add(FUSED_TOPIC, TemperatureEstimateArray, qos.OUTPUT)
        self._fused_parser = BulkParser(TemperatureEstimateArray)
        self._fused: tuple[int, np.ndarray] | None = None  # stamp in ns, K (N,)
        self._catch_up, self._times_missed = CatchUp(self.interval), 0
        self._model: object | None = None
        self.done = 0
        self.newest_ns = 0
        self.known_share = 0.0

    def begin(self, required: Collection[str]) -> None:
        self._warm_up()
        super().begin(required)
        self.health.add("model", self._judge_model)

    def _warm_up(self) -> None:
        """Load or compile the kernels now, so that the first data does not wait for them."""
        self.feed.warm_up()
        empty = {topic: Samples(np.empty(0, np.int64), np.empty((0, field_count(topic)))) for topic in self.feed.screens}
        tick = Tick(0, round(self.interval * 1e9), False, empty)
        (batch,) = IntervalsFeed(self.interval, 0.0).add([tick], flush=True)
        start = np.full(len(NODES), ZERO_CELSIUS + self.rig["ambient"])
        self.make_model(start, None).advance(*self.model_inputs(batch, start[:1]))

    @abstractmethod
    def model_inputs(self, batch: Batch, air: np.ndarray) -> tuple:
        """Arguments of the model's `advance`."""

    @abstractmethod
    def driven(self, batch: Batch) -> np.ndarray:
        """In which intervals it is known what drives the model, bool (n,)."""

    @abstractmethod
    def make_model(self, temperature: np.ndarray, payload_mass: float | None) -> object:
        """The model at its start: K (N,), kg or None."""

    @abstractmethod
    def run_model(self, model: object, batch: Batch, air: np.ndarray) -> np.ndarray:
        """Advance over a batch with air in K (n,) and publish; returns bool (n,), whether telemetry was there."""

    def take(self, wall: float) -> bool:
        messages = self.feed.inputs.take(self._fused_input, wall)
        for example, stamps, values in self._fused_parser.parse(messages[-1:]):
            places = {estimate.location: i for i, estimate in enumerate(example.estimates)}
            if all(node in places for node in NODES):
                order = [places[node] for node in NODES]
                self._fused = int(stamps[-1]), to_kelvin(values["estimates.temperature"][-1, order])
                self._fused_input.newest_ns = int(stamps[-1])
                if self._model is not None:
                    deviation = values["estimates.standard_deviation"][-1, order]
                    self._catch_up.take_up(*self._fused, deviation, self._model.temperatures)
        return super().take(wall)

    def work(self, ticks: list[Tick], flush: bool) -> None:
        for batch in self._intervals.add(ticks, flush):
            self._advance(batch)

    def _start(self, readings: Readings, air: np.ndarray) -> None:
        """Make the model, as warm as the first readings say, in air of K (n,)."""
        zero, within = temperature_zero_errors(self.rig)[0], self.values["start"]
        payload = known_payload(self.rig_info)
        begin = start_temperature(readings, air_at_start(air, self.interval), self.interval, zero, within)
        self._model = self.make_model(begin, payload)
        self._first_readings = FirstReadings(self.rig, self.interval, readings, within)
        taken = payload or self.rig["load.payload_mass"]
        self.unit = Unit(self.rig_id, taken if self.payload_matters else np.nan)

    def _advance(self, batch: Batch) -> None:
        take_off_sensor_errors(batch.measured, self.rig)
        anew = batch.first and not batch.put_back
        if anew:
            self._air = AmbientTracker(ZERO_CELSIUS + self.rig["ambient"], self.interval)
        air = self._air.advance(batch.air)
        readings = Readings.of(batch.readings).off_the_air(air, self.rig)
        if anew:
            self._start(readings, air)
        elif batch.put_back:
            self._model.begin_again()
        if batch.first:
            self._catch_up = CatchUp(self.interval)
        driven = self.driven(batch)
        told, missed = self._first_readings.follow(driven, readings), dict(self._catch_up.missed(driven))
        rows = sorted({0, *(t.row for t in told), *missed, len(batch)})
        known = []
        for start, stop in pairwise(rows):
            if start in missed:
                self._begin_to_follow(int(batch.end_ns[start]), missed[start])
            for reading in (t for t in told if t.row == start):
                reading.move(*self._model.temperatures)
            known.append(self.run_model(self._model, batch.part(start, stop), air[start:stop]))
            self._catch_up.ran(int(batch.end_ns[stop - 1]), self._model.temperatures)
        self.done += len(batch)
        self.newest_ns = int(batch.end_ns[-1])
        self.known_share = float(np.concatenate(known).mean())

    def _begin_to_follow(self, end_ns: int, missed: float) -> None:
        """What drives the model is known again in the interval that ends there, after so many s: it lacks their heat."""
        self._catch_up.begin(end_ns)
        self._times_missed += 1
        self.warn_again("missed", f"for {missed:.1f} s up to {end_ns * 1e-9:.3f} s it was not known what drives the model, and its heat of "
                        f"that time is missed: for {FOLLOWS:g} s its temperatures follow {FUSED_TOPIC}, where that tells them")

    def begin_anew(self) -> None:
        self.feed.without_refused(self._intervals.waiting)
        self._intervals.begin_anew()  # readings tell again where it starts

    def _judge_model(self, report: Report) -> str:
        newest = max((entry.newest_ns for entry in self.feed.inputs.all.values()), default=0)
        report.add("intervals done", self.done, "1")
        report.add("behind the newest message", (newest - self.newest_ns) * 1e-9 if self.newest_ns else float("nan"), "s")
        report.add("behind expected", self.values["reorder_window"] + 2.0 * self.interval, "s")
        report.add("intervals with telemetry", self.known_share, "1")
        report.add("times brought back to fused temperatures", self._times_missed, "1")
        if self.done and self.known_share < 1.0:
            report.warn("telemetry is missing, the model goes on without")
        return "runs" if self.done else "waits for telemetry"
