"""From a place to the hypotheses that the recordings speak for: linearise, weigh, fit the leaders in full, again from there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.gap.evidence.hypotheses import Ids
from ddh_twin_py.gap.evidence.linearised import NEARBY, Linearised, linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.fits import Fits, Start
from ddh_twin_py.gap.explain.full_power import at_full_power
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.worth import Learnt

_PASSES = 3
_LIKELY, _SIZED = 0.02, 4  # sets whose sizes are sought with the whole likelihood
_USUAL = 8  # sets that are fitted in a pass
_KEPT = 3  # leading sets beside which classes are known to scatter
_HIDDEN = 0.02  # share of what all rows tell, that classes hide which scatter less beside a leading fit
_NEARER = 3  # times that classes are held to what they scatter there; fits go on, and what they leave scatters less
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

    def leading(self, most: int) -> list[Ids]:
        """No effect, and the most probable of the sets that were fitted, at most so many."""
        return list(dict.fromkeys([(), *[ids for ids in self.probability if ids in self.fitted][:most]]))

    def reweighed(self, weights: Mapping[Ids, float]) -> Found:
        """The same with other weights of its sets, which become their probabilities."""
        whole = sum(weights.values()) or 1.0
        return replace(self, probability={ids: w / whole for ids, w in sorted(weights.items(), key=lambda item: -item[1])})


@dataclass(frozen=True)
class Otherwise:
    """Where else a search begins once, if from its first place too little is explained.

    Attributes:
        theta: parameters, in deviations, (k,). left_over: says of a linearisation and its leader whether that leaves structure behind,
            which is too little as well.
    """

    theta: np.ndarray
    left_over: Callable[[Linearised, Refitted], bool]


@dataclass(frozen=True)
class _Place:
    """Where a pass is made, and what is known there.

    Attributes:
        theta: parameters, in deviations, (k,). known: where sets stood before. learnt: what fits of the pass before tell.
        near: whether sensitivities are those of a place nearby. resized: whether the sizes of columns are sought anew.
        wide: whether large effects, which bend, were not looked for yet. otherwise: where the search may still begin again.
    """

    theta: np.ndarray
    known: Mapping[Ids, Start]
    learnt: Learnt | None = None
    near: bool = False
    resized: bool = True
    wide: bool = True
    otherwise: Otherwise | None = None


def search(question: Question, theta: np.ndarray, pool: ThreadPoolExecutor, progress: Callable[[float], None] | None = None,
           otherwise: Otherwise | None = None) -> Found:
    """Search from parameters ``theta`` (k,), in deviations.

    Args:
        progress: told the share done. otherwise: where the search begins again where too little is explained; None: nowhere.
    """
    as_built = None if all(question.model.altered) else theta
    place, linearised = _Place(theta, {(): Start(theta, np.zeros(0))}, otherwise=otherwise), None
    for number in range(_PASSES):
        linearised = _linearised(question, place, linearised, pool, _before(progress, number))
        fits = Fits(linearised, linearised.weights(), pool, place.learnt, _after(progress, number))
        fits.again(place.known)
        fits.leaders()
        poor = fits.poor()
        looked = place.wide and (poor or fits.misled())
        if looked:
            fits.every_effect()
        found = Found(linearised, fits.probability(), fits.fitted)
        place = _further(replace(place, wide=place.wide and not looked), fits, found, poor) if number < _PASSES - 1 else None
        if place is None:
            break
        fits = found = None  # with runs and sensitivities of half an hour these are hundreds of megabytes
    fits.sharpen()
    fits.settle()
    found = Found(linearised, fits.probability(), fits.fitted)
    for _ in range(_NEARER):
        linearised = _beside_fits(found, question.discrepancy.scatter)
        if linearised is None:
            break
        fits = fits.on(linearised)
        fits.settle()
        found = Found(linearised, fits.probability(), fits.fitted)
    likely = [ids for ids, p in found.probability.items() if p >= _LIKELY][:_SIZED]
    if progress:
        progress(1.0)
    return replace(found, fitted=at_full_power(found.linearised, fits.fitted, likely, as_built, pool))


def _linearised(question: Question, place: _Place, before: Linearised | None, pool: ThreadPoolExecutor,
                progress: Callable[[float], None] | None) -> Linearised:
    """The case about a place, classes as uncertain as their bins scatter under the linear model's leader; ``before``: of the last pass."""
    if place.near:
        here = before.nearby(place.theta)
    else:
        asked = question if before is None else before.question  # forgiven what was found to scatter
        here = linearise(asked, place.theta, pool, progress, before, place.resized)
    return here.with_scatter(max(here.weights().values(), key=lambda w: w[0])[1])


def _beside_fits(found: Found, as_built: Mapping[tuple, float]) -> Linearised | None:
    """The same place with classes no more uncertain than they scatter beside a leading fit; None where that changes little.

    A line does not follow a large effect. What it leaves must count as noise for as long as sets are ranked by lines, else one leads
    that mends the line's own error. Fits follow, and that noise would hide from them what acts beside it.

    Args:
        as_built: how classes scatter beside the rig as commissioned, below which none goes.
    """
    here, known = found.linearised, found.linearised.discrepancy.scatter
    if all(here.model.altered):  # nothing showed how well the laws hold: what a fit bends to follow says too little of noise
        return None
    each = [here.scatter_beside(found.fitted[ids].predictions) for ids in found.leading(_KEPT)]
    least = {name: max(as_built.get(name, 1.0), min(one[name] for one in each)) for name in each[0]}
    nearer = here.scattering({name: min(known.get(name, 1.0), scatter) for name, scatter in least.items()})
    told = [(now.spread / was.spread) ** 2 for was, now in zip(here.comparisons, nearer.comparisons, strict=True)]
    return nearer if 1.0 - float(np.mean(np.concatenate(told))) > _HIDDEN else None


def _further(place: _Place, fits: Fits, found: Found, poor: bool) -> _Place | None:
    """Where the next pass is made after one at a place; None where none is needed.

    Args:
        fits, found: of that pass. poor: whether its leaders explained too little.
    """
    linearised, otherwise = found.linearised, place.otherwise
    leader = fits.fitted[found.leader if found.leader in fits.fitted else ()]
    again = otherwise is not None and (poor or otherwise.left_over(linearised, leader))
    moved = linearised.model.begin_anew(leader.theta, leader.acting)
    if not again and not poor and not moved and fits.worth.bent(leader.effects) < _CLOSE:
        return None
    theta, otherwise = (otherwise.theta, None) if again else (leader.theta, otherwise)
    near = not moved and bool(np.abs(theta - linearised.taken).max() < NEARBY)
    return _Place(theta, fits.starts(found), fits.worth.learnt(), near, fits.lost(), place.wide or again, otherwise)


def _before(progress: Callable[[float], None] | None, number: int) -> Callable[[float], None] | None:
    """Tells the share done while a pass is linearised."""
    return (lambda share: progress((number + 0.8 * share) / _PASSES)) if progress else None


def _after(progress: Callable[[float], None] | None, number: int) -> Callable[[int], None] | None:
    """Tells the share done once so many sets of a pass are fitted; how many there will be is not known."""
    return (lambda fitted: progress((number + 0.8 + 0.2 * fitted / (fitted + _USUAL)) / _PASSES)) if progress else None
