"""How well the twin agrees with what was measured: every number that report, JSON and summary show."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ddh_twin_py.names import first_of
from ddh_twin_py.report.replay.doubts import doubts, given
from ddh_twin_py.report.times import starts
from ddh_twin_py.report.units import ZERO_CELSIUS, in_unit, number, words
from ddh_twin_py.telemetry.signals import DRIVE_SIGNALS, DRIVE_TOPIC, HYDRAULIC_SIGNALS, HYDRAULIC_TOPIC, Signal
from ddh_twin_py.twin.hydraulic_model import UNSEEN
from ddh_twin_py.twin.intervals import HOLD

if TYPE_CHECKING:
    from ddh_twin_py.estimation.replay_result import ReplayResult, SensorComparison

FLOOR = 1.6
"""Multiples of a sensor's noise below which model and machine count as agreeing (interface, "Noise floor")."""
FAR = 5.0
"""Multiples of noise beyond which they clearly differ."""
LOST = 3.0
"""Standard deviations of noise and zero error together beyond which an estimate has lost its own sensor."""
SETTLING = 10.0
"""s after each start in which the filter finds the temperatures; left out of the RMS of fused temperatures."""
LOST_SHARE = 0.1
"""Share of the comparisons without a finite number beyond which nothing is said about agreement."""
_MOST_NAMES = 4
INPUTS = frozenset({"speed", "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity"})
"""What drives the soft sensor; comparing these with it would compare a measurement with itself."""
NOT_COUNTED = frozenset({"torque"})
"""Current times a constant: shown, not counted twice."""
COMPONENTS = {
    "motor copper": ("loss_copper",),
    "motor iron and friction": ("loss_iron", "loss_motor_friction"),
    "pump 1": ("loss_pump_1",),
    "pump 2": ("loss_pump_2",),
    "lines": ("loss_line_a", "loss_line_b"),
    "cylinder": ("loss_cylinder",),
    "relief valve": ("loss_relief_valve",),
    "check valves": ("loss_check_valve",),
}


@dataclass(frozen=True)
class SignalAgreement:
    """One signal of drive or hydraulics over all intervals in which it was sampled, from `UNSEEN` after each start where there is more, SI.

    Of a free run that was off, what it said meanwhile and for `UNSEEN` after it was taken up is not compared.

    `rms_soft` is None for the soft sensor's own inputs; `largest_free` is the largest absolute
    difference of the free run and `largest_at` its time, s.
    """

    name: str
    unit: str
    samples: int
    lowest: float
    highest: float
    rms_free: float
    rms_soft: float | None
    largest_free: float
    largest_at: float
    noise: float

    @property
    def free_in_noise(self) -> float:
        """RMS of the free run in multiples of the noise of one sample."""
        return self.rms_free / self.noise

    @property
    def soft_in_noise(self) -> float | None:
        """The same for the soft sensor."""
        return None if self.rms_soft is None else self.rms_soft / self.noise


@dataclass(frozen=True)
class TemperatureAgreement:
    """One temperature sensor: values at its last reading and RMS over all readings, K.

    `rms_fused` and `rms_left_out` leave out `SETTLING` after each start where there is more; `rms_fused_whole` does not.
    `used` says whether the fusion was given this sensor; `rms_left_out` and `std_left_out` are of
    an estimate that was not. `refused` readings did not pass the filter's gate. `zero` is the
    tolerance of the sensor's zero, one sigma.
    """

    sensor: str
    node: str
    samples: int
    refused: int
    used: bool
    measured: float
    predicted: float
    fused: float
    fused_std: float
    rms_predicted: float
    rms_fused: float
    rms_fused_whole: float
    rms_left_out: float | None
    std_left_out: float | None
    noise: float
    zero: float
    innovation_in_std: float

    @property
    def predicted_in_noise(self) -> float:
        """RMS of the free run in multiples of the noise."""
        return self.rms_predicted / self.noise


@dataclass(frozen=True)
class NodeEstimate:
    """One thermal node at the end, K."""

    node: str
    predicted: float
    fused: float
    fused_std: float
    sensor: str


@dataclass(frozen=True)
class Loss:
    """Mean loss of one component, W."""

    component: str
    soft: float
    free: float


@dataclass(frozen=True)
class Agreement:
    """All comparisons of one recording.

    `not_finite` maps what the twin gave no finite numbers for to the share of them that is not. `given` is what the free run knows,
    `doubts` keep it from being judged.
    """

    signals: tuple[SignalAgreement, ...]
    temperatures: tuple[TemperatureAgreement, ...]
    nodes: tuple[NodeEstimate, ...]
    losses: tuple[Loss, ...]
    energy: Mapping[str, float]
    duration: float
    intervals: int
    not_finite: Mapping[str, float] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()
    given: str = "speed command, payload and ambient"

    @property
    def counted(self) -> tuple[tuple[str, str, float, float], ...]:
        """Name, RMS with unit, RMS in SI, multiples of noise of all that the free run is judged by, worst first."""
        rows = [
            (words(s.name), in_unit(s.rms_free, s.unit), s.rms_free, s.free_in_noise)
            for s in self.signals if s.name not in NOT_COUNTED
        ]
        rows += [
            (f"{words(t.sensor)} temperature", f"{number(t.rms_predicted, 2)} K", t.rms_predicted, t.predicted_in_noise)
            for t in self.temperatures
        ]
        return tuple(sorted(rows, key=lambda row: -row[3] if math.isfinite(row[3]) else -math.inf))

    @property
    def level(self) -> str:
        """good, fair or poor, by what is furthest off; a fused temperature far from its sensor is poor."""
        if self.not_finite or self._fused_far:
            return "poor"
        found = level(self.counted[0][3]) if self.counted else "fair"
        return "fair" if self.doubts and found == "good" else found

    @property
    def _fused_far(self) -> TemperatureAgreement | None:
        """The worst fused temperature that is clearly off the sensor that it uses."""
        far = [t for t in self.temperatures if t.used and t.rms_fused > LOST * math.hypot(t.noise, t.zero)]
        return max(far, key=lambda t: t.rms_fused) if far else None

    @property
    def verdict(self) -> str:
        """One sentence that says how well the twin agrees, after what is doubtful about that."""
        if self.doubts:
            return f"Careful: {'; '.join(self.doubts)}. {self._said}"
        return self._said

    @property
    def _said(self) -> str:
        if self.not_finite:
            names = list(self.not_finite)
            share = max(self.not_finite.values())
            much = "" if share >= 1.0 else f" in {'up to ' * (len(names) > 1)}{number(100.0 * share, 0)} % of the comparisons"
            return (
                f"The twin gave no finite numbers for {first_of(names, _MOST_NAMES)}{much}: nothing can be said about "
                "agreement; look at the rig file and at the findings."
            )
        if not self.counted:
            return "The recording holds no signal that the twin could be compared with."
        parts = []
        for kind, noises in (
            ("signal", [s.free_in_noise for s in self.signals if s.name not in NOT_COUNTED]),
            ("temperature", [t.predicted_in_noise for t in self.temperatures]),
        ):
            if noises:
                within = sum(x <= FLOOR for x in noises)
                share = "all" if within == len(noises) else f"{within} of"
                parts.append(f"{share} {len(noises)} {kind}{'s' * (len(noises) > 1)}")
        sentence = (
            f"Given {self.given} alone, the twin agrees within "
            f"{FLOOR:g} times sensor noise with {' and '.join(parts)}"
        )
        name, rms, _, times = self.counted[0]
        if times > FLOOR:
            sentence += f"; furthest off is {name}, RMS {rms} or {beyond(times)} times noise"
        fused = [t for t in self.temperatures if t.used]
        far = self._fused_far
        if far:
            sentence += (
                f"; the fused temperature of {words(far.sensor)} lies {number(far.rms_fused, 2)} K RMS from the sensor "
                f"{'that it uses' if far.refused < far.samples else 'of which it believes no reading'}"
            )
        elif fused:
            worst = max(fused, key=lambda t: t.rms_fused)
            sentence += (
                f"; fused temperatures stay within {number(worst.rms_fused, 2)} K RMS of every sensor that they use"
                f"{f', the first {SETTLING:g} s left out' if self.duration > SETTLING else ''}"
            )
        else:
            sentence += "; no temperature sensor told the fusion anything"
        return sentence + "."

    def as_json(self) -> dict:
        """The comparisons as plain data, units in the names; temperatures in degC, differences in K."""
        return {
            "verdict": self.verdict,
            "level": self.level,
            "not_finite": dict(self.not_finite),
            "doubts": list(self.doubts),
            "duration_s": self.duration,
            "intervals": self.intervals,
            "noise_floor": FLOOR,
            "settling_left_out_of_rms_fused_s": SETTLING,
            "begin_left_out_of_signals_s": UNSEEN,
            "temperatures": [
                {
                    "sensor": t.sensor, "node": t.node, "samples": t.samples, "refused": t.refused, "used": t.used,
                    "measured_final_degC": t.measured - ZERO_CELSIUS,
                    "predicted_final_degC": t.predicted - ZERO_CELSIUS,
                    "fused_final_degC": t.fused - ZERO_CELSIUS,
                    "fused_final_std_K": t.fused_std,
                    "rms_predicted_K": t.rms_predicted, "rms_fused_K": t.rms_fused,
                    "rms_fused_whole_K": t.rms_fused_whole,
                    "rms_left_out_K": t.rms_left_out, "std_left_out_K": t.std_left_out,
                    "noise_K": t.noise, "zero_tolerance_K": t.zero, "predicted_in_noise": t.predicted_in_noise,
                    "innovation_in_std": t.innovation_in_std,
                }
                for t in self.temperatures
            ],
            "signals": [
                asdict(s) | {"free_in_noise": s.free_in_noise, "soft_in_noise": s.soft_in_noise} for s in self.signals
            ],
            "nodes": [
                {
                    "node": n.node, "predicted_final_degC": n.predicted - ZERO_CELSIUS,
                    "fused_final_degC": n.fused - ZERO_CELSIUS, "fused_final_std_K": n.fused_std, "sensor": n.sensor,
                }
                for n in self.nodes
            ],
            "losses": [{"component": x.component, "soft_sensor_W": x.soft, "free_run_W": x.free} for x in self.losses],
            "mean_power_W": dict(self.energy),
        }


def beyond(times: float) -> str:
    """Multiples of noise beyond `FLOOR`, with as many decimals as it takes to see that."""
    return number(times, next((digits for digits in (1, 2, 3) if round(times, digits) > FLOOR), 4))


def level(in_noise: float) -> str:
    """good, fair or poor for a difference in multiples of noise."""
    return "good" if in_noise <= FLOOR else "fair" if in_noise <= FAR else "poor"


def compare(result: ReplayResult, left_out: Mapping[str, SensorComparison] | None = None) -> Agreement:
    """All comparisons of a replay.

    Args:
        left_out: per sensor the comparison of a replay whose fusion was not given that sensor.
    """
    from ddh_twin_py.physics.thermal_network import NODES

    sensor_of = {c.node: name for name, c in result.sensors.items()}
    n = result.time.size
    known = np.flatnonzero(np.isfinite(result.fused[:, 0]) & np.isfinite(result.free_temperature[:, 0]))
    nodes = tuple(
        NodeEstimate(node, *(float(a[known[-1], i]) for a in (result.free_temperature, result.fused, result.fused_std)),
                     sensor_of.get(node, ""))
        for i, node in enumerate(NODES)
    ) if known.size else ()
    return Agreement(
        signals=tuple(s for signal in (*DRIVE_SIGNALS, *HYDRAULIC_SIGNALS) if (s := _signal(signal, result))),
        temperatures=tuple(
            t for name, c in result.sensors.items() if (t := _temperature(name, c, result, (left_out or {}).get(name)))
        ),
        nodes=nodes,
        losses=tuple(
            Loss(component, component_mean(result.soft, fields), component_mean(result.free, fields))
            for component, fields in COMPONENTS.items()
        ),
        energy={
            f"{name}_{mode}": _mean(points[name])
            for name in ("electrical_power", "shaft_power", "hydraulic_power", "mechanical_power")
            for mode, points in (("soft_sensor", result.soft), ("free_run", result.free))
        },
        duration=n * float(np.median(np.diff(result.time))) if n > 1 else 0.0,
        intervals=int(n),
        not_finite=_not_finite(result),
        doubts=doubts(result), given=given(result.recording),
    )


def _not_finite(result: ReplayResult) -> dict[str, float]:
    """What was measured, or is estimated, and the share of it for which the twin has no finite number."""
    shares = {}
    for signal in (*DRIVE_SIGNALS, *HYDRAULIC_SIGNALS):
        if signal.noise_key is not None:
            measured = np.isfinite(measured_values(result, signal))
            shares[words(signal.name)] = _share_lost(result.free[signal.name][measured])
            if signal.name not in INPUTS:
                name = f"{words(signal.name)} of the soft sensor"
                shares[name] = _share_lost(result.soft[signal.name][measured])
    for name, c in result.sensors.items():
        here = np.isfinite(c.measured)
        shares[f"{words(name)} temperature"] = _share_lost(c.predicted[here])
        shares[f"fused {words(name)} temperature"] = _share_lost(c.fused[here])
    shares["the free run's temperatures"] = _share_lost(result.free_temperature)
    shares["the fused temperatures"] = _share_lost(result.fused)
    shares["the standard deviations of the fused temperatures"] = _share_lost(result.fused_std)
    return {name: share for name, share in shares.items() if share > LOST_SHARE}


def _share_lost(values: np.ndarray) -> float:
    return 1.0 - float(np.isfinite(values).mean()) if values.size else 0.0


def component_values(points: np.ndarray, fields: tuple[str, ...]) -> np.ndarray:
    """Loss of one component, W, (n,)."""
    return np.sum([points[name] for name in fields], axis=0)


def component_mean(points: np.ndarray, fields: tuple[str, ...]) -> float:
    """Mean loss of one component, W."""
    return _mean(component_values(points, fields))


def measured_values(result: ReplayResult, signal: Signal) -> np.ndarray:
    """A signal's interval means, (n,); NaN where it was not measured."""
    age = result.measured["drive_age" if signal in DRIVE_SIGNALS else "hydraulic_age"]
    return np.where(age <= HOLD, result.measured[signal.name], np.nan)


def free_values(result: ReplayResult, signal: Signal) -> np.ndarray:
    """The free run of a signal where its samples lie in each interval, (n,); NaN where none came."""
    return result.free_where_sampled(signal.name, DRIVE_TOPIC if signal in DRIVE_SIGNALS else HYDRAULIC_TOPIC)


def _signal(signal: Signal, result: ReplayResult) -> SignalAgreement | None:
    if signal.noise_key is None:
        return None
    measured = measured_values(result, signal)
    difference = free_values(result, signal) - measured
    seen = _later(result.time, UNSEEN)
    if result.off.any():
        seen &= result.settled
    seen = seen if np.isfinite(difference[seen]).any() else np.ones(seen.size, dtype=bool)
    difference = np.where(seen, difference, np.nan)
    here = np.isfinite(difference)
    if not here.any():
        return None
    at = int(np.nanargmax(np.abs(difference)))
    return SignalAgreement(
        name=signal.name, unit=signal.unit, samples=int(here.sum()),
        lowest=float(np.nanmin(measured)), highest=float(np.nanmax(measured)), rms_free=_rms(difference),
        rms_soft=None if signal.name in INPUTS else _rms((result.soft[signal.name] - measured)[seen]),
        largest_free=float(abs(difference[at])), largest_at=float(result.time[at]),
        noise=float(result.rig.sensors[signal.noise_key].noise),
    )


def _temperature(
    name: str, c: SensorComparison, result: ReplayResult, left_out: SensorComparison | None
) -> TemperatureAgreement | None:
    here = np.flatnonzero(np.isfinite(c.measured))
    if not here.size:
        return None
    whole = here[np.isfinite(c.fused[here]) & np.isfinite(c.predicted[here])]
    last = whole[-1] if whole.size else here[-1]
    met = [i for i in result.innovations if i.sensor == name]
    normalised = np.array([(i.measured - i.expected) / i.standard_deviation for i in met if i.accepted])
    return TemperatureAgreement(
        sensor=name, node=c.node, samples=int(here.size), refused=sum(not i.accepted for i in met), used=c.used,
        measured=float(c.measured[last]), predicted=float(c.predicted[last]),
        fused=float(c.fused[last]), fused_std=float(c.fused_std[last]),
        rms_predicted=_rms(c.predicted - c.measured), rms_fused=_rms((c.fused - c.measured)[_settled(c)]),
        rms_fused_whole=_rms(c.fused - c.measured),
        rms_left_out=None if left_out is None else _rms((left_out.fused - left_out.measured)[_settled(left_out)]),
        std_left_out=None if left_out is None else float(left_out.fused_std[last]),
        noise=float(c.noise), zero=float(result.rig.sensors["temperature"].offset_tolerance),
        innovation_in_std=_rms(normalised),
    )


def signal_row(name: str) -> str:
    """A signal in words, as a table of signals has it."""
    return f"{words(name)} (not counted)" if name in NOT_COUNTED else words(name)


def _settled(c: SensorComparison) -> np.ndarray:
    """Readings `SETTLING` after each start and later, (m,); all where there is none."""
    late = _later(c.time, SETTLING)
    return late if np.isfinite((c.fused - c.measured)[late]).any() else np.ones(late.size, dtype=bool)


def _later(time: np.ndarray, than: float) -> np.ndarray:
    """Where it is so many s after each start or later, (m,)."""
    begun = starts(time)
    since = time - time[begun[np.searchsorted(begun, np.arange(time.size), "right") - 1]] if begun.size else time
    return since >= than


def _rms(difference: np.ndarray) -> float:
    finite = difference[np.isfinite(difference)]
    return float(np.sqrt(np.mean(finite * finite))) if finite.size else float("nan")


def _mean(values: np.ndarray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else float("nan")
