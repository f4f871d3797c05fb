"""A recording prepared for free runs: what the twin predicts of every sample, for any parameters.

Calibration fits it, and whoever wants to know how far a free run is off asks it. The run starts
at the measured pressures, position and temperatures and is given speed command, payload and
ambient; at each standstill the rod is put back to where it was measured, and the error of the
stroke that ended there counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from ddh_twin_py.estimation.sensors import NODE_INDEX, NODE_OF_SENSOR
from ddh_twin_py.estimation.start import START, spread_start
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.free_run import HYDRAULIC_STEP, SAMPLED, free_run_sampled, settle
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES
from ddh_twin_py.physics.motor_samples import electrical_samples
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE
from ddh_twin_py.physics.thermal_network import END_WINDING, N, SLOT_WINDING
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.alignment import align
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.screening import screen_recording
from ddh_twin_py.telemetry.signals import DRIVE_FIELDS, DRIVE_TOPIC, HYDRAULIC_FIELDS, HYDRAULIC_TOPIC
from ddh_twin_py.twin.ambient import AmbientTracker
from ddh_twin_py.twin.intervals import INTERVAL, STANDSTILL, command_size, new_carry, reduce_intervals

DRIVE_SIGNALS = ("speed", "current", "voltage", "electrical_power")
HYDRAULIC_SIGNALS = ("pressure_piston_side", "pressure_rod_side", "rod_velocity")
STROKE = "rod_position"
PRESSURES = ("pressure_piston_side", "pressure_rod_side")


class ExperimentError(ValueError):
    """A recording that no free run can be compared with; the message names file and topic."""


@dataclass(frozen=True)
class Signal:
    """Samples of one signal: s since the start of the run, values in SI, noise of one sample."""

    time: np.ndarray
    measured: np.ndarray
    noise: float


class Experiment:
    """One recording and the free run over it.

    Args:
        recording: as read. rig: gives noise and what is not measured. interval: s.
        start, stop: s from the recording's epoch, a part of it.

    Attributes:
        signals: by name; temperatures as ``temperature/<sensor>``, the error of each stroke as
            ``rod_position``.
        sensors: temperature sensors that are there, ``ambient`` left out.

    Raises:
        ExperimentError: no drive or hydraulic telemetry, or a clock that jumped.
    """

    def __init__(self, recording: Recording, rig: Rig, interval: float = INTERVAL) -> None:
        noise = {name: spec.noise for name, spec in rig.sensors.items()}
        recording = screen_recording(recording, noise)
        for topic, stream in ((DRIVE_TOPIC, recording.drive), (HYDRAULIC_TOPIC, recording.hydraulic)):
            if stream is None or not len(stream):
                raise ExperimentError(
                    f"{recording.path}: {recording.namespace}/{topic}: no message; a free run cannot be compared without it")
        ticks = align(recording, interval)
        if ticks.restart.any():
            raise ExperimentError(f"{recording.path}: the clock jumps {int(ticks.restart.sum())} times; cut the recording there")
        self.recording, self.interval = recording, interval
        said = recording.rig.payload_mass if recording.rig is not None else np.nan
        self.payload = said if np.isfinite(said) else rig["load.payload_mass"]
        n = len(ticks)
        begin = (ticks.end_ns[0] - recording.epoch_ns) * 1e-9 - interval
        self._epoch = begin
        drive, hydraulic = ticks.samples[DRIVE_TOPIC], ticks.samples[HYDRAULIC_TOPIC]
        drive_time = (drive.stamp - recording.epoch_ns) * 1e-9 - begin
        hydraulic_time = (hydraulic.stamp - recording.epoch_ns) * 1e-9 - begin
        measured, self._command = np.zeros(n, MEASURED_DTYPE), np.empty(command_size(n))
        reduce_intervals(0.0, interval, drive_time, np.ascontiguousarray(drive.values), ticks.last[DRIVE_TOPIC],
                         hydraulic_time, np.ascontiguousarray(hydraulic.values), ticks.last[HYDRAULIC_TOPIC],
                         new_carry(), measured, self._command)
        self._command = np.where(np.isfinite(self._command), self._command, 0.0)
        standing = (measured["standstill"] >= STANDSTILL) & np.isfinite(measured["rod_position"])
        self._put_back = np.where(standing, measured["rod_position"], np.nan)
        self._stroke_ends = np.flatnonzero(standing[1:] & ~standing[:-1]) + 1
        self._stroke_ends = self._stroke_ends[self._stroke_ends * interval > 1.0]
        self._air = self._ambient(ticks, rig, n)
        self._start = {name: _first_finite(measured[name]) for name in (*PRESSURES, "rod_position")}
        self._instants = np.sort(np.concatenate([drive_time, hydraulic_time]))
        self._at_drive = np.searchsorted(self._instants, drive_time)
        self._at_hydraulic = np.searchsorted(self._instants, hydraulic_time)
        self._axis = interval * np.arange(1, n + 1)

        self.signals: dict[str, Signal] = {}
        for name in DRIVE_SIGNALS:
            self.signals[name] = Signal(drive_time, drive.values[:, DRIVE_FIELDS.index(name)], noise[name])
        for name in HYDRAULIC_SIGNALS:
            kind = "pressure" if name in PRESSURES else name
            self.signals[name] = Signal(hydraulic_time, hydraulic.values[:, HYDRAULIC_FIELDS.index(name)], noise[kind])
        self.signals[STROKE] = Signal(self._axis[self._stroke_ends], self._put_back[self._stroke_ends], noise[STROKE])
        self.sensors = []
        for name in NODE_OF_SENSOR:
            samples = ticks.samples.get(f"temperature/{name}")
            if samples is not None and len(samples) and np.isfinite(samples.values[:, 0]).any():
                when = (samples.stamp - recording.epoch_ns) * 1e-9 - begin
                self.signals[f"temperature/{name}"] = Signal(when, samples.values[:, 0], noise["temperature"])
                self.sensors.append(name)
        self._first_readings = {
            name: float(np.nanmean(s.measured[s.time <= START])) for name in self.sensors
            if np.isfinite((s := self.signals[f"temperature/{name}"]).measured[s.time <= START]).any()
        }

    def _ambient(self, ticks, rig: Rig, n: int) -> np.ndarray:
        samples = ticks.samples.get("temperature/ambient")
        read = np.full(n, np.nan)
        if samples is not None:
            index = np.searchsorted(ticks.last["temperature/ambient"], np.arange(len(samples)), "right")
            good = np.isfinite(samples.values[:, 0]) & (index < n)
            read[index[good]] = samples.values[good, 0]
        return AmbientTracker(ZERO_CELSIUS + rig["ambient"], self.interval).advance(read)

    @property
    def duration(self) -> float:
        """Length of the run, s."""
        return self._axis[-1]

    def predict(self, parameters: np.ndarray, offsets: dict[str, float] | None = None,
                step: float = HYDRAULIC_STEP) -> dict[str, np.ndarray]:
        """What every sample of `signals` should have read.

        Args:
            parameters: the rig's parameters, shape (1,); the payload is the recording's unless
                its ``load_payload_mass`` differs from the sheet's by a fit.
            offsets: zero errors of pressure sensors (Pa) and temperature sensors (K), by signal.
            step: s, hydraulic step.
        """
        offsets = offsets or {}
        p = parameters[0]
        state = np.zeros(len(HYDRAULIC_STATES))
        settle(parameters, state, self._start["rod_position"], self._start[PRESSURES[0]] - offsets.get(PRESSURES[0], 0.0),
               self._start[PRESSURES[1]] - offsets.get(PRESSURES[1], 0.0))
        first = {NODE_OF_SENSOR[name]: value - offsets.get(f"temperature/{name}", 0.0) for name, value in self._first_readings.items()}
        temperature = spread_start(first, self._air[min(self._air.size - 1, round(START / self.interval))])
        begin = temperature.copy()
        n = self._axis.size
        points, temperatures = np.zeros(n, OPERATING_DTYPE), np.empty((n, N))
        samples = np.full((self._instants.size, len(SAMPLED)), np.nan)
        free_run_sampled(parameters, state, temperature, self._command, self._air, self.interval, step, self._put_back,
                         points, temperatures, self._instants, samples)
        at_drive, at_hydraulic = samples[self._at_drive], samples[self._at_hydraulic]
        speed, current = at_drive[:, 0], at_drive[:, 1]
        slot = np.interp(self.signals["speed"].time, self._axis, temperatures[:, SLOT_WINDING])
        end = np.interp(self.signals["speed"].time, self._axis, temperatures[:, END_WINDING])
        electrical = _electrical(parameters, speed, current, slot, end)
        out = {"speed": speed, "current": current, "voltage": electrical[0], "electrical_power": electrical[1]}
        for name in HYDRAULIC_SIGNALS:
            out[name] = at_hydraulic[:, SAMPLED.index(name)] + offsets.get(name, 0.0)
        out[STROKE] = points["rod_position"][self._stroke_ends - 1]
        lag = p["sensors_temperature_time_constant"]
        keep = np.exp(-self.interval / lag)
        for name in self.sensors:
            node = temperatures[:, NODE_INDEX[name]]
            reading, _ = lfilter([1.0 - keep], [1.0, -keep], node, zi=[keep * begin[NODE_INDEX[name]]])
            signal = self.signals[f"temperature/{name}"]
            out[f"temperature/{name}"] = np.interp(signal.time, self._axis, reading) + offsets.get(f"temperature/{name}", 0.0)
        return out


def _electrical(parameters, speed, current, slot, end) -> tuple[np.ndarray, np.ndarray]:
    """Voltage (V) and power (W) of samples; see `physics.motor`."""
    voltage, power = np.empty(speed.size), np.empty(speed.size)
    electrical_samples(parameters, speed, current, slot, end, voltage, power)
    return voltage, power


def _first_finite(values: np.ndarray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite[0]) if finite.size else 0.0
