"""What the twin lacks at a component: power, flow, torque, force or heat, by phase and by regime."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ddh_twin_py.estimation.fitting.binning import PHASES
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.findings import Lack

_REGIMES = 3  # parts of equal count along a variable
_NOTHING = 1.0e-6  # of the largest value, below which a mean is rounding


@dataclass(frozen=True)
class Course:
    """What an effect adds at its place over a run.

    Attributes:
        value: (n,) in ``unit``. phase: index into `PHASES`, (n,).
        regimes: variable and its unit to values, (n,). signals: readings that err by it, where it lies in readings.
    """

    value: np.ndarray
    unit: str
    phase: np.ndarray
    regimes: Mapping[tuple[str, str], np.ndarray]
    signals: tuple[str, ...] = ()


@dataclass(frozen=True)
class ActingEffect:
    """An effect as it acts: what it adds, how surely, where its chi-square lies.

    Attributes:
        share: of the explained chi-square. by_phase: phase or ``all`` to the part of it, summing to 1.
        relative: standard deviation of the departure over the departure.
    """

    effect: Effect
    course: Course
    share: float
    by_phase: Mapping[str, float]
    relative: float


def lacks(acting: Sequence[ActingEffect]) -> list[Lack]:
    """Rows by place and phase, largest share first; then rows by regime, which carry no share of their own."""
    rows, regimes = [], []
    for one in acting:
        for phase, part in one.by_phase.items():
            at = np.ones(one.course.value.size, dtype=bool) if phase == "all" else one.course.phase == PHASES.index(phase)
            rows.append(_row(one, phase, "", at, one.share * part))
        for (name, unit), values in one.course.regimes.items():
            lowest, *higher = np.quantile(values, np.linspace(0.0, 1.0, _REGIMES + 1))
            edges = {f"{edge:.4g}": edge for edge in (lowest, *higher, lowest)}  # alike the last counts, at the start the first
            if len(edges) < _REGIMES:  # they do not read as two parts at least
                continue
            for (low, begin), (high, end) in pairwise(edges.items()):
                at = (values >= begin) & (values <= end)
                regimes.append(_row(one, "all", f"{name} {low} to {high} {unit}", at, 0.0))
    return sorted(rows, key=lambda row: -row.share) + regimes


def _row(one: ActingEffect, phase: str, regime: str, at: np.ndarray, share: float) -> Lack:
    value = float(one.course.value[at].mean()) if at.any() else 0.0
    if abs(value) < _NOTHING * np.abs(one.course.value).max(initial=0.0):
        value = 0.0
    return Lack(one.effect.component, one.effect.domain, phase, regime, value, abs(value) * one.relative, one.course.unit, share,
                one.course.signals)


def chi_square_by_phase(change: Sequence[np.ndarray], comparisons: Sequence, phases: Sequence[str] = PHASES) -> dict[str, float]:
    """Parts of an effect's chi-square by phase, summing to 1; what has no phase is ``all``.

    Args:
        change: what the effect adds to the features, by recording, (rows,).
    """
    total: dict[str, float] = {}
    for own, comparison in zip(change, comparisons, strict=True):
        for block in comparison.blocks:
            square = own[block.rows] ** 2
            for index in np.unique(block.binning.phase):
                name = "all" if index < 0 else phases[index]
                total[name] = total.get(name, 0.0) + float(square[block.binning.phase == index].sum())
    whole = sum(total.values()) or 1.0
    return {name: value / whole for name, value in sorted(total.items(), key=lambda item: -item[1])}
