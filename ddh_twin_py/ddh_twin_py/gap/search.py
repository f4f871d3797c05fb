"""From a place to the hypotheses that the recordings speak for: linearise, weigh, fit the leaders in full, again from there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from ddh_twin_py.estimation.comparison import Discrepancy
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.hypotheses import SLACK, probabilities, weighted
from ddh_twin_py.gap.linearised import Linearised, linearise
from ddh_twin_py.gap.model import Model
from ddh_twin_py.gap.refit import Refit, Refitted
from ddh_twin_py.gap.sensitivity import Column

_PASSES = 2
_PASSES_FROM_SHEET = 3  # where the rig is known by its sheet alone
_POOR = 1.5  # chi-square per row above which the leading hypothesis explains too little to be the last word
_LEADERS = 5  # sets fitted in full
_FAR_BEHIND = 12.0  # log weight behind the best beyond which a set is not fitted in full
_CLOSE = 3.0  # difference of log evidence between linear and full that needs no further pass


@dataclass(frozen=True)
class Found:
    """What a search found.

    Attributes:
        linearised: sensitivities about the leading hypothesis' parameters.
        probability: sets of effects, most probable first; () is none.
        fitted: the leaders and () fitted in full.
    """

    linearised: Linearised
    probability: dict[tuple[str, ...], float]
    fitted: dict[tuple[str, ...], Refitted]

    @property
    def leader(self) -> tuple[str, ...]:
        """The most probable set."""
        return next(iter(self.probability))


def search(model: Model, effects: Sequence[Effect], theta: np.ndarray, discrepancy: Discrepancy, power: float,
           pool: ThreadPoolExecutor, progress: Callable[[float], None] | None = None) -> Found:
    """Search from parameters ``theta`` (k,), in deviations.

    Args:
        effects: that may act. discrepancy: what the model is forgiven. power: see `hypotheses.POWER`.
        progress: told the share done.
    """
    linearised = None
    passes, fewest = (_PASSES_FROM_SHEET, 2) if all(model.altered) else (_PASSES, 1)
    for number in range(passes):
        told = (lambda share, n=number: progress((n + 0.8 * share) / passes)) if progress else None
        linearised = linearise(model, effects, theta, discrepancy, SLACK, power, pool, told, linearised)
        weights = _weights(linearised)
        linearised = linearised.with_scatter(max(weights.values(), key=lambda w: w[0])[1])
        weights = _weights(linearised)
        fitted = _fit_leaders(linearised, weights, pool)
        if poor := _poor(linearised, fitted):
            fitted = _fit_every_effect(linearised, weights, fitted, pool)
        found = Found(linearised, _probability(weights, fitted), fitted)
        leader = found.leader if found.leader in fitted else ()
        if number + 1 >= fewest and not poor and abs(_gain(fitted, leader) - _linear(weights, leader)) < _CLOSE:
            break
        theta, discrepancy = fitted[leader].theta, linearised.discrepancy
    if progress:
        progress(1.0)
    return found


def _weights(linearised: Linearised) -> dict:
    evidence = linearised.evidence
    singles = evidence.singles()
    return weighted(singles + evidence.pairs(singles), linearised.columns, linearised.effects)


def _fit_leaders(linearised: Linearised, weights: dict, pool: ThreadPoolExecutor) -> dict[tuple[str, ...], Refitted]:
    best = max(w[0] for w in weights.values())
    ranked = sorted((ids for ids in weights if ids and best - weights[ids][0] < _FAR_BEHIND), key=lambda ids: -weights[ids][0])
    single = max((ids for ids in weights if len(ids) == 1), key=lambda ids: weights[ids][0], default=())
    wanted = dict.fromkeys([(), *ranked[:_LEADERS], single])
    refit = _refit(linearised)

    def fit(ids: tuple[str, ...]) -> Refitted:
        hypothesis = weights[ids][1]
        columns = [linearised.columns[i] for i in hypothesis.columns] if hypothesis else []
        departure = hypothesis.departure if hypothesis else np.zeros(0)
        return refit.of(columns, linearised.shared(hypothesis), departure)

    fitted = dict(zip(wanted, pool.map(fit, wanted), strict=True))
    best = max(fitted.values(), key=lambda f: f.log_evidence)
    if best.columns:  # no effect may do better from where an effect led the parameters
        again = refit.of([], best.theta, np.zeros(0))
        fitted[()] = max(fitted[()], again, key=lambda f: f.log_evidence)
    return fitted


def _refit(linearised: Linearised) -> Refit:
    return Refit(linearised.model, linearised.comparisons, linearised.basis, linearised.sensitivities, linearised.theta)


def _poor(linearised: Linearised, fitted: dict[tuple[str, ...], Refitted]) -> bool:
    rows = sum(c.size for c in linearised.comparisons)
    best = max(fitted.values(), key=lambda f: f.log_evidence)
    return best.chi_square > _POOR * linearised.power * rows


def _fit_every_effect(linearised: Linearised, weights: dict, fitted: dict[tuple[str, ...], Refitted],
                      pool: ThreadPoolExecutor) -> dict[tuple[str, ...], Refitted]:
    """The same with every effect fitted in full, in each of its ways: a large one bends, and no line shows where it leads."""
    refit = _refit(linearised)

    def fit(column: Column) -> Refitted:
        hypothesis = weights[(column.effect.id,)][1]
        departure = [d for i, d in zip(hypothesis.columns, hypothesis.departure, strict=True) if linearised.columns[i] is column]
        return refit.of([column], linearised.theta, np.array(departure or [1.0]))

    out = dict(fitted)
    for found in pool.map(fit, linearised.columns):
        known = out.get(found.effects)
        if known is None or found.log_evidence > known.log_evidence:
            out[found.effects] = found
    return out


def _gain(fitted: dict[tuple[str, ...], Refitted], ids: tuple[str, ...]) -> float:
    return fitted[ids].log_evidence - fitted[()].log_evidence


def _linear(weights: dict, ids: tuple[str, ...]) -> float:
    """Log evidence over no effect by the linear model."""
    hypothesis = weights[ids][1]
    return hypothesis.log_evidence if hypothesis else 0.0


def _probability(weights: dict, fitted: dict[tuple[str, ...], Refitted]) -> dict[tuple[str, ...], float]:
    """Full fits stand before linear ones; what was not fitted moves as the best of its linear rivals did."""
    out = {}
    moved = []
    for ids in fitted:
        out[ids] = weights[ids][0] - _linear(weights, ids) + _gain(fitted, ids)
        if ids:
            moved.append((weights[ids][0], out[ids] - weights[ids][0]))
    shift = min(0.0, max(moved)[1]) if moved else 0.0
    least = min(out.values()) if out else -math.inf
    for ids, (weight, _) in weights.items():
        if ids not in out:
            out[ids] = min(weight + shift, max(least, logsumexp(list(out.values())) - 1.0))
    return probabilities(out)
