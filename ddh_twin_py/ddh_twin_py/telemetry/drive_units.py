"""In which unit a drive tells its speeds and its power: the one of those in use in which they agree with each other.

With the shaft's power T w, the electrical power P and the copper loss 3 R I^2 of a motor that drives, (P - 3 R I^2) / (T w) is 1 and some
iron loss, however slowly it turns; in another unit of speed it is as many times as much as that unit is larger.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.telemetry.screening_kernel import EVIDENCE, RULE_A, RULE_B, RULE_C, RULE_COUNT
from ddh_twin_py.telemetry.signals import UnitMistake
from ddh_twin_py.telemetry.unit_scales import UnitScales
from ddh_twin_py.telemetry.unit_suspicion import UnitSuspicion

_SPEED_COMMAND, _SPEED, _POWER = 0, 1, 5  # columns of DRIVE_FIELDS
_SPEEDS = (
    UnitMistake("rpm", 30.0 / math.pi),
    UnitMistake("rev/s", 0.5 / math.pi),
    UnitMistake("deg/s", 180.0 / math.pi),
)
_KW = UnitMistake("kW", 1e-3)
_FOLLOWS, _ROUGHLY = 0.15, 0.5  # relative; how near speed must be to its command where one of both is in another unit, and where both are
_TAKEN = (0.7, 2.2)  # what a motor takes for what it gives, copper loss aside
_TAKEN_IN_ALL = (0.7, 3.0)  # with its copper loss, where the current or the resistance is not known
_TELLING = 50.0  # W besides copper loss, below which iron loss and noise are no small part of it
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
    """Verdict from a window of evidence, float64[2, 4]: speed against its command, power against torque times speed."""
    follow = state[0, RULE_A] / state[0, RULE_B] if state[0, RULE_B] else np.nan  # nothing was commanded
    for unit in _SPEEDS:
        for field, expected in ((_SPEED, unit.factor), (_SPEED_COMMAND, 1.0 / unit.factor)):
            if _near(follow, expected, _FOLLOWS):
                return [UnitSuspicion((field,), (unit,), f"speed is {follow:.3g} times speed_command")]
    still = [one for one in standing if one.fields not in ((_SPEED,), (_SPEED_COMMAND,)) or np.isnan(follow)]
    if state[1, RULE_COUNT] < EVIDENCE // 4:
        return still
    power, shaft, square = state[1, [RULE_A, RULE_B, RULE_C]] / state[1, RULE_COUNT]
    taken = _Taken(power, shaft, 3.0 * scales.phase_resistance * square if scales is not None else 0.0)
    share = f"electrical power is {power / shaft:.2g} times torque times speed while the motor drives"
    if taken.fits(1.0, 1.0):
        return []
    if taken.fits(1.0, _KW.factor):
        return [UnitSuspicion((_POWER,), (_KW,), share)]
    for unit in _SPEEDS:
        told = taken.copper > 0.0 or unit.factor > 1.0  # a motor that stalls gives as little for what it takes
        if told and _near(follow, 1.0, _ROUGHLY) and taken.fits(unit.factor, 1.0):
            return [UnitSuspicion((_SPEED_COMMAND, _SPEED), (unit,), share)]
    return still


def _near(value: float, target: float, tolerance: float) -> bool:
    return abs(value - target) < tolerance * target
