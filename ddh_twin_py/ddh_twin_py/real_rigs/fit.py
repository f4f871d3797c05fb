"""Parameters of a described rig fitted to its recordings, no effect acting beside those that are built in."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from scipy import optimize

from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.refit import Refit, Refitted
from ddh_twin_py.real_rigs.rig_model import RigModel

STARTS = 6
"""Places from which least squares begin: laws that bend have more than one minimum."""
_PLACES = 12  # from which a fit is linearised again
_SETTLED = 0.02  # of chi-square that a further place must gain, per chi-square at least 1e-5
_DIFFERENCE = 1.0e-3  # relative to a deviation
_CONVERGED = 1.0e-6


def fit(model: RigModel, pool: ThreadPoolExecutor, theta: np.ndarray | None = None, discrepancy: Discrepancy | None = None) -> Refitted:
    """The model's parameters where recordings, priors and what the engine forgives a model put them, by the engine's own steps.

    Args:
        theta: where to begin, deviations, (k,). discrepancy: what the model is forgiven.
    """
    theta = np.zeros(model.size) if theta is None else theta
    fitted, best = None, np.inf
    for _ in range(_PLACES):
        place = linearise(Question(model, (), discrepancy or Discrepancy()), theta, pool)
        here = Refit(place).of([], place.shared(None), np.zeros(0))
        cost = here.chi_square + float(here.theta @ here.theta)
        if fitted is not None and not cost < best - max(_SETTLED, 1e-5 * best):
            return here if cost < best else fitted
        fitted, best, theta = here, cost, here.theta
    return fitted


def by_steps(model: RigModel) -> np.ndarray:
    """Deviations (k,) of `fit` from the priors' means."""
    with ThreadPoolExecutor(max_workers=2) as pool:
        return fit(model, pool).theta


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
                                   diff_step=_DIFFERENCE, ftol=_CONVERGED, xtol=_CONVERGED, gtol=_CONVERGED) for x in places]
    return min(fits, key=lambda found: found.cost).x
