"""A recording through the twin in one process: soft sensor, free run and fusion, in order of stamps."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.sensors import NODE_INDEX, NODE_OF_SENSOR
from ddh_twin_py.estimation.start import spread_start
from ddh_twin_py.estimation.temperature_fusion import FusionInputs, FusionState, Innovation, Reading, TemperatureFusion
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, N
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.twin.hydraulic_model import HydraulicModel
from ddh_twin_py.twin.intervals import INTERVAL, new_carry, reduce_intervals
from ddh_twin_py.twin.machine_thermal import MachineThermal

BLOCK = 5.0
"""s of measurement time between two exchanges of temperatures between fusion and hydraulic model."""


class ReplayError(ValueError):
    """A recording from which the twin cannot be driven; the message names file, topic and what is missing."""


@dataclass(frozen=True)
class SensorComparison:
    """One temperature sensor against the twin.

    Attributes:
        node: thermal node that it reads. time: s, (m,). measured: K, (m,).
        predicted: K, the free run seen through the sensor's lag, (m,).
        fused: K, the estimate seen through the lag, (m,). fused_std: K, of the node, (m,).
        noise: K. used: whether the fusion was given this sensor.
    """

    node: str
    time: np.ndarray
    measured: np.ndarray
    predicted: np.ndarray
    fused: np.ndarray
    fused_std: np.ndarray
    noise: float
    used: bool


@dataclass(frozen=True)
class ReplayResult:
    """What the twin makes of a recording, on intervals that end at ``time``.

    Attributes:
        time: s from the recording's epoch, (n,). measured: `MEASURED_DTYPE`, (n,).
        soft, free: operating points of soft sensor and free run, `OPERATING_DTYPE`, (n,).
        free_temperature, fused, fused_std: K, (n, N), order `thermal_network.NODES`.
        sensors: by name. innovations: every reading that the filter met.
        seconds: computing time of each stage.
    """

    recording: Recording
    rig: Rig
    time: np.ndarray
    measured: np.ndarray
    soft: np.ndarray
    free: np.ndarray
    free_temperature: np.ndarray
    fused: np.ndarray
    fused_std: np.ndarray
    sensors: dict[str, SensorComparison]
    innovations: list[Innovation]
    seconds: dict[str, float]


def replay(recording: Recording, rig: Rig, interval: float = INTERVAL, without: Collection[str] = (),
           state: FusionState | None = None, progress: Callable[[float], None] | None = None) -> ReplayResult:
    """Run models and fusion over a screened recording.

    Args:
        recording: with sorted streams (see `telemetry.screening`). rig: the rig.
        interval: s of one output. without: sensors that the fusion must not see.
        state: of the filter at the start, None starts anew. progress: told the share done.

    Raises:
        ReplayError: where there is no drive telemetry.
    """
    if recording.drive is None or len(recording.drive) == 0:
        raise ReplayError(f"{recording.path}: drive/telemetry: no message; the twin needs at least the drive's speed and current")
    clock = time.perf_counter()
    first, edges = _edges(recording, interval)
    n = edges.size - 1
    measured, command = _reduce(recording, first, interval, n)
    air, first_air = _ambient(recording, rig, edges)
    readings = _readings(recording, edges, without)
    seconds = {"intervals": time.perf_counter() - clock, "hydraulic_model": 0.0, "machine_thermal": 0.0, "temperature_fusion": 0.0}

    start_temperature = _start_temperature(recording, first_air)
    payload = recording.rig.payload_mass if recording.rig is not None else None
    hydraulics = HydraulicModel(rig, start_temperature, payload, interval)
    motor = MachineThermal(rig, start_temperature, interval)
    fusion = TemperatureFusion(rig, interval, ambient=first_air if "ambient" in recording.temperatures else None)
    if state is not None:
        fusion.state = state

    soft, free = np.zeros(n, OPERATING_DTYPE), np.zeros(n, OPERATING_DTYPE)
    free_temperature, fused, fused_std = np.empty((n, N)), np.empty((n, N)), np.empty((n, N))
    free_reading = np.empty((n, len(NODE_OF_SENSOR)))
    fused_reading = np.empty((n, len(NODE_OF_SENSOR)))
    innovations: list[Innovation] = []
    block = max(1, round(BLOCK / interval))
    at = 0
    for start in range(0, n, block):
        rows = slice(start, min(n, start + block))
        clock = time.perf_counter()
        result = hydraulics.advance(measured[rows], command[start: rows.stop + 1], air[rows])
        seconds["hydraulic_model"] += time.perf_counter() - clock
        clock = time.perf_counter()
        motor_result = motor.advance(measured[rows], air[rows])
        seconds["machine_thermal"] += time.perf_counter() - clock
        clock = time.perf_counter()
        now = []
        while at < len(readings) and readings[at].index < rows.stop:
            now.append(Reading(readings[at].index - start, readings[at].sensor, readings[at].temperature))
            at += 1
        estimate = fusion.advance(_inputs(result, motor_result, air[rows]), now)
        hydraulics.use_temperatures(estimate.temperature[-1])
        seconds["temperature_fusion"] += time.perf_counter() - clock
        soft[rows], free[rows] = result.soft, result.free
        free_temperature[rows] = result.free_temperature
        fused[rows], fused_std[rows] = estimate.temperature, estimate.standard_deviation
        fused_reading[rows] = estimate.reading
        innovations += [Innovation(i.index + start, i.sensor, i.measured, i.expected, i.standard_deviation, i.accepted)
                        for i in estimate.innovations]
        if progress is not None:
            progress(rows.stop / n)
    lag = rig["sensors.temperature.time_constant"]
    nodes = list(NODE_INDEX.values())
    _lagged(free_temperature[:, nodes], start_temperature[nodes], interval, lag, free_reading)
    time_axis = edges[1:]
    sensors = {
        name: _compare(name, stream, time_axis, free_reading[:, i], fused_reading[:, i], fused_std[:, NODE_INDEX[name]], rig, name not in without)
        for i, name in enumerate(NODE_OF_SENSOR)
        if (stream := recording.temperatures.get(name)) is not None
    }
    return ReplayResult(recording, rig, time_axis, measured, soft, free, free_temperature, fused, fused_std, sensors, innovations, seconds)


def _inputs(hydraulic, motor, air: np.ndarray) -> FusionInputs:
    heat = hydraulic.soft["heat"].copy()
    heat[:, : len(MOTOR_NODES)] = motor.points["heat"][:, : len(MOTOR_NODES)]
    return FusionInputs(
        heat, motor.points["mean_square_current"].copy(), np.ascontiguousarray(hydraulic.soft["flow"]),
        hydraulic.soft["rod_position"].copy(), hydraulic.known, motor.known, air,
    )


def _edges(recording: Recording, interval: float) -> tuple[float, np.ndarray]:
    """Edges of the intervals: whole multiples of the interval in absolute stamp time, s from the epoch."""
    step = int(round(interval * 1e9))
    start, stop = recording.span
    first = (recording.epoch_ns + int(np.floor(start * 1e9)) - 1) // step * step - recording.epoch_ns
    count = int(np.ceil((stop * 1e9 - first) / step))
    return first * 1e-9, (first + step * np.arange(count + 1, dtype=np.int64)) * 1e-9


def _reduce(recording: Recording, first: float, interval: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    measured = np.zeros(n, MEASURED_DTYPE)
    command = np.empty(n + 1)
    ends = first + interval * np.arange(1, n + 1)
    drive, hydraulic = recording.drive, recording.hydraulic
    hydraulic_time = hydraulic.time if hydraulic is not None else np.empty(0)
    hydraulic_values = hydraulic.values if hydraulic is not None else np.empty((0, 4))
    reduce_intervals(
        first, interval, drive.time, np.ascontiguousarray(drive.values), np.searchsorted(drive.time, ends, "right"),
        hydraulic_time, np.ascontiguousarray(hydraulic_values), np.searchsorted(hydraulic_time, ends, "right"),
        new_carry(), measured, command,
    )
    return measured, command


def _ambient(recording: Recording, rig: Rig, edges: np.ndarray) -> tuple[np.ndarray, float]:
    """Air temperature held from reading to reading, K, per interval, and the first one."""
    stream = recording.temperatures.get("ambient")
    good = np.isfinite(stream.column("temperature")) if stream is not None else np.zeros(0, bool)
    if not good.any():
        value = ZERO_CELSIUS + rig["ambient"]
        return np.full(edges.size - 1, value), value
    when, value = stream.time[good], stream.column("temperature")[good]
    width = max(1, min(value.size, int(round(10.0 / max(1e-3, float(np.median(np.diff(when))) if when.size > 1 else 10.0)))))
    smooth = np.convolve(np.pad(value, (width - 1, 0), mode="edge"), np.full(width, 1.0 / width), mode="valid")
    at = np.clip(np.searchsorted(when, edges[1:], "right") - 1, 0, None)
    return smooth[at], float(value[:width].mean())


def _readings(recording: Recording, edges: np.ndarray, without: Collection[str]) -> list[Reading]:
    found = []
    for name, stream in recording.temperatures.items():
        if name == "ambient" or name in without or name not in NODE_INDEX:
            continue
        values = stream.column("temperature")
        index = np.searchsorted(edges, stream.time, "left") - 1
        found += [Reading(int(i), name, float(v)) for i, v in zip(index, values) if np.isfinite(v) and i >= 0]
    found.sort(key=lambda reading: reading.index)
    return found


def _start_temperature(recording: Recording, ambient: float) -> np.ndarray:
    """Temperatures at the start, K, (N,): the first readings, spread to the nodes beside them; else ambient."""
    first = {}
    for name, stream in recording.temperatures.items():
        values = stream.column("temperature")[:10]
        values = values[np.isfinite(values)]
        if name in NODE_INDEX and values.size:
            first[NODE_OF_SENSOR[name]] = float(values.mean())
    return spread_start(first, ambient)


def _lagged(temperature: np.ndarray, start: np.ndarray, interval: float, lag: float, out: np.ndarray) -> None:
    from scipy.signal import lfilter

    keep = np.exp(-interval / lag)
    for j in range(temperature.shape[1]):
        out[:, j], _ = lfilter([1.0 - keep], [1.0, -keep], temperature[:, j], zi=[keep * start[j]])


def _compare(name, stream, axis, free, fused, fused_std, rig: Rig, used: bool) -> SensorComparison:
    measured = stream.column("temperature")
    return SensorComparison(
        NODE_OF_SENSOR[name], stream.time, measured, np.interp(stream.time, axis, free), np.interp(stream.time, axis, fused),
        np.interp(stream.time, axis, fused_std), rig.sensors["temperature"].noise, used,
    )
