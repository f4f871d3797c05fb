"""In which unit a drive tells its channels: the one of those in use in which they agree with each other, and which of them disagrees.

With the shaft's power T w, the electrical power P and the copper loss 3 R I^2 of a motor that drives, (P - 3 R I^2) / (T w) is 1 and some
iron loss, however slowly it turns; in another unit of speed it is as many times as much as that unit is larger. So it is where P or T is
wrong. Then P is no more sqrt(3) V I either, or T no more K_t I; where both hold it is the speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.telemetry.screening_kernel import EVIDENCE, RULE_A, RULE_B, RULE_C, RULE_COUNT
from ddh_twin_py.telemetry.signals import UnitMistake
from ddh_twin_py.telemetry.units.unit_scales import UnitScales
from ddh_twin_py.telemetry.units.unit_suspicion import UnitSuspicion

_SPEED_COMMAND, _SPEED, _TORQUE, _CURRENT, _VOLTAGE, _POWER = range(6)  # columns of DRIVE_FIELDS
_SPEEDS = (
    UnitMistake("rpm", 30.0 / math.pi),
    UnitMistake("rev/s", 0.5 / math.pi),
    UnitMistake("deg/s", 180.0 / math.pi),
)
_KW = UnitMistake("kW", 1e-3)
_NAMED = {_TORQUE: (UnitMistake("N*mm", 1e3),), _CURRENT: (UnitMistake("mA", 1e3),), _POWER: (_KW, UnitMistake("mW", 1e3)),
          _VOLTAGE: (UnitMistake("mV", 1e3), UnitMistake("kV", 1e-3))}
_AS_MUCH = 0.15  # relative, by which a factor may be off a unit's, as a sheet's torque constant may be off
_ENOUGH = EVIDENCE // 4  # samples of a relation that tell something
_FOLLOWS, _ROUGHLY = 0.15, 0.5  # relative; how near speed must be to its command where one of both is in another unit, and where both are
_TAKEN = (0.7, 2.2)  # what a motor takes for what it gives, copper loss aside
_TAKEN_IN_ALL = (0.7, 3.0)  # with its copper loss, where the current or the resistance is not known
_TELLING = 50.0  # W besides copper loss, below which iron loss and noise are no small part of it
_OF_CURRENT = (0.5, 2.0)  # torque over the torque constant times current: the drive makes one of the other
_OF_VOLTAGE = (0.4, 1.6)  # electrical power over sqrt(3) times voltage and current: at most 1, less by what is reactive
_AT_LIMIT = 0.55  # of the drive's limit of current, as RMS of a window, from which it may have been reached for a good part of that
_COPPER = (0.9, 1.6)  # what 3 R I^2 is at least and at most, R at 20 degC: tolerance, and a hot winding


@dataclass(frozen=True)
class _Taken:
    """Means while the motor drives: electrical power, T w as read, copper loss at 20 degC (0: not known)."""

    power: float
    shaft: float
    copper: float

    def fits(self, of_speed: float, of_power: float) -> bool:
        """Whether the power is what a motor takes, with speed and power in units by which a number is so many times too large."""
        shaft, power = self.shaft / of_speed, self.power / of_power
        least, most = _TAKEN if self.copper else _TAKEN_IN_ALL
        return max(_TELLING, least * shaft) < power - _COPPER[1] * self.copper and power - _COPPER[0] * self.copper < most * shaft


def judge_drive(state: np.ndarray, scales: UnitScales | None, standing: Sequence[UnitSuspicion] = ()) -> list[UnitSuspicion]:
    """Verdict from a window of evidence, float64[4, 4]: speed against its command, power against torque times speed, torque against
    current, power against voltage times current. Where nothing was commanded or the drive was at its limit, its speed tells nothing."""
    follow = state[0, RULE_A] / state[0, RULE_B] if state[0, RULE_B] and not _held_back(state[0], scales) else np.nan
    for unit in _SPEEDS:
        for field, expected in ((_SPEED, unit.factor), (_SPEED_COMMAND, 1.0 / unit.factor)):
            if _near(follow, expected, _FOLLOWS):
                return [UnitSuspicion((field,), (unit,), f"speed is {follow:.3g} times speed_command")]
    still = [one for one in standing if one.fields not in ((_SPEED,), (_SPEED_COMMAND,)) or np.isnan(follow)]
    torque = _share(state[2], scales.torque_constant) if scales is not None else np.nan
    apparent = _share(state[3], math.sqrt(3.0))
    if _odd(torque, _OF_CURRENT) and not np.isnan(apparent):
        return _torque_or_current(torque, apparent, scales) or still
    if state[1, RULE_COUNT] < _ENOUGH:
        return still
    power, shaft, square = state[1, [RULE_A, RULE_B, RULE_C]] / state[1, RULE_COUNT]
    taken = _Taken(power, shaft, 3.0 * scales.phase_resistance * square if scales is not None else 0.0)
    if _odd(apparent, _OF_VOLTAGE):
        return _power_or_voltage(apparent, taken) or still
    if taken.fits(1.0, 1.0):
        return []
    share = f"electrical power is {power / shaft:.2g} times torque times speed while the motor drives"
    if taken.fits(1.0, _KW.factor):
        return [UnitSuspicion((_POWER,), (_KW,), share)]
    for unit in _SPEEDS:
        told = taken.copper > 0.0 or unit.factor > 1.0  # a motor that stalls gives as little for what it takes
        if told and _near(follow, 1.0, _ROUGHLY) and taken.fits(unit.factor, 1.0):
            if np.isnan(apparent):
                return still or [UnitSuspicion((), (), f"{share}; without voltage and current it cannot be told which of them is wrong")]
            return [UnitSuspicion((_SPEED_COMMAND, _SPEED), (unit,), share)]
    return still


def _torque_or_current(torque: float, apparent: float, scales: UnitScales) -> list[UnitSuspicion]:
    """Which of the two is wrong that are so many times as much as they are of each other; `apparent`: power over that of voltage."""
    if not _odd(apparent, _OF_VOLTAGE):
        percent = UnitMistake("% of rated torque", 100.0 / scales.rated_torque)
        return [_wrong(_TORQUE, torque, "the torque constant times current, with which voltage and electrical power agree", percent)]
    if torque > 0.0 and _OF_VOLTAGE[0] < apparent / torque < _OF_VOLTAGE[1]:
        return [_wrong(_CURRENT, 1.0 / torque, "torque over the torque constant, with which voltage and electrical power agree")]
    return []


def _power_or_voltage(apparent: float, taken: _Taken) -> list[UnitSuspicion]:
    """Which of the two is wrong where power is so many times sqrt(3) times voltage times current, which is what makes the torque."""
    if apparent == 0.0:
        of = f"sqrt(3) times voltage times current, while torque times speed is {taken.shaft:.3g} W"
        return [_wrong(_POWER, 0.0, of)] if taken.shaft > _TELLING else []
    if taken.fits(1.0, 1.0):
        return [_wrong(_VOLTAGE, 1.0 / apparent, "electrical power over sqrt(3) times current, with which torque times speed agrees")]
    if taken.fits(1.0, apparent):
        return [_wrong(_POWER, apparent, "sqrt(3) times voltage times current, with which torque times speed agrees")]
    return []


def _wrong(field: int, share: float, of: str, *more: UnitMistake) -> UnitSuspicion:
    units = tuple(unit for unit in (*more, *_NAMED[field]) if _near(share, unit.factor, _AS_MUCH))[:1]
    return UnitSuspicion((field,), units, f"{'it ' if units else ''}is {share:.2g} times {of}")


def _held_back(evidence: np.ndarray, scales: UnitScales | None) -> bool:
    """Whether the drive's limit of current may have kept the shaft from its command, as of a rod that presses against its stop."""
    count = evidence[RULE_COUNT]
    return scales is not None and count > 0.0 and evidence[RULE_C] / count > (_AT_LIMIT * scales.current_limit) ** 2


def _share(evidence: np.ndarray, factor: float) -> float:
    """What was summed over so many times what it is held against, NaN where too little tells."""
    return evidence[RULE_A] / (factor * evidence[RULE_B]) if evidence[RULE_COUNT] >= _ENOUGH else np.nan


def _odd(share: float, sound: tuple[float, float]) -> bool:
    return share < sound[0] or share > sound[1]


def _near(value: float, target: float, tolerance: float) -> bool:
    return abs(value - target) < tolerance * target
