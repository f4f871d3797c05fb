"""Which signals tell of an effect, and how much of it each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.refit import Refitted


def witnesses(linearised: Linearised, fitted: Refitted) -> list[dict[str, float]]:
    """Share of what each effect tells, rig's parameters refitted, by the signal that tells it; by effect, signal to share."""
    places = places_of(linearised, fitted)
    own, lengths = [linearised.columns[i] for i in places], lengths_of(linearised, fitted, places)
    columns = [np.column_stack([c.change[number] for c in own]) * lengths for number in range(len(linearised.comparisons))]
    told: list[dict[str, float]] = [{} for _ in places]
    for comparison, rows in zip(linearised.comparisons, linearised.basis.beyond(columns), strict=True):
        for block in comparison.blocks:
            for shares, amount in zip(told, np.sum(rows[block.rows], axis=0), strict=True):
                shares[block.signal] = shares.get(block.signal, 0.0) + max(0.0, float(amount))
    return [{name: amount / (sum(shares.values()) or 1.0) for name, amount in shares.items()} for shares in told]


def places_of(linearised: Linearised, fitted: Refitted) -> list[int]:
    """Of a hypothesis' effects, each the way it acts, among the columns."""
    ways = [(column.effect.id, column.law, column.x > 0.0) for column in linearised.columns]
    return [ways.index((column.effect.id, column.law, column.x > 0.0)) for column in fitted.columns]


def lengths_of(linearised: Linearised, fitted: Refitted, places: Sequence[int]) -> np.ndarray:
    """Departures in multiples of those columns, (m,)."""
    return fitted.x / np.array([linearised.columns[i].x for i in places])
