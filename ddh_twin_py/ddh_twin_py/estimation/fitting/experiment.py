"""A recording prepared for free runs: what the twin predicts of every sample, for any parameters.

Calibration fits it, and whoever wants to know how far a free run is off asks it. The run starts
at the measured pressures, position and temperatures and is given speed command, payload and
ambient; at each standstill the rod is put back to where it was measured, and the error of the
stroke that ended there counts. It is not put back onto an end stop, which is so stiff that the
noise of the position would press it with several times the load. An end stop that the measured rod
never met is taken away: a stroke that is a little too long would else end in a collision, and its
stalled shaft, emptied chamber and hot winding would hide what made it long.

A temperature that starts wrong stays wrong for minutes, and the first readings are few. So a
first run says how temperatures went on, and the readings of `start.EARLY` seconds say where they began. What no sensor reads
begins as a likely history leaves it (`history`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from ddh_twin_py.estimation.fitting.begin import FIRST, SHARE, told_begin
from ddh_twin_py.estimation.fitting.binning import Binning, by_cycle, by_time, cycle_of, one_by_one
from ddh_twin_py.estimation.fitting.history import cold, histories, likely_rise, open_begin
from ddh_twin_py.estimation.fitting.lent import Lent, lend, made
from ddh_twin_py.estimation.fitting.rod_rests import never_met, smoothed
from ddh_twin_py.estimation.fitting.run_inputs import RunInputs
from ddh_twin_py.estimation.fitting.step_size import times_finer
from ddh_twin_py.estimation.fitting.unpredictable import intervals_at, unpredictable
from ddh_twin_py.estimation.fusion.start import EARLY, START, air_at_start, spread_start, start_error
from ddh_twin_py.estimation.sensors import NODE_INDEX, NODE_OF_SENSOR
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.cylinder import holding_pressure
from ddh_twin_py.physics.free_run import COMMAND_PARTS, HYDRAULIC_STEP, SAMPLED, free_run, free_run_sampled
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES
from ddh_twin_py.physics.motor_samples import electrical_samples
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.sheet import SensorSpec
from ddh_twin_py.telemetry.alignment.recording_ticks import align
from ddh_twin_py.telemetry.clocks.jumps import why_apart
from ddh_twin_py.telemetry.clocks.set_ahead import set_ahead
from ddh_twin_py.telemetry.in_order import in_order
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.resolution import rounding_error
from ddh_twin_py.telemetry.screening.screening import screen_by_sheet
from ddh_twin_py.telemetry.signals import DRIVE_FIELDS, DRIVE_TOPIC, HYDRAULIC_FIELDS, HYDRAULIC_TOPIC
from ddh_twin_py.telemetry.spans import strangers
from ddh_twin_py.telemetry.ticks import Samples, Ticks
from ddh_twin_py.twin.ambient import AmbientTracker
from ddh_twin_py.twin.command import command_at
from ddh_twin_py.twin.hydraulic_model import UNSEEN, off_the_stops
from ddh_twin_py.twin.intervals import INTERVAL, STANDSTILL, command_size, new_carry, reduce_intervals
from ddh_twin_py.twin.rest import first_finite, rest_at
from ddh_twin_py.twin.temperature_sensors import INNER_SENSORS, sensed

DRIVE_SIGNALS = ("speed", "current", "voltage", "electrical_power")
HYDRAULIC_SIGNALS = ("pressure_piston_side", "pressure_rod_side", "rod_velocity")
STROKE = "rod_position"
_COMMAND, _VELOCITY = DRIVE_FIELDS.index("speed_command"), HYDRAULIC_FIELDS.index("rod_velocity")
NEIGHBOURHOOD = 20.0
"""s after the used part of a recording that count neither here nor there; at most half of what is held out."""
_REST = 0.5  # s of a standstill to either side that tell a position
_SHORTEST = 0.2  # s of a recording over which a run can be made
_BEFORE_THE_END = 1.0e-6  # s from the end of a run at which the last samples are taken: its last step ends there but for rounding
_BEHIND, _BEHIND_SLOWLY, _RESTED = {"motor_winding": 0.02}, 0.01, 1.0e-3
"""Share of what it reads above the air by which a sensor may lag behind its node at the start, and least K: copper is heated fast."""
_SINKS = 0.1  # of the noise of its velocity, by which a resting rod sinks
_LIMITED = 0.95  # of the drive's limit of current, beyond which its speed follows no command
_ROUGH, _ROUGH_INTERVAL = 20.0e-3, 0.2  # s, step and interval of the work in a history, which need not be known to 0.1 K
_ROUGHLY = 2  # intervals that a rough run takes as one
_COARSE = 0.5  # of its noise, from which the rounding of a temperature counts: finer steps are lost in it
_SLOW_BIN = 20.0  # s, of temperatures
PRESSURES = ("pressure_piston_side", "pressure_rod_side")


class ExperimentError(ValueError):
    """A recording that no free run can be compared with; the message names file and topic."""


@dataclass(frozen=True)
class Signal:
    """Samples of one signal: s since the start of the run, values in SI, noise of one sample, unit, bins.

    ``start_std``: standard deviation of what a run's reading is off by at the start, in its unit. ``held_from``: s from which samples count
    as held out. ``rounding``: the part of the noise that rounding makes, which neighbouring samples share. ``follows``: where the signal
    follows its command, bool (n,), as no limit of the drive holds it back; None: everywhere.
    ``per_stroke``: whether it is one number for each stroke, which sums up what happens on the way.
    """

    time: np.ndarray
    measured: np.ndarray
    noise: float
    unit: str
    binning: Binning
    start_std: float = 0.0
    held_from: float = np.inf
    rounding: float = 0.0
    follows: np.ndarray | None = None
    per_stroke: bool = False

    @property
    def held_back(self) -> np.ndarray:
        """Samples that count as held out, bool (n,)."""
        return np.isfinite(self.measured) & (self.time > self.held_from)


class Experiment:
    """One recording and the free run over it.

    Args:
        recording: as read. rig: gives noise and what is not measured. interval: s.
        used: share of the recording, from its begin, that is gathered into bins; the rest is held out.

    Attributes:
        signals: by name; temperatures as ``temperature/<sensor>``, the error of each stroke as
            ``rod_position``.
        axis: s, end of each interval, (n,). air: K, of each interval, (n,).
        sensors: temperature sensors of which a sample is used, ``ambient`` left out.
        left_out: s in which fast signals are not compared, by reason; of a rod that sticks and slips its velocity alone is not.

    Raises:
        ExperimentError: no drive or hydraulic telemetry, or a clock that jumped.
    """

    def __init__(self, recording: Recording, rig: Rig, interval: float = INTERVAL, used: float = 1.0) -> None:
        self._used_share = used
        recording, ticks = _in_one_stretch(recording, rig, interval)
        self.recording, self.interval = recording, interval
        self._sheet_payload = rig["load.payload_mass"]
        self.payload = rig.declaring(recording.rig.payload_mass if recording.rig is not None else None)["load.payload_mass"]
        n = len(ticks)
        self._begin_ns = int(ticks.end_ns[0]) - round(interval * 1e9)
        drive, hydraulic = ticks.samples[DRIVE_TOPIC], ticks.samples[HYDRAULIC_TOPIC]
        self._drive_time, self._hydraulic_time = self._since_begin(drive), self._since_begin(hydraulic)
        measured, command = np.zeros(n, MEASURED_DTYPE), np.empty(command_size(n))
        reduce_intervals(0.0, interval, self._drive_time, np.ascontiguousarray(drive.values), ticks.last[DRIVE_TOPIC],
                         self._hydraulic_time, np.ascontiguousarray(hydraulic.values), ticks.last[HYDRAULIC_TOPIC],
                         new_carry(), measured, command)
        command = command_at(self._drive_time, drive.values[:, _COMMAND], interval / COMMAND_PARTS * np.arange(command.size))
        standing = (measured["standstill"] >= STANDSTILL) & np.isfinite(measured["rod_position"])
        self._put_back = smoothed(np.where(standing, measured["rod_position"], np.nan), round(_REST / interval))
        placed = off_the_stops(self._put_back, rig, 2.0 * _REST * len(hydraulic) / (n * interval))
        self._stroke_ends = np.flatnonzero(standing[1:] & ~standing[:-1]) + 1
        self._stroke_ends = self._stroke_ends[self._stroke_ends * interval > 1.0]
        self.air = self._ambient(ticks, rig, n)
        self._past = never_met(measured["rod_position"], rig)
        self._start = {name: first_finite(measured[name], 0.0) for name in (*PRESSURES, "rod_position")}
        self._read_pressures = [bool(np.isfinite(measured[name]).any()) for name in PRESSURES]
        if not self._read_pressures[0]:
            self._start[PRESSURES[0]] = self._holding_pressure(rig)
        own = RunInputs(interval, command, self.air, placed)
        self._inputs = {False: own, True: own.of_every(_ROUGHLY)}
        self.axis = own.axis
        self._in_order = (0.0, self._merge(0.0))
        self.cycle = cycle_of(command, interval / COMMAND_PARTS)
        self.signals: dict[str, Signal] = {}
        self.left_out = self._take_fast(rig, drive.values, hydraulic.values, measured)
        self.sensors = self._take_temperatures(rig, ticks)
        firsts = {name: _first_reading(self.signals[f"temperature/{name}"]) for name in self.sensors}
        self._first_readings = {name: first for name, first in firsts.items() if np.isfinite(first)}
        self._sensor_at_start: dict[str, float] = {}
        self._finer: int | None = None
        self._rise, self._open = self._likely_begin(self.parameters(rig))
        self._first_readings |= self._better_start(rig)

    def _since_begin(self, samples: Samples) -> np.ndarray:
        """Times of samples since the start of the run, s, (m,)."""
        return (samples.stamp - self._begin_ns) * 1e-9

    def _take_fast(self, rig: Rig, drive: np.ndarray, hydraulic: np.ndarray, measured: np.ndarray) -> Mapping[str, float]:
        """Take up the signals of both streams, (m, fields) each, and the strokes; how many s of them are left out, by reason."""
        hidden = unpredictable(
            measured["rod_position"], measured["standstill"] >= STANDSTILL, self._inputs[False].placed, rig["cylinder.stroke"],
            self.interval, (self._drive_time, drive[:, _COMMAND]), (self._hydraulic_time, hydraulic[:, _VELOCITY]),
            rig.sensors["rod_velocity"].noise, self._set_ahead())
        shown, moved = (np.where(hidden.intervals[self._intervals_at(time)][:, None], np.nan, values)
                        for time, values in ((self._drive_time, drive), (self._hydraulic_time, hydraulic)))
        moved[hidden.slips, _VELOCITY] = np.nan
        for name in DRIVE_SIGNALS:
            self._add(name, rig.sensors[name], self._drive_time, shown[:, DRIVE_FIELDS.index(name)], self._fast)
        for name in HYDRAULIC_SIGNALS:
            kind = "pressure" if name in PRESSURES else name
            self._add(name, rig.sensors[kind], self._hydraulic_time, moved[:, HYDRAULIC_FIELDS.index(name)], self._fast)
        self._mark_limited(rig, drive[:, DRIVE_FIELDS.index("current")])
        self._mark_sinking()
        end = self.axis[self._stroke_ends]
        slipped = np.histogram(self._hydraulic_time[hidden.slips], np.concatenate([[0.0], end]))[0] > 0
        ends = np.where(slipped | hidden.lost[self._stroke_ends - 1], np.nan, self._put_back[self._stroke_ends])
        self._add(STROKE, rig.sensors[STROKE], end, ends, self._strokes)
        return hidden.seconds

    def _set_ahead(self) -> np.ndarray:
        """Where the clock was set ahead while the rod moved, s since the start of the run, (k,): the midst of the hole that this makes."""
        begun = (self._begin_ns - self.recording.epoch_ns) * 1e-9
        return set_ahead(self.recording.hydraulic)[:, :2].mean(axis=1) - begun

    def _take_temperatures(self, rig: Rig, ticks: Ticks) -> list[str]:
        """Take up the temperatures; the sensors of which there is a usable sample."""
        for name in NODE_OF_SENSOR:
            samples = ticks.samples.get(f"temperature/{name}")
            if samples is not None and len(samples):
                self._add(f"temperature/{name}", rig.sensors["temperature"], self._since_begin(samples), samples.values[:, 0], _slow)
        return [name for name in NODE_OF_SENSOR if f"temperature/{name}" in self.signals]

    def other_begin(self, parameters: np.ndarray) -> tuple[np.ndarray, float]:
        """How a unit with these parameters would have left what no sensor reads: rise of nodes, (N,), and how far one moves by it, K."""
        rise = self._likely_rise(parameters)
        return rise, float(np.abs(self._start_of(parameters, rise) - self._start_of(parameters, self._rise)).max())

    def begin_with(self, rise: np.ndarray) -> None:
        """Let what no sensor reads begin so warm: K above ambient, by node, (N,)."""
        self._rise = rise

    def _holding_pressure(self, rig: Rig) -> float:
        """Pressure of the piston side that holds the load at the start, Pa."""
        record = self.parameters(rig)[0]
        return float(holding_pressure(self._start["rod_position"], self._start[PRESSURES[1]], record))

    def _likely_begin(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rise of every node above ambient at the start, K, (N,), by the likeliest history, and ways in which it may differ, K, (c, N)."""
        read, air = self._first(parameters[0])
        been_through = self._histories(parameters, air)
        return likely_rise(been_through, read, air), open_begin(been_through, read, air)

    def _likely_rise(self, parameters: np.ndarray) -> np.ndarray:
        """The former alone: a cold unit needs no history for it."""
        read, air = self._first(parameters[0])
        return np.zeros(N) if cold(read, air) else likely_rise(self._histories(parameters, air), read, air)

    def _histories(self, parameters: np.ndarray, air: float) -> np.ndarray:
        """Temperatures of every node at the end of what the unit may have been through, K, (h, N), which began in air of so many K."""
        return histories(parameters, lambda begin: self._work(parameters, begin), _ROUGH_INTERVAL, air, self._start[STROKE])

    def _work(self, parameters: np.ndarray, begin: np.ndarray) -> np.ndarray:
        """Temperatures, roughly, each `_ROUGH_INTERVAL` of the own duty of a unit that began as warm as (N,) says, K, (m, N)."""
        group = min(self.axis.size, max(1, round(_ROUGH_INTERVAL / self.interval)))
        n = self.axis.size // group
        temperature, temperatures = begin.copy(), np.empty((n, N))
        inputs = self._inputs[False].of_every(group)
        free_run(parameters, self._settled(parameters), temperature, inputs.command[: command_size(n)], inputs.air[:n], inputs.interval,
                 _ROUGH, self._put(parameters, inputs.placed[:n]), np.zeros(n, OPERATING_DTYPE), temperatures)
        return temperatures

    def _better_start(self, rig: Rig) -> dict[str, float]:
        """What sensors without lag would have read at the start, K, from the first `EARLY` seconds; tells the signals how sure that is.

        What they read themselves goes to `_sensor_at_start`: while a winding is heated its sensor is a kelvin and more behind.
        """
        n = max(1, round(min(EARLY, self.used_until) / self.interval))
        parameters = self.parameters(rig)
        begins = [self._start_of(parameters, self._rise, way) for way in (*np.zeros((1, len(self._open))), *np.eye(len(self._open)))]
        runs = [made(n, 0) for _ in begins]
        for begin, lent in zip(begins, runs, strict=True):
            self._run(parameters, HYDRAULIC_STEP, begin, np.empty(0), lent, self._inputs[False])
        better = {}
        for name, crude in self._first_readings.items():
            signal = self.signals[f"temperature/{name}"]
            reading, *others = (self._reading(name, parameters[0], begin, lent.temperatures, self._inputs[False])
                                for begin, lent in zip(begins, runs, strict=True))
            used = np.isfinite(signal.measured) & (signal.time <= self.axis[n - 1])
            if not used.any():  # of a recording of less than a second
                continue
            off = signal.measured[used] - np.interp(signal.time[used], self.axis[:n], reading)
            change = float(reading[-1] - crude) * EARLY / self.axis[n - 1]
            behind = max(_RESTED, _BEHIND.get(name, _BEHIND_SLOWLY) * abs(crude - self.air[0]))
            otherwise = np.reshape([np.interp(signal.time[used], self.axis[:n], other - reading) for other in others], (-1, off.size)).T
            error, of_sensor, std = start_error(signal.time[used], off, change, signal.noise, _lag(name, parameters[0]), behind, otherwise)
            better[name], self._sensor_at_start[name] = crude + error, crude + of_sensor
            self.signals[f"temperature/{name}"] = replace(signal, start_std=std)
        return better

    def _add(self, name: str, sensor: SensorSpec, time: np.ndarray, measured: np.ndarray, binning) -> None:
        """Take up a signal of which there is at least one number."""
        usable = np.isfinite(measured) & (time <= self.used_until)
        if usable.any():
            rounding = rounding_error(measured) if name.startswith("temperature/") else 0.0
            rounding = rounding if rounding > _COARSE * sensor.noise else 0.0
            noise = float(np.hypot(sensor.noise, rounding))
            bins = binning(time, usable)
            self.signals[name] = Signal(time, measured, noise, sensor.unit, bins, held_from=self.held_from, rounding=rounding,
                                        per_stroke=name == STROKE)

    def _mark_limited(self, rig: Rig, current: np.ndarray) -> None:
        """Tell what follows the command that it does not where the drive gives all the current it may, A, (n,)."""
        known = in_order(self._drive_time, current)
        if not known.size:
            return
        limited = np.abs(current[known]) > _LIMITED * rig["motor.current_limit"]
        for name in {"speed", "rod_velocity"} & self.signals.keys():
            signal = self.signals[name]
            free = np.interp(signal.time, self._drive_time[known], limited) <= 0.0
            self.signals[name] = replace(signal, follows=free)

    def _mark_sinking(self) -> None:
        """Tell of the rod's velocity that it follows a leak, not the command, where the rod rests and sinks."""
        signal = self.signals.get("rod_velocity")
        if signal is None:
            return
        sinking = np.abs(np.gradient(self._put_back, self.interval)) > _SINKS * signal.noise
        follows = np.ones(signal.time.size, bool) if signal.follows is None else signal.follows
        self.signals["rod_velocity"] = replace(signal, follows=follows & ~sinking[self._intervals_at(signal.time)])

    def _intervals_at(self, time: np.ndarray) -> np.ndarray:
        """The interval in which each time, s (m,), lies, (m,); the nearest one of a time outside the run."""
        return intervals_at(time, self.interval, self.axis.size)

    def _fast(self, time: np.ndarray, usable: np.ndarray) -> Binning:
        return by_cycle(self.cycle, time, usable, UNSEEN)

    def _strokes(self, time: np.ndarray, usable: np.ndarray) -> Binning:
        """Each stroke by itself; upward and downward ones are two classes."""
        way = np.diff(self._put_back[np.concatenate([[0], self._stroke_ends])]) if usable.size else np.zeros(0)
        return one_by_one(time, usable & (time > UNSEEN), np.sign(np.nan_to_num(way)).astype(np.int64) + 1)

    def _ambient(self, ticks, rig: Rig, n: int) -> np.ndarray:
        samples = ticks.samples.get("temperature/ambient")
        read = np.full(n, np.nan)
        if samples is not None:
            index = np.searchsorted(ticks.last["temperature/ambient"], np.arange(len(samples)), "right")
            good = np.isfinite(samples.values[:, 0]) & (index < n)
            read[index[good]] = samples.values[good, 0]
        return AmbientTracker(ZERO_CELSIUS + rig["ambient"], self.interval).advance(read)

    @property
    def open_begins(self) -> int:
        """Number of ways in which it may begin otherwise than is likely, as too little is read of the motor or none of the oil."""
        return len(self._open)

    @property
    def used_until(self) -> float:
        """s since the start of the run up to which samples are gathered into bins."""
        return self._used_share * self.duration

    @property
    def held_from(self) -> float:
        """s since the start of the run from which samples are held out; between it and `used_until` they count nowhere."""
        return self.used_until + min(NEIGHBOURHOOD, 0.5 * (self.duration - self.used_until))

    @property
    def duration(self) -> float:
        """Length of the run, s."""
        return self.axis[-1]

    def phase_of_intervals(self) -> np.ndarray:
        """Index into `binning.PHASES` of the middle of each interval, (n,)."""
        return self.cycle.phase[COMMAND_PARTS // 2 :: COMMAND_PARTS][: self.axis.size]

    def parameters(self, rig: Rig) -> np.ndarray:
        """The record of a rig for this recording: what the rod lifts is declared outright, in true kg."""
        record = rig.parameters
        record["load_payload_mass"] *= record["load_payload_ratio"] * self.payload / self._sheet_payload
        record["load_payload_ratio"] = 1.0
        for end, past in self._past.items():
            record[f"cylinder_run_past_{end}"] = past
        return record

    def refine(self, parameters: np.ndarray, step: float) -> int:
        """Let runs take steps as much finer than asked as a fit with this ``step`` (s) needs, (`step_size`); how many times finer."""
        if self._finer is None:
            self._finer = 1
            self._finer = times_finer(self.signals, lambda finer: self.predict(parameters, step / finer))
        return self._finer

    def predict(self, parameters: np.ndarray, step: float = HYDRAULIC_STEP, own_history: bool = False,
                begin: Sequence[float] | None = (), roughly: bool = False) -> dict[str, np.ndarray]:
        """What every sample of `signals` should have read.

        Args:
            parameters: shape (1,), see `parameters`; its ``measurement_*`` say how the sensors err.
            step: s, hydraulic step, shorter where `refine` said so.
            own_history: what no sensor reads begins as a unit with these parameters would have left it,
                not as the rig that the experiment was made with. begin: standard deviations of each of the `open_begins` ways in which
                it begins otherwise; (): of none; None: as its first minutes tell. roughly: in `_ROUGHLY` times longer intervals, for
                differences of two such runs.
        """
        rise, step = self._likely_rise(parameters) if own_history else self._rise, step / (self._finer or 1)
        if begin is None:
            n = max(1, round(min(FIRST, SHARE * self.duration) / self.interval))
            begin = told_begin(self.signals, self.axis[n - 1], self.open_begins,
                               lambda z: self._readings(parameters, step, n, self._start_of(parameters, rise, z)))
        return self._readings(parameters, step, self._inputs[roughly].axis.size, self._start_of(parameters, rise, begin), roughly)

    def _readings(self, parameters: np.ndarray, step: float, n: int, start: np.ndarray, roughly: bool = False) -> dict[str, np.ndarray]:
        """What every sample should have read that was taken in the first n intervals, temperatures beginning at ``start``, K, (N,)."""
        inputs = self._inputs[roughly]
        p, axis = parameters[0], inputs.axis[:n]
        ends = -(-self._stroke_ends // (_ROUGHLY if roughly else 1))
        instants, at_drive, at_hydraulic = self._ordered(p["measurement_time_skew"])
        points, temperatures, samples = lent = lend(n, instants.size)
        self._run(parameters, step, start, instants, lent, inputs)
        speed, current = samples[at_drive, SAMPLED.index("speed")], samples[at_drive, SAMPLED.index("current")]
        voltage, power = np.empty(speed.size), np.empty(speed.size)
        electrical_samples(parameters, speed, current, self._drive_time, inputs.interval, temperatures, voltage, power)
        gain = p["measurement_current_gain"]
        out = {"speed": speed, "current": gain * current, "voltage": voltage, "electrical_power": gain * power}
        for name in HYDRAULIC_SIGNALS:
            out[name] = samples[at_hydraulic, SAMPLED.index(name)]
        out[PRESSURES[0]] = out[PRESSURES[0]] + p["measurement_pressure_piston_side_offset"]
        out[PRESSURES[1]] = p["measurement_pressure_rod_side_gain"] * out[PRESSURES[1]] + p["measurement_pressure_rod_side_offset"]
        out["rod_velocity"] = p["measurement_rod_position_scale"] * out["rod_velocity"]
        out[STROKE] = p["measurement_rod_position_scale"] * points["rod_position"][np.minimum(ends, n) - 1]
        for name in self.sensors:
            key = f"temperature/{name}"
            out[key] = np.interp(self.signals[key].time, axis, self._reading(name, p, start, temperatures, inputs))
        return {name: out[name] for name in self.signals}

    def operating(self, parameters: np.ndarray, step: float = HYDRAULIC_STEP,
                  begin: Sequence[float] = ()) -> tuple[np.ndarray, np.ndarray]:
        """Operating points (n,) and temperatures, K, (n, N), of the free run, interval by interval; see `predict`."""
        lent = made(self.axis.size, 0)
        self._run(parameters, step, self._start_of(parameters, self._rise, begin), np.empty(0), lent, self._inputs[False])
        return lent.points, lent.temperatures

    def _first(self, p: np.void) -> tuple[dict[str, float], float]:
        """Temperature of each node that is read at the start, and of the air around the unit, K."""
        at_start = air_at_start(self.air, self.interval) + p["surroundings_enclosure_rise"]
        first = {}
        for name, value in self._first_readings.items():
            first[NODE_OF_SENSOR[name]] = _met(name, value, at_start, p)
        return first, at_start

    def _start_of(self, parameters: np.ndarray, rise: np.ndarray, begin: Sequence[float] = ()) -> np.ndarray:
        """Temperature of every node at the start, K, (N,), where a history has left them with such rises, K, (N,); see `predict`."""
        start = spread_start(*self._first(parameters[0]), rise)
        return start + np.asarray(begin) @ self._open if len(begin) else start

    def _run(self, parameters: np.ndarray, step: float, begin: np.ndarray, instants: np.ndarray, lent: Lent,
             inputs: RunInputs) -> None:
        """Run as many of the intervals as there are operating points.

        Args:
            begin: temperatures at the start, K, (N,). instants: s, (m,). lent: where operating points, temperatures and samples go.
        """
        points, temperatures, samples = lent
        samples[:] = np.nan
        free_run_sampled(parameters, self._settled(parameters), begin.copy(), inputs.command, inputs.air, inputs.interval, step,
                         self._put(parameters, inputs.placed), points, temperatures, instants, samples)

    def _settled(self, parameters: np.ndarray) -> np.ndarray:
        """Hydraulic state at the start, at rest where it was measured, errors of the sensors apart; (`HYDRAULIC_STATES`,).

        Of what is not measured the start is the same whatever parameters are tried: the pressure that holds the load on the rig as it is
        given, and a rod that is retracted, from where most duties begin.
        """
        p, state = parameters[0], np.zeros(len(HYDRAULIC_STATES))
        piston, rod = (self._start[name] for name in PRESSURES)
        if self._read_pressures[0]:  # what is not measured has no zero error
            piston -= p["measurement_pressure_piston_side_offset"]
        if self._read_pressures[1]:
            rod = (rod - p["measurement_pressure_rod_side_offset"]) / p["measurement_pressure_rod_side_gain"]
        rest_at(parameters, state, self._start["rod_position"] / p["measurement_rod_position_scale"], piston, rod)
        return state

    def _put(self, parameters: np.ndarray, placed: np.ndarray) -> np.ndarray:
        """Where the rod truly is that was measured where it is put at standstills, m, (n,), NaN elsewhere."""
        return placed / parameters[0]["measurement_rod_position_scale"]

    def _ordered(self, skew: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """`_merge`, kept from the run before: of all parameters one alone changes it."""
        known, order = self._in_order
        if known != skew:
            order = self._merge(skew)
            self._in_order = skew, order
        return order

    def _merge(self, skew: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Both streams' instants in order, the hydraulic ones earlier by a skew, s, none after the end; where in it those of each are."""
        both = np.concatenate([self._drive_time, self._hydraulic_time - skew])
        order = np.argsort(both, kind="stable")  # which merges what is two runs in order
        place = np.empty(both.size, np.intp)
        place[order] = np.arange(both.size)
        n = self._drive_time.size
        return np.minimum(both[order], self.duration - _BEFORE_THE_END), place[:n], place[n:]

    def _reading(self, name: str, p: np.void, begin: np.ndarray, temperatures: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """What a temperature sensor reads at the end of each interval, K, (n,), of nodes that began at (N,) and went on as (n, N)."""
        node = sensed(temperatures, name, p["tank_top_share"])
        inner = name in INNER_SENSORS
        keep = np.exp(-inputs.interval / _lag(name, p))
        own = self._sensor_at_start.get(name)
        at_start = begin[NODE_INDEX[name]] if own is None else _met(name, own, self._first(p)[1], p)
        reading, _ = lfilter([1.0 - keep], [1.0, -keep], node, zi=[keep * at_start])
        if not inner:
            contact = p["measurement_surface_contact"]
            reading = (1.0 - contact) * reading + contact * (inputs.air[: reading.size] + p["surroundings_enclosure_rise"])
        return reading + p[f"measurement_{name}_offset"]


def _in_one_stretch(recording: Recording, rig: Rig, interval: float) -> tuple[Recording, Ticks]:
    """The recording, screened, and its ticks.

    Raises:
        ExperimentError: where no free run can be made over it.
    """
    recording = screen_by_sheet(recording, rig)
    for topic, stream in ((DRIVE_TOPIC, recording.drive), (HYDRAULIC_TOPIC, recording.hydraulic)):
        if stream is None or not len(stream):
            raise ExperimentError(f"{recording.path}: {recording.lack_of(topic)}; a free run cannot be compared without it")
    if apart := strangers(recording, DRIVE_TOPIC, HYDRAULIC_TOPIC):
        raise ExperimentError(apart)
    if recording.duration < _SHORTEST:
        raise ExperimentError(f"{recording.path}: lasts {recording.duration:.2g} s, which is too short for a free run; at least "
                              f"{_SHORTEST:g} s are needed")
    ticks = align(recording, interval)
    if ticks.restart.any():
        raise ExperimentError(why_apart(recording, ticks))
    return recording, ticks


def _lag(name: str, p: np.void) -> float:
    """Lag of a temperature sensor, s."""
    return float(p["sensors_temperature_time_constant"] * (1.0 if name in INNER_SENSORS else p["measurement_surface_lag_ratio"]))


def _met(name: str, reading: float, air: float, p: np.void) -> float:
    """Temperature that a sensor met where it read so, K, lag apart; ``air`` around the unit, K."""
    reading = reading - p[f"measurement_{name}_offset"]
    contact = 0.0 if name in INNER_SENSORS else p["measurement_surface_contact"]
    return (reading - contact * air) / (1.0 - contact)


def _first_reading(signal: Signal) -> float:
    """Mean of the readings of the first `START` seconds, of a slower sensor its first one within `EARLY`; NaN where there is none."""
    read = np.isfinite(signal.measured)
    first = signal.measured[read & (signal.time <= START)]
    first = first if first.size else signal.measured[read & (signal.time <= EARLY)][:1]
    return float(first.mean()) if first.size else np.nan


def _slow(time: np.ndarray, usable: np.ndarray) -> Binning:
    return by_time(time, usable, _SLOW_BIN)
