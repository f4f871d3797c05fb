"""From a place to the hypotheses that the recordings speak for: linearise, weigh, fit the leaders in full, again from there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Discrepancy
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.evidence.hypotheses import SLACK, Ids, weighted
from ddh_twin_py.gap.evidence.linearised import Linearised, linearise
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.fits import Fits, Start
from ddh_twin_py.gap.explain.full_power import at_full_power
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.model import Model

_PASSES = 3
_LIKELY, _SIZED = 0.02, 4  # sets whose sizes are sought with the whole likelihood
_USUAL = 8  # sets that are fitted in a pass
_NEARBY = 0.5  # deviations of every parameter, within which sensitivities are not taken anew
_CLOSE = 3.0  # difference of log evidence between linear and full that needs no further pass


@dataclass(frozen=True)
class Found:
    """What a search found.

    Attributes:
        linearised: sensitivities about the leading hypothesis' parameters.
        probability: sets of effects, most probable first; () is none.
        fitted: the leaders and () fitted in full; of the likeliest x, theta and predictions where the likelihood counts in full, evidence
            and covariances where it counts by its power.
    """

    linearised: Linearised
    probability: dict[Ids, float]
    fitted: dict[Ids, Refitted]

    @property
    def leader(self) -> Ids:
        """The most probable set."""
        return next(iter(self.probability))

    def reweighed(self, weights: Mapping[Ids, float]) -> Found:
        """The same with other weights of its sets, which become their probabilities."""
        whole = sum(weights.values()) or 1.0
        return replace(self, probability={ids: w / whole for ids, w in sorted(weights.items(), key=lambda item: -item[1])})


def search(model: Model, effects: Sequence[Effect], theta: np.ndarray, discrepancy: Discrepancy, power: float,
           pool: ThreadPoolExecutor, progress: Callable[[float], None] | None = None, otherwise: np.ndarray | None = None,
           left_over: Callable[[Linearised, Refitted], bool] | None = None) -> Found:
    """Search from parameters ``theta`` (k,), in deviations.

    Args:
        effects: that may act. discrepancy: what the model is forgiven. power: see `hypotheses.POWER`.
        progress: told the share done. otherwise: parameters from which to begin again, (k,), where too little is explained from there.
        left_over: says whether a hypothesis leaves structure behind; None: it is not asked.
    """
    linearised, learnt, known = None, None, {(): Start(theta, np.zeros(0))}
    as_built = None if all(model.altered) else theta
    ways: Sequence[Column] = ()  # whose sizes are kept
    near = False  # whether sensitivities are those of a place nearby
    wide = True  # whether large effects, which bend, were not looked for yet
    for number in range(_PASSES):
        told = (lambda share, n=number: progress((n + 0.8 * share) / _PASSES)) if progress else None
        if near:
            linearised = linearised.nearby(theta)
        else:
            linearised = linearise(model, effects, theta, discrepancy, SLACK, power, pool, told, linearised, ways)
        weights = _weights(linearised)
        linearised = linearised.with_scatter(max(weights.values(), key=lambda w: w[0])[1])
        weights = _weights(linearised)
        fits = Fits(linearised, weights, pool, learnt, _after(progress, number))
        fits.again(known)
        fits.leaders()
        poor = fits.poor()
        if wide and (poor or fits.misled()):
            fits.every_effect()
            wide = False
        found = Found(linearised, fits.probability(), fits.fitted)
        leader = found.leader if found.leader in fits.fitted else ()
        again = otherwise is not None and (poor or (left_over is not None and left_over(linearised, fits.fitted[leader])))
        last = number == _PASSES - 1
        moved = not last and model.begin_anew(fits.fitted[leader].theta, fits.fitted[leader].acting)
        if last or (not again and not poor and not moved and fits.bent(leader) < _CLOSE):
            break
        known, discrepancy, learnt = fits.starts(found), linearised.discrepancy, fits.learnt()
        ways = () if fits.lost() else linearised.columns
        wide = wide or again
        theta, otherwise = (otherwise, None) if again else (fits.fitted[leader].theta, otherwise)
        near = not moved and np.abs(theta - linearised.taken).max() < _NEARBY
        fits = found = None  # with runs and sensitivities of half an hour these are hundreds of megabytes
    fits.sharpen()
    fits.settle()
    found = Found(linearised, fits.probability(), fits.fitted)
    likely = [ids for ids, p in found.probability.items() if p >= _LIKELY][:_SIZED]
    if progress:
        progress(1.0)
    return replace(found, fitted=at_full_power(linearised, fits.fitted, likely, as_built, pool))


def _after(progress: Callable[[float], None] | None, number: int) -> Callable[[int], None] | None:
    """Tells the share done once so many sets of a pass are fitted; how many there will be is not known."""
    return (lambda fitted: progress((number + 0.8 + 0.2 * fitted / (fitted + _USUAL)) / _PASSES)) if progress else None


def _weights(linearised: Linearised) -> dict:
    evidence = linearised.evidence
    singles = evidence.singles()
    return weighted(singles + evidence.pairs(singles), linearised.columns, linearised.effects)
