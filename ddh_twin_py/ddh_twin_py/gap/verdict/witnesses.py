"""Which signals tell of an effect, and how much of it each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import stacked
from ddh_twin_py.gap.explain.refit import Refitted


def witnesses(linearised: Linearised, fitted: Refitted) -> list[dict[str, float]]:
    """Share of what each effect tells, rig's parameters refitted, by the signal that tells it; by effect, signal to share."""
    numbers = columns_of_effects(linearised, fitted)
    own, lengths = [linearised.columns[i] for i in numbers], lengths_of(linearised, fitted, numbers)
    columns = [rows * lengths for rows in stacked(own, linearised.comparisons)]
    told: list[dict[str, float]] = [{} for _ in numbers]
    for comparison, rows in zip(linearised.comparisons, linearised.basis.beyond(columns), strict=True):
        for block in comparison.blocks:
            for shares, amount in zip(told, np.sum(rows[block.rows], axis=0), strict=True):
                shares[block.signal] = shares.get(block.signal, 0.0) + max(0.0, float(amount))
    return [{name: amount / (sum(shares.values()) or 1.0) for name, amount in shares.items()} for shares in told]


def columns_of_effects(linearised: Linearised, fitted: Refitted) -> list[int]:
    """Of a hypothesis' effects, each the way it acts, among the columns."""
    ways = [column.way for column in linearised.columns]
    return [ways.index(column.way) for column in fitted.columns]


def lengths_of(linearised: Linearised, fitted: Refitted, numbers: Sequence[int]) -> np.ndarray:
    """Departures in multiples of those columns, (m,)."""
    return fitted.x / np.array([linearised.columns[i].x for i in numbers])
