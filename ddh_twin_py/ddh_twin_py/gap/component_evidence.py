"""Which component explains best what is left, whatever its law: its effects' ways, free in sign and in how they depend on the cycle.

A cause that no catalogue lists still acts somewhere, and what acts in a component moves the signals as other effects of
that component do: it makes the same heat, takes the same flow, needs the same torque. So each component may combine its
effects' columns freely, each grown or shrunk in lifting, lowering and rest and with the oil's warmth, and the component
whose combinations gain most log evidence is the place.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.linear_gaussian import gain
from ddh_twin_py.gap.hypotheses import WIDTH
from ddh_twin_py.gap.lacking import PHASES
from ddh_twin_py.gap.linearised import Linearised
from ddh_twin_py.gap.refit import Refitted

_SLACK = 0.15  # of the laws, as in `leftover`


def component_evidence(linearised: Linearised, fitted: Refitted) -> list[tuple[str, str, float]]:
    """Component, domain of its strongest effect, and log evidence gained by its free combinations, best first.

    Sensors are places of their own: each of their effects stands alone.

    Args:
        fitted: the hypothesis beside which something is left, at its optimum.
    """
    comparisons = linearised.comparisons
    values = [c.residual(p) + j @ fitted.theta for c, p, j in zip(comparisons, fitted.predictions, linearised.sensitivities, strict=True)]
    groups: dict[tuple[str, str], list[int]] = {}
    for i, column in enumerate(linearised.columns):
        own = column.effect.id if column.effect.component == "sensor" else ""
        groups.setdefault((column.effect.component, own), []).append(i)
    columns: list[list[np.ndarray]] = [[] for _ in comparisons]
    owner: list[tuple[tuple[str, str], int]] = []
    for group, members in groups.items():
        for i in _different(linearised, members):
            for rows, comparison, change in zip(columns, comparisons, linearised.columns[i].change, strict=True):
                rows.append(_modulated(comparison, change))
            owner += [(group, i)] * (len(PHASES[:3]) + 1)
    if not owner:
        return []
    basis = linearised.basis.otherwise(1.0, _SLACK / linearised.slack)
    sums = basis.sums([np.hstack(rows) for rows in columns], values)
    out = []
    for group in groups:
        index = np.array([k for k, (own, _) in enumerate(owner) if own == group and sums.information[k, k] > 1e-9])
        if not index.size:
            continue
        log, estimate, _ = gain(sums.information[np.ix_(index, index)], sums.score[index], np.full(index.size, WIDTH))
        strongest = owner[index[int(np.argmax(np.abs(estimate)))]][1]
        effect = linearised.columns[strongest].effect
        out.append((effect.component, effect.domain, float(log)))
    return sorted(out, key=lambda row: -row[2])


def _different(linearised: Linearised, members: list[int]) -> list[int]:
    """One column for each effect and law; the other direction is the same column with another sign."""
    first: dict[tuple[str, int], int] = {}
    for i in members:
        first.setdefault((linearised.columns[i].effect.id, linearised.columns[i].law), i)
    return list(first.values())


def _modulated(comparison, change: np.ndarray) -> np.ndarray:
    """A column in temperatures alone with lifting, lowering and rest each apart in the fast signals, (rows, 4)."""
    out = np.zeros((change.size, len(PHASES[:3]) + 1))
    for block in comparison.blocks:
        own = change[block.rows]
        if block.signal.startswith("temperature/") or block.signal == "rod_position":
            out[block.rows, -1] = own
            continue
        for k in range(len(PHASES[:3])):
            out[block.rows, k] = own * (block.binning.phase == k)
    return out
