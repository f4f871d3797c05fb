"""A recording through the twin in one process: soft sensor, free run and fusion, in order of stamps."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ddh_twin_py.estimation.doubts.doubted_current import CurrentWatch, DoubtedCurrent
from ddh_twin_py.estimation.doubts.off_course import moved_on, off_course
from ddh_twin_py.estimation.fusion.catch_up import FOLLOWS, CatchUp
from ddh_twin_py.estimation.fusion.credibility import Credibility
from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Readings
from ddh_twin_py.estimation.fusion.left_together import LeftTogether
from ddh_twin_py.estimation.fusion.result import FusionResult, Innovation
from ddh_twin_py.estimation.fusion.start import FirstReadings, Told, air_at_start, start_temperature
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.estimation.left_out import without_those_out_of_place
from ddh_twin_py.estimation.replay_result import ReplayResult, SensorComparison
from ddh_twin_py.estimation.sensors import NODE_INDEX, NODE_OF_SENSOR, SENSORS
from ddh_twin_py.physics.balance import SCALAR_DTYPE, scalars
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, N
from ddh_twin_py.physics.validity import outside_stated
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.alignment.recording_ticks import align
from ddh_twin_py.telemetry.clocks.clock import Break
from ddh_twin_py.telemetry.recording import Finding, Recording
from ddh_twin_py.telemetry.screening.screening import screen_by_sheet
from ddh_twin_py.telemetry.signals import DRIVE_FIELDS, DRIVE_TOPIC, HYDRAULIC_FIELDS, HYDRAULIC_TOPIC, TEMPERATURE_PREFIX
from ddh_twin_py.telemetry.spans import too_short
from ddh_twin_py.telemetry.ticks import Ticks
from ddh_twin_py.twin.ambient import AmbientTracker
from ddh_twin_py.twin.hydraulic_model import HydraulicModel, HydraulicResult
from ddh_twin_py.twin.intervals import INTERVAL, command_size, new_carry, reduce_intervals
from ddh_twin_py.twin.lagged_readings import lagged
from ddh_twin_py.twin.machine_thermal import MachineThermal, MotorResult
from ddh_twin_py.twin.sensor_errors import (
    sensor_lags,
    take_off_air,
    take_off_delay,
    take_off_sensor_errors,
    temperature_noise,
    temperature_zero_errors,
)
from ddh_twin_py.twin.temperature_sensors import all_sensed

_DRIVES = ("speed_command", "speed", "current")  # fields of the drive without any of which it tells nothing
_SHORTEST = 0.2  # s of the drive that can be replayed
BLOCK = 5.0
"""s of measurement time between two exchanges of temperatures between fusion and hydraulic model."""


class ReplayError(ValueError):
    """A recording from which the twin cannot be driven; the message names file, topic and what is missing."""


def replay(recording: Recording, rig: Rig, interval: float = INTERVAL, without: Collection[str] = (),
           progress: Callable[[float], None] | None = None, smooth: bool = False,
           covariances: bool = False) -> ReplayResult:
    """Run models and fusion over a recording.

    Screening and cutting into intervals come first. Where the clock jumped back by more than `PUT_BACK` everything
    starts anew, by less the unit is as warm as it was; where it skipped a long time it is taken to have rested. Where the run tells
    that sensors are out of place, it is done again without them.

    Args:
        recording: as read. rig: the rig. interval: s of one output.
        without: sensors that the fusion must not see. progress: told the share done.
        smooth: whether the recording is smoothed as well; takes about 25 kB per second of data in a temporary file.
        covariances: whether the covariances of the fused temperatures are kept, with ``smooth``.

    Raises:
        ReplayError: where there is no drive telemetry, next to no time of it, or nothing in it that drives the twin.
    """
    clock = time.perf_counter()
    recording = screen_by_sheet(recording.held_against(rig.oil_grade), rig)
    if recording.drive is None or len(recording.drive) == 0:
        raise ReplayError(f"{recording.path}: {recording.lack_of(DRIVE_TOPIC)}; "
                          "the twin needs at least the drive's speed and current")
    if not any(np.isfinite(recording.drive.column(name)).any() for name in _DRIVES):
        where = f"{recording.namespace}/{DRIVE_TOPIC}"
        why = next((f.message for f in recording.findings if f.topic == where and f.severity == "error"), "")
        why = f"; {why.removeprefix(f'{recording.path}: ')}" if why else ""
        raise ReplayError(f"{recording.path}: {where} {', '.join(_DRIVES)}: NaN or refused in all of {len(recording.drive)} messages; "
                          f"the twin needs at least the drive's speed and current{why}")
    if short := too_short(recording, DRIVE_TOPIC, _SHORTEST):
        raise ReplayError(short)
    ticks = align(take_off_delay(recording, rig), interval)
    aligned = time.perf_counter() - clock
    result = without_those_out_of_place(
        lambda unseen: _once(_Run(recording, rig, ticks, interval, unseen), progress, smooth, covariances), without)
    result.seconds["screening and intervals"] = aligned
    findings = [Finding("warning", recording.path, "", "", None, 1, f"{recording.path}: {found.left_out}") for found in result.left_out]
    said = replace(result.recording, findings=[*result.recording.findings, *findings])
    return replace(result, recording=said) if findings else result


def _once(run: _Run, progress: Callable[[float], None] | None, smooth: bool, covariances: bool) -> ReplayResult:
    """All segments of one run."""
    ticks = run.ticks
    run.smoothing, run.keeping = smooth, covariances
    starts = [0, *np.flatnonzero(ticks.restart), len(ticks)]
    for start, stop in pairwise(starts):
        if stop > start:
            run.segment(start, stop, progress)
    run.smooth()
    return run.result()


class _Run:
    """The state of one replay: outputs of all intervals, models of the current segment."""

    def __init__(self, recording: Recording, rig: Rig, ticks: Ticks, interval: float, without: frozenset[str]) -> None:
        n = len(ticks)
        self.recording, self.rig, self.ticks, self.interval, self.without = recording, rig, ticks, interval, without
        self.time = (ticks.end_ns - recording.epoch_ns) * 1e-9
        self.measured = np.zeros(n, MEASURED_DTYPE)
        self.soft, self.free = np.zeros(n, SCALAR_DTYPE), np.zeros(n, SCALAR_DTYPE)
        self.free_temperature, self.fused, self.fused_std = np.empty((n, N)), np.empty((n, N)), np.empty((n, N))
        self.free_reading, self.fused_reading = np.empty((n, len(SENSORS))), np.empty((n, len(SENSORS)))
        self.ambient = np.empty(n)
        self.off, self.taken_up, self.settled = np.zeros((3, n), bool)
        self.innovations: list[Innovation] = []
        self.begun_anew: list[LeftTogether] = []
        self.doubted_current: list[DoubtedCurrent] = []
        self.seconds = {"hydraulic_model": 0.0, "machine_thermal": 0.0, "temperature_fusion": 0.0}
        self.fusion = TemperatureFusion(rig, interval)
        self.smoothing = self.keeping = False
        self._trace_start = 0
        self._smoothed: list[tuple[np.ndarray, ...]] = []
        self.zero, _ = temperature_zero_errors(rig)

    def segment(self, start: int, stop: int, progress: Callable[[float], None] | None) -> None:
        """Run the intervals start..stop, which follow each other without a break."""
        ticks, rig = self.ticks, self.rig
        gap = ticks.gap(start) if start > 0 else -np.inf
        broken = Break.of(gap)
        goes_on = broken is Break.PUT_BACK
        if goes_on:
            self.fusion.rest(0.0)
        elif broken is Break.OTHER_TIME:
            self.smooth()
            self.fusion.reset()
            self._trace_start = start
            if self.smoothing:
                self.fusion.begin_trace()
        else:
            self.fusion.rest(gap)
        command = self._reduce(start, stop)
        readings, air_read = self._readings(start, stop)
        if not goes_on:
            self._air = AmbientTracker(ZERO_CELSIUS + rig["ambient"], self.interval)
        air = self._air.advance(air_read)
        self.ambient[start:stop] = air
        surface = readings.off_the_air(air, rig)
        if goes_on:
            self._hydraulics.begin_again()
            self._motor.begin_again()
            self._catch_up = [CatchUp(self.interval) for _ in range(2)]
        else:
            self._begin(surface, air_at_start(air, self.interval))
        hydraulics, motor = self._hydraulics, self._motor
        driven = HydraulicModel.driven(self.measured[start:stop], command), MachineThermal.driven(self.measured[start:stop])
        of_hydraulics, of_motor = (first.follow(known, surface) for first, known in zip(self._first, driven, strict=True))
        again = [{row for row, _ in catch_up.missed(known)} for catch_up, known in zip(self._catch_up, driven, strict=True)]
        told = {told.row for told in (*of_hydraulics, *of_motor)}
        block, followed = max(1, round(BLOCK / self.interval)), round(FOLLOWS / self.interval)
        exchanged = {edge for rows in again for row in rows for edge in range(row, min(row + followed, stop - start) + 1, block)}
        edges = sorted({*range(0, stop - start, block), *told, *exchanged, stop - start})
        for first, last in pairwise(edges):
            part, rows = slice(first, last), slice(start + first, start + last)
            clock = time.perf_counter()
            if first in told:
                self._tell([t for t in of_hydraulics if t.row == first], [t for t in of_motor if t.row == first])
            for catch_up, begins in zip(self._catch_up, again, strict=True):
                if first in begins:
                    catch_up.begin(int(ticks.end_ns[rows.start]))
            result = hydraulics.advance(self.measured[rows], command[command_size(first) - 1: command_size(last)], air[part])
            self.seconds["hydraulic_model"] += time.perf_counter() - clock
            clock = time.perf_counter()
            motor_result = motor.advance(self.measured[rows], air[part])
            self.seconds["machine_thermal"] += time.perf_counter() - clock
            clock = time.perf_counter()
            inputs, doubted = self._current.take(fusion_inputs(result, motor_result, air_read[part]), result.soft)
            self.doubted_current += [replace(told, index=told.index + rows.start) for told in doubted]
            for doubt in doubted:
                if doubt.unsure is not None:
                    self.fusion.unsure_of_copper(doubt.unsure)
            estimate = self.fusion.advance(inputs, readings.between(first, last))
            hydraulics.use_temperatures(estimate.temperature[-1])
            self.seconds["temperature_fusion"] += time.perf_counter() - clock
            self.soft[rows], self.free[rows] = scalars(result.soft), scalars(result.free)
            self.free_temperature[rows] = result.free_temperature
            self.free_reading[rows] = self._read(result.free_temperature)
            self._take_up(int(ticks.end_ns[rows.stop - 1]), estimate)
            self.off[rows], self.taken_up[rows], self.settled[rows] = result.off, result.taken_up, result.settled
            self.fused[rows], self.fused_std[rows] = estimate.temperature, estimate.standard_deviation
            self.fused_reading[rows] = estimate.reading + self.zero
            self.innovations += [Innovation(i.index + rows.start, i.sensor, i.measured, i.expected, i.standard_deviation, i.accepted)
                                 for i in estimate.innovations]
            self.begun_anew += [replace(left, index=left.index + rows.start) for left in estimate.begun_anew]
            if progress is not None:
                progress(rows.stop / len(self.ticks))

    def _begin(self, readings: Readings, air: float) -> None:
        """Make the models, as warm as the first readings of a segment say, in air of K."""
        begin = start_temperature(readings, air, self.interval, self.zero)
        payload = self.recording.rig.payload_mass if self.recording.rig is not None else None
        self._hydraulics = HydraulicModel(self.rig, begin, payload, self.interval)
        self._motor = MachineThermal(self.rig, begin, self.interval)
        self._first = [FirstReadings(self.rig, self.interval, readings) for _ in range(2)]
        self._catch_up = [CatchUp(self.interval) for _ in range(2)]
        self._current = CurrentWatch(self.rig, self.interval, payload)
        self._reading = all_sensed(begin, self.rig["tank.top_share"])

    def _tell(self, of_hydraulics: list[Told], of_motor: list[Told]) -> None:
        """Put the models, and what sensors would read of the free run, to readings that tell anew how warm the unit is."""
        before = self._seen_free()
        for model, told in ((self._hydraulics, of_hydraulics), (self._motor, of_motor)):
            for reading in told:
                reading.move(*model.temperatures)
        self._reading += self._seen_free() - before

    def _take_up(self, end_ns: int, fused: FusionResult) -> None:
        """Let models that missed what drives them, and what sensors would read of the free run, follow what is fused up to a stamp, ns."""
        before = self._seen_free()
        for catch_up, model in zip(self._catch_up, (self._hydraulics, self._motor), strict=True):
            catch_up.ran(end_ns, model.temperatures)
            catch_up.take_up(end_ns, fused.temperature[-1], fused.standard_deviation[-1], model.temperatures)
        self._reading += self._seen_free() - before

    def _seen_free(self) -> np.ndarray:
        """What sensors meet of the free run now, K, (m,)."""
        return all_sensed(self._hydraulics.free_temperature, self.rig["tank.top_share"])

    def _read(self, free_temperature: np.ndarray) -> np.ndarray:
        """What sensors would read of the free run, K, (n, m), of its temperatures, K, (n, N)."""
        seen = lagged(all_sensed(free_temperature, self.rig["tank.top_share"]), self._reading, self.interval, sensor_lags(self.rig))
        self._reading = seen[-1].copy()
        return seen + self.zero

    def smooth(self) -> None:
        """Smooth what the fusion has done since it began anew."""
        if self.fusion.trace is None:
            return
        clock = time.perf_counter()
        said = self.fusion.trace.smooth()
        kept = (self.fusion.trace.covariances()[1],) if self.keeping else ()
        self._smoothed.append((said.row + self._trace_start, said.temperature, said.temperature_std, said.heat, said.heat_std, *kept))
        self.fusion.trace = None
        self.seconds["smoother"] = self.seconds.get("smoother", 0.0) + time.perf_counter() - clock

    def _reduce(self, start: int, stop: int) -> np.ndarray:
        """Fill the means of the intervals; the command, rad/s, as `reduce_intervals` gives it."""
        command = np.empty(command_size(stop - start))
        epoch = self.recording.epoch_ns

        def stream(topic: str, width: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            samples = self.ticks.samples.get(topic)
            if samples is None:
                return np.empty(0), np.empty((0, width)), np.zeros(stop - start, dtype=np.int64)
            first, last = int(self.ticks.first[topic][start]), int(self.ticks.last[topic][stop - 1])
            chosen = slice(first, last)
            when = (samples.stamp[chosen] - epoch) * 1e-9
            return when, np.ascontiguousarray(samples.values[chosen]), self.ticks.last[topic][start:stop] - first

        reduce_intervals(
            self.time[start] - self.interval, self.interval, *stream(DRIVE_TOPIC, len(DRIVE_FIELDS)),
            *stream(HYDRAULIC_TOPIC, len(HYDRAULIC_FIELDS)), new_carry(), self.measured[start:stop], command,
        )
        take_off_sensor_errors(self.measured[start:stop], self.rig)
        return command

    def _readings(self, start: int, stop: int) -> tuple[Readings, np.ndarray]:
        """Readings of the intervals that the fusion may see, and those of the air by interval, K, NaN where none."""
        air = np.full(stop - start, np.nan)
        columns: list[list[np.ndarray]] = [[], [], []]
        for sensor in ("ambient", *SENSORS):
            topic = TEMPERATURE_PREFIX + sensor
            if topic not in self.ticks.samples or sensor in self.without:
                continue
            first, last = int(self.ticks.first[topic][start]), int(self.ticks.last[topic][stop - 1])
            value = self.ticks.samples[topic].values[first:last, 0]
            good = np.flatnonzero(np.isfinite(value))
            index = np.searchsorted(self.ticks.last[topic][start:stop], first + good, "right")
            if sensor == "ambient":
                air[index] = value[good]
                continue
            for column, values in zip(columns, (index, np.full(index.size, SENSORS.index(sensor)), value[good]), strict=True):
                column.append(values)
        if not columns[0]:
            return Readings.of(()), air
        index, sensor, value = (np.concatenate(column) for column in columns)
        order = np.argsort(index, kind="stable")
        return Readings(index[order], sensor[order], value[order]), air

    def _told(self) -> Recording:
        """The recording, with where the free run was off before its findings, and where the estimate began anew, what is extrapolated, or
        cannot be true of the rig at its end, behind them."""
        said = (outside_stated(self.fused), Credibility(self.rig).doubt(self.fusion.state)) if len(self.ticks) else ()
        findings = [Finding("warning", self.recording.path, "", "", None, 1, f"{self.recording.path}: {text}") for text in said if text]
        if self.begun_anew:
            count, at = len(self.begun_anew), float(self.time[self.begun_anew[0].index])
            when = f"at {at:.1f} s" if count == 1 else f"{count} times, first at {at:.1f} s:"
            text = f"{self.recording.path}: {when} {self.begun_anew[0].why}"
            findings.insert(0, Finding("warning", self.recording.path, "", "", None, count, text, at))
        for told in self.doubted_current:
            at, topic = float(self.time[told.index]), f"{self.recording.namespace}/{DRIVE_TOPIC}"
            text = f"{self.recording.path}: at {at:.1f} s {self.recording.namespace}/{told.why}"
            findings.append(Finding("warning", self.recording.path, topic, "current", None, 1, text, at))
        first = off_course(self.recording, self.time, moved_on(self.off, self.taken_up), self.interval)
        return replace(self.recording, findings=[*first, *self.recording.findings, *findings]) if first or findings else self.recording

    def result(self) -> ReplayResult:
        """All outputs, with each temperature sensor against the twin."""
        sensors, noise = {}, temperature_noise(self.rig)
        for i, name in enumerate(SENSORS):
            topic = TEMPERATURE_PREFIX + name
            if topic not in self.ticks.samples:
                continue
            last = self.ticks.last[topic]
            index = np.searchsorted(last, np.arange(int(last[-1])), "right")
            samples = self.ticks.samples[topic]
            measured = take_off_air(samples.values[: index.size, 0], i, self.ambient[index], self.rig)
            sensors[name] = SensorComparison(
                NODE_OF_SENSOR[name], (samples.stamp[: index.size] - self.recording.epoch_ns) * 1e-9,
                measured, self.free_reading[index, i], self.fused_reading[index, i],
                self.fused_std[index, NODE_INDEX[name]], noise[i], name not in self.without, index,
            )
        smoothed = dict(zip(("smoothed_row", "smoothed", "smoothed_std", "smoothed_heat", "smoothed_heat_std", "covariance"),
                            (np.concatenate(column) for column in zip(*self._smoothed, strict=True)), strict=False))
        return ReplayResult(
            self._told(), self.rig, self.time, self.measured, self.soft, self.free, self.free_temperature,
            self.fused, self.fused_std, sensors, self.innovations, self.seconds, **smoothed, ambient=self.ambient,
            sampled_at={topic: self._sampled_at(topic) for topic in (DRIVE_TOPIC, HYDRAULIC_TOPIC) if topic in self.ticks.samples},
            off=moved_on(self.off, self.taken_up), settled=self.settled,
            zero_error=Credibility(self.rig).offset(self.fusion.state) if len(self.ticks) else None,
        )

    def _sampled_at(self, topic: str) -> np.ndarray:
        """Mean time of each interval's samples, s, (n,), NaN where none came."""
        first, last = self.ticks.first[topic], self.ticks.last[topic]
        total = np.concatenate([[0.0], np.cumsum((self.ticks.samples[topic].stamp - self.recording.epoch_ns) * 1e-9)])
        count = last - first
        return np.where(count > 0, (total[last] - total[first]) / np.maximum(count, 1), np.nan)


def fusion_inputs(hydraulic: HydraulicResult, motor: MotorResult, ambient: np.ndarray) -> FusionInputs:
    """What both models say, as the fusion wants it: motor heat from the motor model, the rest from the
    hydraulics; ``ambient`` as read, K, (n,), NaN where not."""
    heat = hydraulic.soft["heat"].copy()
    heat[:, : len(MOTOR_NODES)] = motor.points["heat"][:, : len(MOTOR_NODES)]
    return FusionInputs(
        heat, motor.points["mean_square_current"].copy(), np.ascontiguousarray(hydraulic.soft["flow"]),
        hydraulic.soft["rod_position"].copy(), hydraulic.known, motor.known, ambient,
    )
