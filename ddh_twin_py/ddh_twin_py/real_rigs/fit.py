"""Parameters of a described rig fitted to its recordings, no effect acting beside those that are built in."""

from __future__ import annotations

import numpy as np
from scipy import optimize

from ddh_twin_py.estimation.comparison import Comparison, Discrepancy
from ddh_twin_py.real_rigs.rig_model import RigModel

STARTS = 6
"""Places from which a fit begins: laws that bend have more than one minimum."""
_DIFFERENCE = 1.0e-3  # relative to a deviation
_SETTLED = 1.0e-6


def least_squares(model: RigModel, near: np.ndarray | None = None, starts: int = STARTS) -> np.ndarray:
    """Deviations (k,) of the least squares of all rows and the priors: trust-region steps from several places, the lowest cost counts.

    Args:
        near: a further place to begin at, (k,). starts: places besides: the priors' means, and draws of half their width.
    """
    plain = model.run(np.zeros(model.size))
    comparisons = [Comparison(signals, run, Discrepancy()) for signals, run in zip(model.signals, plain, strict=True)]

    def residual(theta: np.ndarray) -> np.ndarray:
        return np.concatenate([*(c.residual(p) for c, p in zip(comparisons, model.run(theta), strict=True)), theta])

    lowest, highest = model.within(np.full(model.size, -np.inf)), model.within(np.full(model.size, np.inf))
    inside = np.minimum(0.02, 0.1 * (highest - lowest))
    draws = np.random.default_rng(0).normal(0.0, 0.5, (starts, model.size))
    draws[:1] = 0.0
    places = [*draws] if near is None else [near, *draws]
    fits = [optimize.least_squares(residual, np.clip(x, lowest + inside, highest - inside), bounds=(lowest, highest),
                                   diff_step=_DIFFERENCE, ftol=_SETTLED, xtol=_SETTLED, gtol=_SETTLED) for x in places]
    return min(fits, key=lambda found: found.cost).x
