"""Pressures in another unit: too small for a rod that moves, and which of the units in use makes them carry its load."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_twin_py.telemetry.screening_kernel import EVIDENCE, RULE_A, RULE_B, RULE_COUNT
from ddh_twin_py.telemetry.signals import UnitMistake
from ddh_twin_py.telemetry.units.unit_scales import UnitScales
from ddh_twin_py.telemetry.units.unit_suspicion import UnitSuspicion

_UNITS = (UnitMistake("bar", 1e-5), UnitMistake("kPa", 1e-3), UnitMistake("MPa", 1e-6), UnitMistake("psi", 1.0 / 6894.757))
_PRESSURES = ("pressure_piston_side", "pressure_rod_side")
_NO_LOAD = 3.0e4  # Pa, below which in both chambers no rod moves against its friction
_SILENT = 0.5  # of its noise, below which the largest of so many samples of a pressure cannot stay
_AT_WORK, _HIGHEST = 1.0e6, 4.0e7  # Pa, between which the largest pressure of a cylinder at work lies
_SHOWN = 1.0e-3 * 6.0e7  # above this no pressure within a sensor's range is a number of any of these units
_CARRIED = (0.3, 3.0)  # what pressures carry, over the load, with friction
_FRICTION = 1000.0  # N, by which they miss a load that is small


def judge_pressures(
    state: np.ndarray, noise: np.ndarray, largest: np.ndarray, scales: UnitScales | None, standing: Sequence[UnitSuspicion]
) -> list[UnitSuspicion]:
    """Verdict from a window of evidence, float64[2, 4], while the rod moves; `largest` float64[2]: Pa, of all windows so far."""
    count, here = state[:, RULE_COUNT], state[:, RULE_A]
    mean = state[:, RULE_B] / np.maximum(count, 1.0)
    told = (count >= EVIDENCE // 2) & (here > 1e-3)
    at_home = largest >= _SHOWN  # a side that has shown its load may well be without any, where the other carries it
    top = np.where(at_home, here, largest)
    if (told & (here < _NO_LOAD)).all():
        small = [0, 1] if at_home.all() else np.flatnonzero(~at_home)
    elif scales is None:
        small = np.flatnonzero(told & (largest < _SILENT * noise[:2]))
    else:
        small = np.flatnonzero(told & (here < _SHOWN))  # it may have shown its load in another unit before
        if _carries(mean, scales) or not any(_carries(_told_in(unit, mean, small), scales) for unit in _UNITS):
            small = []
    if not len(small):
        return [one for one in standing if (here[list(one.fields)] < _SHOWN).all()]
    names, verb = " and ".join(_PRESSURES[j] for j in small), "stay" if len(small) > 1 else "stays"
    units = _fitting(small, float(top[small].max()), mean, scales)
    return [UnitSuspicion(tuple(int(j) for j in small), units, f"{names} {verb} below {top[small].max():.4g} while the rod moves")]


def _fitting(small: Sequence[int], top: float, mean: np.ndarray, scales: UnitScales | None) -> tuple[UnitMistake, ...]:
    """The units in which the largest number is a pressure of a cylinder at work; the one that carries the load best, where that tells."""
    units = tuple(unit for unit in _UNITS if _AT_WORK <= top / unit.factor <= _HIGHEST)
    units = units or tuple(unit for unit in _UNITS if top / unit.factor <= _HIGHEST) or _UNITS[:1]
    if scales is None or scales.load < _FRICTION:
        return units
    shares = [_carried(_told_in(unit, mean, small), scales) / scales.load for unit in units]
    off = [abs(np.log(share)) if _CARRIED[0] < share < _CARRIED[1] else np.inf for share in shares]
    best = int(np.argmin(off))
    return units if np.isinf(off[best]) else (units[best],)


def _told_in(unit: UnitMistake, mean: np.ndarray, small: Sequence[int]) -> np.ndarray:
    """Pressures, Pa, (2,), of which some were told in a unit."""
    right = mean.copy()
    right[small] /= unit.factor
    return right


def _carries(pressures: np.ndarray, scales: UnitScales) -> bool:
    """Whether pressures, Pa, (2,), carry the load."""
    return _CARRIED[0] * scales.load - _FRICTION < _carried(pressures, scales) < _CARRIED[1] * scales.load + _FRICTION


def _carried(pressures: np.ndarray, scales: UnitScales) -> float:
    """N, against extension."""
    return float(scales.force(pressures[0], pressures[1]))
