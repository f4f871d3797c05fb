"""Node: temperatures of the whole unit with uncertainty, from both models and whichever sensors there are."""

from __future__ import annotations

from itertools import islice

import numpy as np
from sensor_msgs.msg import Temperature

from ddh_msgs.msg import HydraulicState, MotorThermalState, ResidualArray, RigInfo, TemperatureEstimateArray
from ddh_twin_py.estimation.doubts.agrees_again import AGREES, AgreesAgain
from ddh_twin_py.estimation.doubts.doubted_current import CurrentWatch
from ddh_twin_py.estimation.doubts.place_watch import PlaceWatch
from ddh_twin_py.estimation.fusion.credibility import Credibility
from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading, Readings, air_of
from ddh_twin_py.estimation.fusion.left_together import LeftTogether
from ddh_twin_py.estimation.fusion.result import FusionResult
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.node_base import AGAIN, run
from ddh_twin_py.nodes.base.parameters import Parameter
from ddh_twin_py.nodes.base.twin_parameters import TWIN_PARAMETERS, rig_path
from ddh_twin_py.nodes.feeds.fusion_inputs import (
    MOTOR_TOPIC,
    MOTOR_WIDTH,
    PREDICTION_TOPIC,
    STATE_TOPIC,
    STATE_WIDTH,
    add_duty,
    asked_of,
    inputs_of,
    late_readings,
    motor_rows,
    node_temperatures,
    state_rows,
)
from ddh_twin_py.nodes.feeds.telemetry_feed import TelemetryFeed
from ddh_twin_py.nodes.messages.conversion import FUSION, estimate_layout, location_layout, residual_layout, to_celsius, to_kelvin
from ddh_twin_py.nodes.messages.wire import BulkParser
from ddh_twin_py.nodes.model_node import TEMPERATURE_TOPICS
from ddh_twin_py.nodes.tasks.health import Report, judge_age, judge_publishers
from ddh_twin_py.nodes.tasks.limit_watch import LIMIT_PARAMETERS, LimitWatch
from ddh_twin_py.nodes.tasks.state_keeper import StateKeeper
from ddh_twin_py.nodes.tasks.stream_judge import DROPPED
from ddh_twin_py.nodes.telemetry_node import TelemetryNode, Unit, known_payload
from ddh_twin_py.physics.thermal_network import N, NODES
from ddh_twin_py.physics.validity import outside_stated
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.clocks.clock import Break
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX
from ddh_twin_py.telemetry.ticks import Tick

_KEEP_PREDICTIONS = 60_000_000_000  # ns
_SILENT_AFTER = 10.0  # s of wall time without an estimate that are worth a word


class TemperatureFusionNode(TelemetryNode):
    """Models and sensors to `temperature/estimates`, `estimate/<location>` and `temperature/residuals`."""

    rests = True
    PARAMETERS = (
        *TWIN_PARAMETERS,
        Parameter(
            "model_timeout", 5.0,
            "How much data time the estimate waits for a model that has stopped; after that it goes on and knows less. "
            "Must be longer than the models' own start and the player's lead together.", "s", 0.5, 60.0,
        ),
        *LIMIT_PARAMETERS,
        Parameter("state_file", "", "File in which the estimate survives a restart; empty: none."),
        Parameter("state_period", 10.0, "Wall time between two writings of the state file.", "s", 1.0, 3600.0),
    )  # fmt: skip

    def __init__(self) -> None:
        super().__init__("temperature_fusion")
        values = self.values
        self._rig = load_rig(rig_path(values["rig"]))
        self.feed = TelemetryFeed(
            self, self._rig, TEMPERATURE_TOPICS, [STATE_TOPIC, MOTOR_TOPIC], values["interval"], values["reorder_window"],
            values["model_timeout"], {STATE_TOPIC: STATE_WIDTH, MOTOR_TOPIC: MOTOR_WIDTH}, keep_late=TEMPERATURE_TOPICS,
        )  # fmt: skip
        self._fusion = TemperatureFusion(self._rig, values["interval"])
        self._credibility = Credibility(self._rig)
        self._places = PlaceWatch(self._rig, values["interval"])
        self._agrees_again = AgreesAgain(self._rig, values["interval"])
        self._current = CurrentWatch(self._rig, values["interval"])
        self._models = {
            topic: (self.feed.inputs.add(topic, kind, qos.stream(reliable=True)), BulkParser(kind))
            for topic, kind in ((STATE_TOPIC, HydraulicState), (MOTOR_TOPIC, MotorThermalState), (PREDICTION_TOPIC, HydraulicState))
        }
        self._predicted: dict[int, np.ndarray] = {}  # K (N,) by stamp in ns
        self._last_end: int | None = None
        self._measured, self._measured_at = np.full(N, np.nan), np.full(N, np.nan)  # K, s
        self._deviation = self._newest = np.full(N, np.nan)
        self._refused = dict.fromkeys(SENSORS, 0)
        self._times_begun_anew = 0
        self._begun_anew: tuple[float, LeftTogether] | None = None  # s of wall time, the last
        self._known = {STATE_TOPIC: 0.0, MOTOR_TOPIC: 0.0}
        self._done = 0
        self._late = 0
        self._done_at = 0.0  # s, wall clock of the newest estimate
        self._make_publishers()
        self._keeper: StateKeeper | None = None
        if values["state_file"]:
            self._keeper = StateKeeper(values["state_file"], self._fusion.state)
            if self._keeper.note:
                (self.get_logger().info if self._keeper.first else self.get_logger().warning)(self._keeper.note)
            self.every(values["state_period"], self._keep_state)
        self._limits = LimitWatch(self, self._rig, lambda: self._fusion.state if self._done else None, lambda: self._last_end or 0)
        self._warm_up()
        self.begin(required=())
        for topic in (STATE_TOPIC, MOTOR_TOPIC):
            self.health.add(topic, lambda report, topic=topic: self._judge_model(report, topic))
        self.health.add("estimate", self._judge_estimate)
        self.health.add("limits", self._limits.judge)
        if self._keeper is not None:
            self.health.add("state file", self._judge_state_file)

    def _make_publishers(self) -> None:
        self._estimates = self.create_publisher(TemperatureEstimateArray, "temperature/estimates", qos.OUTPUT)
        self._residuals = self.create_publisher(ResidualArray, "temperature/residuals", qos.OUTPUT)
        self._locations = [self.create_publisher(Temperature, f"estimate/{name}", qos.OUTPUT) for name in NODES]
        self._estimate_layout = estimate_layout()
        names = [TEMPERATURE_PREFIX + sensor for sensor in SENSORS]
        self._residual_layout = residual_layout(FUSION, names, ["degC"] * len(names))
        self._location_layouts = [location_layout(name) for name in NODES]

    def _warm_up(self) -> None:
        self.feed.warm_up()
        scratch = TemperatureFusion(self._rig, self.values["interval"])
        ticks = round(2.0 / self.values["interval"])
        scratch.advance(FusionInputs.unknown(ticks), [Reading(0, SENSORS[0], float(to_kelvin(23.0)))])
        self._limits.warm_up(scratch.state)

    # --- inputs ------------------------------------------------------------------------------

    def take(self, wall: float) -> bool:
        """Sensors first: a model's message is never older than what it was computed from."""
        some = super().take(wall)
        for topic, (entry, parser) in self._models.items():
            messages, came = self.feed.inputs.take_timed(entry, wall)
            arrivals = iter(came)
            for example, stamps, values in parser.parse(messages):
                some = True
                entry.newest_ns = int(stamps[-1])
                if topic == PREDICTION_TOPIC:
                    self._keep_predictions(stamps, node_temperatures(example.temperature_nodes, to_kelvin(values["temperature"])))
                    continue
                rows = (state_rows if topic == STATE_TOPIC else motor_rows)(example, values)
                self.feed.collect(topic, islice(arrivals, stamps.size), stamps.tolist(), rows)
            self.feed.inputs.leave_out(entry, parser.unreadable, parser.why)
        return some

    def flush_wait(self) -> float:
        """Longer than the models' own while they have something in hand, short once they have told all."""
        wait = self.values["flush_after"]
        told = [entry.newest_ns for topic, (entry, _) in self._models.items() if topic != PREDICTION_TOPIC and entry.received]
        read = max(self.feed.inputs.all[topic].newest_ns for topic in self.feed.screens)
        if not told:
            return wait
        return 0.3 * wait if min(told) >= read else 2.0 * wait

    def _keep_predictions(self, stamps: np.ndarray, temperature: np.ndarray) -> None:
        self._predicted.update(zip(stamps.tolist(), temperature, strict=True))
        if len(self._predicted) > 4 * _KEEP_PREDICTIONS * 1e-9 / self.values["interval"]:
            oldest = int(stamps[-1]) - _KEEP_PREDICTIONS
            self._predicted = {stamp: row for stamp, row in self._predicted.items() if stamp > oldest}

    # --- work --------------------------------------------------------------------------------

    def work(self, ticks: list[Tick], flush: bool) -> None:
        start = 0
        for i, tick in enumerate(ticks):
            if tick.restart or self._last_end is None and i == 0:
                self._run(ticks[start:i])
                start = i
                self._break(tick)
        self._run(ticks[start:])

    def _break(self, tick: Tick) -> None:
        """The clock jumped back, or skipped a long time, or this is the beginning."""
        broken = Break.of(tick.gap)
        if self._last_end is None:
            self.unit = Unit(self.rig_id)
            self._restore(tick)
        elif broken is Break.PUT_BACK:
            self._fusion.rest(0.0)
            self._predicted.clear()
            self._measured_at += tick.gap
        elif broken is Break.OTHER_TIME:
            self.begin_anew()
        else:
            self._fusion.rest(tick.gap)
            self._limits.present.passes(round(tick.gap / self.values["interval"]))
            self._current.begin_anew()
        self._last_end = tick.start_ns

    def _take_rig(self, message: RigInfo) -> None:
        super()._take_rig(message)
        self._current.lifts(known_payload(message))

    def begin_anew(self) -> None:
        self._fusion.reset()
        self._places.begin_anew()
        self._agrees_again.begin_anew()
        self._current.begin_anew()
        self._limits.present.clear()
        self._predicted.clear()
        self._measured[:] = self._measured_at[:] = np.nan
        self.unit = Unit(self.rig_id)

    def _restore(self, tick: Tick) -> None:
        if self._keeper is None or self._keeper.saved is None:
            return
        saved = self._keeper.saved
        age = (tick.start_ns - saved.stamp_ns) * 1e-9
        refusal = self._keeper.refusal(age, self.rig_id or (self._rig.rig_id if self._rig.named else ""))
        if refusal:
            self.get_logger().warning(refusal)
            return
        self._fusion.restore(saved.state, 0.0)
        before = self._tank_deviation()
        self._fusion.restore(saved.state, age)
        self.unit = Unit(self.rig_id or saved.rig_id)
        self.get_logger().info(
            f"{self._keeper.path}: going on from the state of {age:.0f} s before; "
            f"the tank's oil was known to {before:.2g} K then, to {self._tank_deviation():.2g} K now"
        )

    def _tank_deviation(self) -> float:
        return float(np.sqrt(self._fusion.state.covariance[N - 1, N - 1]))

    def _run(self, ticks: list[Tick]) -> None:
        if not ticks:
            return
        inputs, readings = inputs_of(ticks)
        late, self.feed.aligner.late = self.feed.aligner.late, []
        if late:
            self._late += len(late)
            readings += late_readings(late, ticks[0].start_ns, self.feed.aligner.interval_ns)
        asked = asked_of(ticks)
        inputs, doubted = self._current.take(inputs, asked)
        for told in doubted:
            self.warn_again(("current", told.again), told.why)
            if told.unsure is not None:
                self._fusion.unsure_of_copper(told.unsure)
                self._limits.present.clear()  # its means hold another current
        add_duty(self._limits.present, asked, inputs)
        result = self._fusion.advance(inputs, readings)
        end_ns = np.array([tick.end_ns for tick in ticks], np.int64)
        predicted = np.array([self._predicted.pop(stamp, _UNKNOWN) for stamp in end_ns.tolist()])
        self._publish(end_ns, result, predicted)
        for left in result.begun_anew:
            self._times_begun_anew += 1
            self._begun_anew = self.wall(), left
            self.warn_again("left together", left.why)
        self._watch_places(predicted, readings, result)
        self._last_end = int(end_ns[-1])
        self._deviation = result.standard_deviation[-1]
        self._newest = result.temperature[-1]
        self._done += len(ticks)
        self._done_at = self.wall()
        self._known = {STATE_TOPIC: float(inputs.hydraulics_known.mean()), MOTOR_TOPIC: float(inputs.motor_known.mean())}

    def _watch_places(self, predicted: np.ndarray, readings: list[Reading], result: FusionResult) -> None:
        """Leave sensors out that are told to be out of place, and use those again that agree; ``predicted``: K, of the free run, (n, N),
        NaN where it says nothing."""
        read = Readings.of([r for r in readings if r.index >= 0]).off_the_air(result.ambient, self._rig)
        air = air_of(readings, len(result.ambient))
        for back in self._agrees_again.take(read, air, result):
            self._places.told.remove(back)
            self._fusion.use_again(back.sensors)
            self.get_logger().warning(f"{back.topics}: agreed with what is fused for {AGREES:g} s or more, used again")
        found = self._places.take(predicted, read, self._fusion.state, air)
        if found is None:
            return
        known = predicted[np.isfinite(predicted).all(axis=1)]
        self._fusion.leave_out(found.sensors, known[-1] if known.size else result.temperature[-1], self._places.air)
        self._measured[[NODE_INDEX[sensor] for sensor in found.sensors if sensor in NODE_INDEX]] = np.nan
        if found.sensors:
            self._agrees_again.follow(found)
        self.get_logger().warning(f"{found.left_out}{_UNTIL * bool(found.sensors)}")

    def _publish(self, end_ns: np.ndarray, result: FusionResult, predicted: np.ndarray) -> None:
        celsius, deviation = to_celsius(result.temperature), result.standard_deviation
        measured, age = self._measured_in(end_ns, result)
        values = {
            "ambient": to_celsius(result.ambient),
            "estimates.temperature": celsius,
            "estimates.standard_deviation": deviation,
            "estimates.predicted": to_celsius(predicted),
            "estimates.measured": to_celsius(measured),
            "estimates.measured_age": age,
        }
        for message in self._estimate_layout.compose(end_ns, values):
            self._estimates.publish(message)
        for j, (publisher, layout) in enumerate(zip(self._locations, self._location_layouts, strict=True)):
            values = {"temperature": celsius[:, j], "variance": deviation[:, j] ** 2}
            for message in layout.compose(end_ns, values):
                publisher.publish(message)
        self._publish_residuals(end_ns, result)

    def _measured_in(self, end_ns: np.ndarray, result: FusionResult) -> tuple[np.ndarray, np.ndarray]:
        """Last accepted reading of each node, K, and its age in s, (n, N)."""
        accepted: dict[int, list] = {}
        first, interval = end_ns[0] * 1e-9, self.values["interval"]
        for innovation in result.innovations:
            if innovation.accepted:
                accepted.setdefault(max(innovation.index, 0), []).append(innovation)
        measured, age = np.empty((end_ns.size, N)), np.empty((end_ns.size, N))
        for i, now in enumerate((end_ns * 1e-9).tolist()):
            for innovation in accepted.get(i, ()):
                node = NODE_INDEX[innovation.sensor]
                self._measured[node], self._measured_at[node] = innovation.measured, first + innovation.index * interval
            measured[i], age[i] = self._measured, now - self._measured_at
        return measured, age

    def _publish_residuals(self, end_ns: np.ndarray, result: FusionResult) -> None:
        rows: dict[int, dict[str, np.ndarray]] = {}
        for innovation in result.innovations:
            if not innovation.accepted:
                self._refused[innovation.sensor] += 1
                self.warn_once(
                    ("refused", innovation.sensor),
                    f"{TEMPERATURE_PREFIX}{innovation.sensor} reads {to_celsius(innovation.measured):.2f} degC, expected were "
                    f"{to_celsius(innovation.expected):.2f} +- {innovation.standard_deviation:.2f} degC; not used, counted from here on",
                )
            empty = {name: np.full(len(SENSORS), np.nan) for name in _RESIDUAL_FIELDS}
            row = rows.setdefault(innovation.index, empty)
            at = SENSORS.index(innovation.sensor)
            row["residuals.measured"][at] = to_celsius(innovation.measured)
            row["residuals.predicted"][at] = to_celsius(innovation.expected)
            row["residuals.residual"][at] = innovation.measured - innovation.expected
            row["residuals.standard_deviation"][at] = innovation.standard_deviation
        if rows:
            order = sorted(rows)
            values = {name: np.array([rows[i][name] for i in order]) for name in _RESIDUAL_FIELDS}
            stamps = end_ns[0] + np.array(order, np.int64) * round(self.values["interval"] * 1e9)
            for message in self._residual_layout.compose(stamps, values):
                self._residuals.publish(message)

    # --- state file --------------------------------------------------------------------------

    def _keep_state(self) -> None:
        if self._last_end is not None and self._done:
            self._keeper.keep(self._fusion.state, self.unit.rig_id, self._last_end)

    def close(self) -> None:
        if self._keeper is not None:
            self._keep_state()
            self._keeper.close()
            if self._keeper.failure:
                self.get_logger().error(self._keeper.failure)

    # --- health ------------------------------------------------------------------------------

    def _judge_model(self, report: Report, topic: str) -> str:
        entry, wall = self._models[topic][0], self.wall()
        limit = np.inf if self.player.paused(wall) else self.values["stale_after"]
        self.silent.note(entry.name, *judge_age(report, entry, wall, limit, required=False), wall)
        judge_publishers(report, self._models[topic][0], self)
        report.add("messages", self._models[topic][0].received, "1")
        for cause, plain in DROPPED.items():
            report.add(plain, self.feed.aligner.counts[topic, cause], "1")
        report.add("intervals in which it knew", self._known[topic], "1")
        if self._done and self._known[topic] < 1.0:
            report.warn("not known, the uncertainty grows")
        return "known"

    def _judge_estimate(self, report: Report) -> str:
        report.add("intervals done", self._done, "1")
        report.add("readings that came late and were used at their time", self._late, "1")
        for node, deviation in zip(NODES, self._deviation, strict=True):
            report.add(f"standard deviation {node}", float(deviation), "K")
        for sensor, count in self._refused.items():
            report.add(f"readings refused {sensor}", count, "1")
        report.add("times that it began anew as sensors left its band together", self._times_begun_anew, "1")
        if not self._done:
            return "waits for a model or a sensor"
        age, limit = self.wall() - self._done_at, _SILENT_AFTER
        report.add("age of the newest estimate", float(age), "s")
        report.add("age limit", limit, "s")
        if age > limit and not self.player.paused(self.wall()):
            report.warn(f"no estimate for {age:.0f} s, neither models nor sensors go on")
        for why in (self._current.doubted, self._current.unlike):
            if why:
                report.warn(why)
        for found in self._places.told:
            report.warn(found.left_out + _UNTIL)
        if self._begun_anew is not None and self.wall() - self._begun_anew[0] < AGAIN:
            report.warn(self._begun_anew[1].why)
        for why in self._fusion.contradicted:
            report.warn(why)
        outside = outside_stated(self._newest)
        if outside:
            report.warn(outside)
        _, off = self._credibility.parameter(self._fusion.state)
        report.add("parameter farthest from its prior", abs(off), "standard deviations")
        doubt = self._credibility.doubt(self._fusion.state)
        if doubt:
            report.warn(doubt)
        return "runs"

    def _judge_state_file(self, report: Report) -> str:
        report.add("written", self._keeper.written, "1")
        if self._keeper.failure:
            report.error(self._keeper.failure)
            self.warn_once(self._keeper.failure, self._keeper.failure)
        return str(self._keeper.path)


_UNKNOWN = np.full(N, np.nan)
_UNTIL = ", until it has agreed with that for minutes"
_RESIDUAL_FIELDS = ("residuals.measured", "residuals.predicted", "residuals.residual", "residuals.standard_deviation")


def main(args: list[str] | None = None) -> int:
    return run(TemperatureFusionNode, args)
