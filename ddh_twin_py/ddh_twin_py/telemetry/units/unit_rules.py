"""Evidence, over a window of samples, that a field is given in another unit than agreed.

A wrong unit often stays within the plausible range (5 bar read as 5 Pa), so that no single
sample can tell. Relations between the fields of one topic can: a loaded rod does not move at
0.01 bar, measured speed follows commanded speed, a motor that drives takes the electrical
power that it gives to the shaft and what its copper loses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.telemetry.screening_kernel import RATIO, SMALL
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC
from ddh_twin_py.telemetry.units.drive_units import judge_drive
from ddh_twin_py.telemetry.units.pressure_units import judge_pressures
from ddh_twin_py.telemetry.units.unit_scales import UnitScales
from ddh_twin_py.telemetry.units.unit_suspicion import UnitSuspicion


@dataclass(frozen=True)
class UnitRule:
    """One relation: `kind`, columns a, b, c, d (-1: none), the floor of its condition, whether what meets that makes a window."""

    kind: int
    a: int
    b: int
    c: int
    d: int
    floor: float
    window: bool = True


# speed_command, speed, torque, current, voltage and power: columns of DRIVE_FIELDS
_DRIVE_RULES = (
    UnitRule(RATIO, 1, 0, -1, 3, 0.5),  # |speed| against |speed_command| above 0.5, and squared current
    UnitRule(RATIO, 5, 2, 1, 3, 10.0),  # electrical power and squared current against shaft power above 10
    UnitRule(RATIO, 2, 3, -1, -1, 0.5, window=False),  # |torque| against |current| above 0.5
    UnitRule(RATIO, 5, 4, 3, -1, 5.0, window=False),  # electrical power against voltage times current above 5
)
# each pressure while |rod_velocity| is above 5 mm/s: columns of HYDRAULIC_FIELDS
_HYDRAULIC_RULES = (UnitRule(SMALL, 0, -1, 3, -1, 0.005), UnitRule(SMALL, 1, -1, 3, -1, 0.005))


def rules_of(topic: str) -> tuple[UnitRule, ...]:
    """Unit rules of a relative topic."""
    return {DRIVE_TOPIC: _DRIVE_RULES, HYDRAULIC_TOPIC: _HYDRAULIC_RULES}.get(topic, ())


def judge(
    topic: str,
    state: np.ndarray,
    noise: np.ndarray,
    largest: np.ndarray,
    scales: UnitScales | None = None,
    standing: Sequence[UnitSuspicion] = (),
) -> list[UnitSuspicion]:
    """Verdict from a window of evidence, float64[r, 4], of the topic's rules.

    `noise` float64[m]: standard deviation of one sample of each field, 0 where unknown; `largest` float64[r]: of all windows so far,
    where a rule keeps one; `standing`: suspicions that are believed, which a window that says nothing does not end.
    """
    if topic == HYDRAULIC_TOPIC:
        return judge_pressures(state, noise, largest, scales, standing)
    return judge_drive(state, scales, standing)
