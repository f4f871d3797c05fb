"""Evidence, over a window of samples, that a field is given in another unit than agreed.

A wrong unit often stays within the plausible range (5 bar read as 5 Pa), so that no single
sample can tell. Relations between the fields of one topic can: a loaded rod does not move at
0.01 bar, measured speed follows commanded speed, a motor that drives takes more electrical
power than it gives to the shaft.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.telemetry.screening_kernel import RATIO, RULE_A, RULE_B, RULE_COUNT, SMALL
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC

RPM = 30.0 / math.pi
EVIDENCE = 200  # samples of the first rule's condition that make a window
_SILENT = 0.5  # of its noise, below which the largest of so many samples of a pressure cannot stay
_NO_LOAD = 3.0e4  # Pa, below which in both chambers no rod moves against its friction
_MOST_BAR = 1000.0  # number above which a pressure is not in bar
_IN_KW = (5e-4, 3e-3)  # electrical power over shaft power where it is in kW
_LIKELY = 0.15  # relative; how near a ratio must be to a known factor


@dataclass(frozen=True)
class UnitRule:
    """One relation: `kind`, columns a, b, c (-1: none) and the floor of its condition."""

    kind: int
    a: int
    b: int
    c: int
    floor: float


@dataclass(frozen=True)
class UnitSuspicion:
    """Verdict: `fields` (columns) look as if given in `unit`; `factor` times too large."""

    fields: tuple[int, ...]
    unit: str
    factor: float
    reason: str


# speed, speed_command, torque and power: columns of DRIVE_FIELDS
_DRIVE_RULES = (
    UnitRule(RATIO, 1, 0, -1, 5.0),  # |speed| against |speed_command| above 5 rad/s
    UnitRule(RATIO, 5, 2, 1, 100.0),  # electrical power against shaft power above 100 W
)
# each pressure while |rod_velocity| is above 5 mm/s: columns of HYDRAULIC_FIELDS
_HYDRAULIC_RULES = (UnitRule(SMALL, 0, -1, 3, 0.005), UnitRule(SMALL, 1, -1, 3, 0.005))
_PRESSURES = ("pressure_piston_side", "pressure_rod_side")


def rules_of(topic: str) -> tuple[UnitRule, ...]:
    """Unit rules of a relative topic."""
    return {DRIVE_TOPIC: _DRIVE_RULES, HYDRAULIC_TOPIC: _HYDRAULIC_RULES}.get(topic, ())


def judge(topic: str, state: np.ndarray, noise: np.ndarray) -> list[UnitSuspicion]:
    """Verdict from a window of evidence, float64[r, 3], of the topic's rules.

    `noise` float64[m]: standard deviation of one sample of each field, 0 where unknown.
    """
    return _judge_pressures(state, noise) if topic == HYDRAULIC_TOPIC else _judge_drive(state)


def _judge_pressures(state: np.ndarray, noise: np.ndarray) -> list[UnitSuspicion]:
    """A pressure in bar stays below the sensor's own noise in Pa, and both far below any load, also those in kPa."""
    seen = state[:, RULE_COUNT] >= EVIDENCE // 2
    largest = state[:, RULE_A]
    silent = seen & (largest > 1e-3) & (largest < _SILENT * noise[:2])
    if (seen & (largest > 1e-3) & (largest < _NO_LOAD)).all():
        silent[:] = True
    fields = tuple(int(j) for j in np.flatnonzero(silent))
    if not fields:
        return []
    names = " and ".join(_PRESSURES[j] for j in fields)
    verb = "stay" if len(fields) > 1 else "stays"
    unit, factor = ("bar", 1e-5) if largest[silent].max() < _MOST_BAR else ("kPa", 1e-3)
    return [UnitSuspicion(fields, unit, factor, f"{names} {verb} below {largest[silent].max():.4g} while the rod moves")]


def _judge_drive(state: np.ndarray) -> list[UnitSuspicion]:
    follow = state[0, RULE_A] / state[0, RULE_B] if state[0, RULE_B] else np.nan  # nothing was commanded
    if _near(follow, RPM):
        return [UnitSuspicion((1,), "rpm", RPM, f"speed is {follow:.3g} times speed_command")]
    if _near(follow, 1.0 / RPM):
        return [UnitSuspicion((0,), "rpm", RPM, f"speed is {follow:.3g} times speed_command")]
    if state[1, RULE_COUNT] >= EVIDENCE // 4:
        share = state[1, RULE_A] / state[1, RULE_B]
        if _IN_KW[0] < share < _IN_KW[1]:
            return [UnitSuspicion((5,), "kW", 1e-3, f"it is {share:.2g} times torque times speed while the motor drives")]
        if 0.05 < share < 0.3 and _near(follow, 1.0, 0.5):
            reason = f"electrical power is {share:.2g} times torque times speed while the motor drives"
            return [UnitSuspicion((0, 1), "rpm", RPM, reason)]
    return []


def _near(value: float, target: float, tolerance: float = _LIKELY) -> bool:
    return abs(value - target) < tolerance * target
