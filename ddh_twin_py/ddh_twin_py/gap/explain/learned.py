"""What no listed effect explains, as terms of the model: fitted where it lies, marked as learned, believed by held-out data alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.evidence.hypotheses import WIDTH
from ddh_twin_py.gap.evidence.sensitivity import Column, columns_of, stacked
from ddh_twin_py.gap.explain.refit import Refit, Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.explain.side_by_side import THREADS
from ddh_twin_py.gap.model import Model
from ddh_twin_py.rig.reader_units import plus_minus

PREFIX = "learned."
"""Begins the ids of terms that are learned."""
_ALIKE = 2.0  # log evidence by which a later term must lead
_CLOSES = 0.9  # of the gap of held-out data: what leaves more is not worth a term


def learn(model: Model, found: Found, terms: Sequence[Effect], gap: Callable[[Refitted], float], before: float) -> Refitted | None:
    """Fit terms to the recordings in which effects act.

    Args:
        found: of the case, no effect fitted among them. terms: what may be learned at the place in question, the plainest first.
        gap: of held-out data under a fit. before: the same as the rig was built.

    Returns:
        One term or all at their optimum; None where they move nothing or do not shrink the gap of held-out data by a tenth.
    """
    own, none = found.linearised, found.fitted[()]
    with ThreadPoolExecutor(max_workers=THREADS) as pool:
        chosen = _signed(own, columns_of(terms, model, own.theta, own.comparisons, pool))
        refit = Refit(own, own.basis.otherwise(1.0, 1.0))
        sets = [*([way] for way in chosen), *([chosen] if len(chosen) > 1 else [])]
        fits = list(pool.map(lambda ways: refit.of([c for c, _ in ways], none.theta, np.array([d for _, d in ways])), sets))
    most = max((fitted.log_evidence for fitted in fits), default=-np.inf)
    best = next((fitted for fitted in fits if fitted.log_evidence > most - _ALIKE), None)
    return best if best is not None and gap(best) < _CLOSES * min(before, gap(none)) else None


def described(fitted: Refitted, before: float, after: float) -> str:
    """What was learned and what it closes, in one sentence."""
    std = np.sqrt(np.maximum(np.diagonal(fitted.covariance), 0.0))
    named = ", ".join(f"{c.effect.id} {plus_minus(float(x), float(s), c.effect.unit, sign=True)}"
                      for c, x, s in zip(fitted.columns, fitted.x, std, strict=True))
    return (f"a learned term ({named}) takes the gap of held-out data, which decided that it is kept, from {before:.2f} to {after:.2f} "
            "times the floor; it describes and does not explain")


def _signed(linearised, columns: Sequence[Column]) -> list[tuple[Column, float]]:
    """Of each term the way, and the departure in multiples of it, that all terms together ask for."""
    both = {(c.effect.id, np.sign(c.x)): c for c in columns}
    forward = [both.get((name, 1.0)) or both[(name, -1.0)] for name in dict.fromkeys(c.effect.id for c in columns)]
    if not forward:
        return []
    changes = stacked(forward, linearised.comparisons)
    sums = linearised.basis.sums(changes, linearised.values())
    estimate = np.linalg.solve(sums.information + np.eye(len(forward)) / WIDTH**2, sums.score)
    chosen = []
    for column, departure in zip(forward, estimate, strict=True):
        opposite = both.get((column.effect.id, -np.sign(column.x)))
        if departure >= 0.0:
            chosen.append((column, float(departure)))
        elif opposite is not None:
            chosen.append((opposite, float(-departure * column.x / -opposite.x)))
    return chosen
