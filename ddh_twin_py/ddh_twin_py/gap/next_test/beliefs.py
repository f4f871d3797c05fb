"""The hypotheses that a search has left, as what each says of any further test."""

from __future__ import annotations

import itertools

import numpy as np

from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.next_test.separating import Believed

WORTH = 0.02
"""Probability from which a set is worth a test."""
MOST = 4
"""Sets among which a test decides."""


def beliefs(found: Found) -> list[tuple[Believed, float]]:
    """The leading sets with their probabilities, most probable first; at most `MOST`, each of at least `WORTH`."""
    leading = [(ids, p) for ids, p in found.probability.items() if p >= WORTH][:MOST]
    return [(belief_in(found, ids), p) for ids, p in leading]


def belief_in(found: Found, ids: tuple[str, ...]) -> Believed:
    """One set as the search left it."""
    fitted = found.fitted.get(ids)
    if fitted is None:
        return _by_the_linear_model(found.linearised, ids)
    left = [c.residual(p) for c, p in zip(found.linearised.comparisons, fitted.predictions, strict=True)]
    return Believed(ids, fitted.theta, fitted.ways, fitted.x, fitted.covariance, found.linearised.basis.slack(left))


def _by_the_linear_model(linearised: Linearised, ids: tuple[str, ...]) -> Believed:
    """A set that was not fitted in full, by the best ways of its effects."""
    ways = [[i for i, c in enumerate(linearised.columns) if c.effect.id == name] for name in ids]
    best = max((linearised.evidence.of(sorted(chosen)) for chosen in itertools.product(*ways)), key=lambda h: h.log_evidence)
    columns = tuple(linearised.columns[i] for i in best.columns)
    scale = np.array([c.x for c in columns])
    rows = [own[:, list(best.columns)] for own in linearised.of_columns()]
    shared = linearised.basis.shared(rows, linearised.values(), best.departure)
    k = linearised.theta.size
    covariance = np.diag((best.spread * scale) ** 2)
    return Believed(ids, linearised.model.within(shared[:k]), columns, best.departure * scale, covariance, shared[k:])
