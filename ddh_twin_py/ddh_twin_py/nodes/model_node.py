"""What the nodes that run a model on telemetry share."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Collection, Iterable
from itertools import pairwise

import numpy as np

from ddh_msgs.msg import TemperatureEstimateArray
from ddh_twin_py.estimation.fusion.catch_up import FOLLOWS, CatchUp
from ddh_twin_py.estimation.fusion.inputs import Readings
from ddh_twin_py.estimation.fusion.start import START, FirstReadings, air_at_start, start_temperature
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.parameters import Parameter
from ddh_twin_py.nodes.base.twin_parameters import TWIN_PARAMETERS, rig_path
from ddh_twin_py.nodes.feeds.intervals_feed import Batch, IntervalsFeed
from ddh_twin_py.nodes.feeds.telemetry_feed import TelemetryFeed, field_count
from ddh_twin_py.nodes.messages.conversion import to_kelvin
from ddh_twin_py.nodes.messages.wire import BulkParser
from ddh_twin_py.nodes.tasks.health import Report
from ddh_twin_py.nodes.telemetry_node import TelemetryNode, Unit, known_payload
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.clocks.stream_line import LONGEST_LAG
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, TEMPERATURE_SENSORS, ZERO_CELSIUS
from ddh_twin_py.telemetry.ticks import Samples, Tick
from ddh_twin_py.twin.ambient import AmbientTracker
from ddh_twin_py.twin.sensor_errors import take_off_sensor_errors, temperature_zero_errors

TEMPERATURE_TOPICS = tuple(TEMPERATURE_PREFIX + sensor for sensor in TEMPERATURE_SENSORS)
FUSED_TOPIC = "temperature/estimates"
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
        self.feed.inputs.leave_out(self._fused_input, self._fused_parser.unreadable, self._fused_parser.why)
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
