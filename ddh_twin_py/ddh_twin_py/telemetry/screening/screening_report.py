"""Say what screening found, in sentences that name file, topic, field, value and what is allowed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.telemetry.causes import CAUSES, OF_FIELD, Cause
from ddh_twin_py.telemetry.clocks.clock import PUT_BACK
from ddh_twin_py.telemetry.recording import Finding
from ddh_twin_py.telemetry.signals import Signal, UnitMistake
from ddh_twin_py.telemetry.units.unit_suspicion import UnitSuspicion

_MENDED = (Cause.NOT_A_NUMBER, Cause.REPEATED, Cause.OUT_OF_ORDER)
_LEAST_FOR_UNIT = 10  # samples out of range before a mistake of unit is named,
_LEAST_SHARE_FOR_UNIT = 0.2  # and their share of all samples
_HUGE, _SHARE_OF_HUGE = 1e4, 0.7  # factor from which hardly a sample stays in range, and the share of those that do not at least
_NEARLY_ALL = 0.95  # of the samples, from which what is left is no measurement any more


@dataclass(frozen=True)
class Counted:
    """What was counted of one topic with m signals, by cause in the order of `CAUSES` and by signal.

    Attributes:
        signals: m. samples: of the topic. counts: int64[10, m]. first: ns, int64[10, m], when each cause struck first.
        first_value: float64[10, m], what was read then. explaining: bool[m, k], mistakes of unit that explain all that is out of range.
        noise: float64[m], expected. full_scale: float64[m], of the sensors by the rig file. ends: float64[m], by their readings.
        stuck_since: ns, int64[m], where the first run of a stuck signal began. suspicions: wrong units.
    """

    signals: Sequence[Signal]
    samples: int
    counts: np.ndarray
    first: np.ndarray
    first_value: np.ndarray
    explaining: np.ndarray
    noise: np.ndarray
    full_scale: np.ndarray
    ends: np.ndarray
    stuck_since: np.ndarray
    suspicions: Sequence[UnitSuspicion]


def findings_of(
    counted: Counted, file: str, topic: str, epoch_ns: int, whole: bool, unit: UnitMistake | None = None
) -> list[Finding]:
    """What looks like a wrong unit, then one per cause and field; times in s relative to ``epoch_ns``.

    ``whole``: whether nothing is used of a signal that is out of range in another unit; ``unit``: in which that is, as others tell.
    """
    where = _where(file, topic)
    signals, samples = counted.signals, counted.samples
    found = [_unit_finding(suspicion, counted, file, topic, epoch_ns) for suspicion in counted.suspicions]
    suspected = {j for suspicion in counted.suspicions for j in suspicion.fields}
    for row, cause in enumerate(CAUSES):
        for j, signal in enumerate(signals if cause in OF_FIELD else signals[:1]):
            count = int(counted.counts[row, j])
            if not count or cause is Cause.WRONG_UNIT:
                continue
            if cause in (Cause.OUT_OF_RANGE, Cause.SATURATED) and j in suspected:
                continue  # how it is wrong is told already, and nothing of it is used
            at = _seconds(counted.first[row, j], epoch_ns)
            value = float(counted.first_value[row, j])
            if cause in OF_FIELD:
                said = _field_sentence(counted, cause, j, epoch_ns, whole, unit)
                severity = "error" if _lost(cause, signal, count, samples, counted.explaining[j]) else "warning"
                found.append(Finding(severity, file, topic, signal.field, signal.to_message(value), count,
                                     f"{where} {signal.field} {said}", at, cause in _MENDED))
            else:
                said = _sample_sentence(cause, value, count, samples, at)
                found.append(Finding("warning", file, topic, "", value, count, f"{where} {said}", at, cause in _MENDED))
    return found


def _where(file: str, topic: str) -> str:
    return f"{file}: {topic}" if file else topic


def _seconds(stamp: np.int64, epoch_ns: int) -> float:
    return (int(stamp) - epoch_ns) * 1e-9


def _field_sentence(counted: Counted, cause: Cause, j: int, epoch_ns: int, whole: bool, told: UnitMistake | None) -> str:
    """What a cause did to signal j."""
    row, signal, samples = CAUSES.index(cause), counted.signals[j], counted.samples
    count, at = int(counted.counts[row, j]), _seconds(counted.first[row, j], epoch_ns)
    value = signal.to_message(float(counted.first_value[row, j]))
    often = f"{count} of {samples} samples"
    unit = signal.message_unit
    if cause is Cause.NOT_A_NUMBER:
        if count == samples:
            return f"has no value (NaN) in any of {samples} samples: it is not measured"
        return f"is NaN in {often}, first at {at:.3f} s: the sensor dropped out"
    if cause is Cause.INFINITE:
        return f"is {value} in {often}, first at {at:.3f} s; not used"
    if cause is Cause.STUCK:
        return (
            f"is stuck: it repeats exactly {value:.6g} {unit} since {_seconds(counted.stuck_since[j], epoch_ns):.3f} s "
            f"although noise of {counted.noise[j]:.3g} {signal.unit} "
            f"is expected; {often} are not used, the first at {at:.3f} s"
        )
    if cause is Cause.SATURATED:
        full, end = (signal.to_message(float(limit[j])) for limit in (counted.full_scale, counted.ends))
        told = f"the sensor's full scale is {full:g} {unit}" if full <= end else "none is larger, and noise repeats no reading so often"
        return f"reads {value:.6g} {unit} at {at:.3f} s, {told}: it is saturated in {often}, which are not used"
    lowest, highest = signal.to_message(signal.lowest), signal.to_message(signal.highest)
    said = (
        f"reads {value:.6g} {unit} at {at:.3f} s, allowed are {lowest:g} to {highest:g} {unit}; "
        f"{often} are out of range and not used"
    )
    likely = _mistake(signal, count, samples, counted.explaining[j])
    if likely:
        likely = (told,) if told is not None else likely
        others = ", nor are the others" if whole else ""
        said = (f"looks as if given in {' or '.join(one.unit for one in likely)} ({' or '.join(_factor(one, signal) for one in likely)}), "
                f"expected is {unit}: it {said}{others}")
    return said


def in_another_unit(
    signals: Sequence[Signal], out_of_range: Sequence[int], samples: int, mistaken: np.ndarray
) -> dict[int, tuple[UnitMistake, ...]]:
    """Which signals, of whose samples so many are out of range, look as if given in which wrong units, those within range too."""
    found = {j: _mistake(signal, int(out_of_range[j]), samples, mistaken[j]) for j, signal in enumerate(signals)}
    return {j: units for j, units in found.items() if units}


def _mistake(signal: Signal, count: int, samples: int, mistaken: np.ndarray) -> tuple[UnitMistake, ...]:
    """The units in which a signal looks as if given, of which so many samples are out of range."""
    if count < max(_LEAST_FOR_UNIT, _LEAST_SHARE_FOR_UNIT * samples):
        return ()
    return tuple(m for m, still in zip(signal.mistakes, mistaken, strict=False)
                 if still and (m.factor < _HUGE or count >= _SHARE_OF_HUGE * samples))


def _lost(cause: Cause, signal: Signal, count: int, samples: int, mistaken: np.ndarray) -> bool:
    """Whether a signal that is measured is as good as lost."""
    if cause is Cause.NOT_A_NUMBER:
        return _NEARLY_ALL * samples <= count < samples
    return cause is Cause.OUT_OF_RANGE and bool(_mistake(signal, count, samples, mistaken))


def _factor(mistake: UnitMistake, signal: Signal) -> str:
    """What the mistake does to a number of the message."""
    offset = round(mistake.offset + (mistake.factor - 1.0) * signal.message_offset, 6)
    factor = f"factor {mistake.factor:.4g}" if mistake.factor != 1.0 else ""
    return ", ".join(filter(None, (factor, f"{offset:+g}" if offset else "")))


def _sample_sentence(cause: Cause, value: float, count: int, samples: int, at: float) -> str:
    if cause is Cause.REPEATED:
        return f"repeats a stamp in {count} of {samples} messages, first at {at:.3f} s; repetitions are not used"
    if cause is Cause.OUT_OF_ORDER:
        late = f"{value:.3f}" if value >= 0.001 else "less than 0.001"
        return (
            f"has {count} of {samples} messages out of order, the first is {late} s late at {at:.3f} s; "
            "they are sorted in"
        )
    if cause is Cause.CLOCK_JUMP:
        times = "once" if count == 1 else f"{count} times"
        then = "goes on as warm as it is" if round(value, 2) <= PUT_BACK else "begins anew"
        return f"has a clock that jumped back {times}, first by {value:.3f} s to {at:.3f} s; the twin {then} there"
    times = "once" if count == 1 else f"{count} times"
    return f"stopped {times} and came back, first after {value:.3f} s without a sample, at {at:.3f} s"


def _unit_finding(suspicion: UnitSuspicion, counted: Counted, file: str, topic: str, epoch_ns: int) -> Finding:
    where, signals = _where(file, topic), counted.signals
    if not suspicion.fields:
        return Finding("warning", file, topic, "", None, 1, f"{where}: {suspicion.reason}; all are used")
    row = OF_FIELD.index(Cause.WRONG_UNIT)
    j = suspicion.fields[0]
    names = " and ".join(signals[k].field for k in suspicion.fields)
    count = int(counted.counts[row, list(suspicion.fields)].max())
    value = float(counted.first_value[row, j])
    at = _seconds(counted.first[row, j], epoch_ns) if count else float("nan")
    said = suspicion.reason
    if suspicion.units:
        looks = "looks" if len(suspicion.fields) == 1 else "look"
        said = f"{looks} as if given in {suspicion.unit} (factor {suspicion.factor}), expected is {signals[j].message_unit}: {said}"
    return Finding("error", file, topic, signals[j].field, value, count, f"{where} {names} {said}; not used", at)
