"""Leading hypotheses where the likelihood counts in full: the sizes, parameters and runs that an answer tells.

The power makes evidence and deviations honest, but gives priors the upper hand over what commissioning told of the rig.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from ddh_twin_py.gap.evidence.hypotheses import Ids
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.refit import Refit, Refitted

_ANY_SIZE = 10.0  # columns: width of the prior of sizes, once it is asked how large an effect is and not whether it is there
_BETTER = 2.0  # log evidence by which a fit from the rig as built must be better than one from elsewhere to be followed


def at_full_power(linearised: Linearised, fitted: Mapping[Ids, Refitted], wanted: Sequence[Ids], as_built: np.ndarray | None,
                  pool: ThreadPoolExecutor) -> dict[Ids, Refitted]:
    """The fits, those wanted with parameters, sizes and runs where the likelihood counts in full; evidence and covariance stay.

    The first of those wanted is fitted with sensitivities of its own place: steps by those of another stop where the other place's
    model is at its lowest, not its own, and held-out data feel that. Its evidence stays as it was, in fairness to the others. Its joint
    covariance is that of its own place: a conductance of which an eighth is left no longer answers to its tolerance as the whole did.

    Args:
        fitted: by set; () is among them. wanted: sets, the leading one first.
        as_built: parameters of the rig as commissioned, deviations, (k,); None where nothing showed it.
    """
    first, *rest = (ids for ids in dict.fromkeys([*wanted, ()]) if ids in fitted)
    refit = _in_full(linearised)
    others = {ids: pool.submit(_from_both, refit, fitted[ids], as_built) for ids in rest}
    leader = _of_its_own(linearised, _from_both(refit, fitted[first], as_built)[0], as_built, pool)  # here meanwhile: it takes the longest
    out = dict(fitted)
    for ids, now in {first: leader, **{ids: fit.result()[0] for ids, fit in others.items()}}.items():
        misfit = linearised.basis.misfit([c.residual(p) for c, p in zip(linearised.comparisons, now.predictions, strict=True)])
        out[ids] = replace(fitted[ids], x=now.x, theta=now.theta, predictions=now.predictions, chi_square=misfit, beside=now.beside,
                           joint=now.joint if ids == first else fitted[ids].joint)
    return out


def _of_its_own(linearised: Linearised, fitted: Refitted, as_built: np.ndarray | None, pool: ThreadPoolExecutor) -> Refitted:
    """A fit with sensitivities of its own place, and of where these lead from the rig as built; its joint covariance is of the power."""
    every = range(len(linearised.comparisons))
    here = linearised.acting_at(fitted.theta, fitted.acting, every, pool)
    reached, from_built = _from_both(_in_full(here), fitted, as_built)
    if from_built:
        here = linearised.acting_at(reached.theta, reached.acting, every, pool)
        reached = _in_full(here).again(reached)
    return replace(reached, joint=Refit(here, width=_ANY_SIZE).joint(reached))


def _from_both(refit: Refit, fitted: Refitted, as_built: np.ndarray | None) -> tuple[Refitted, bool]:
    """A fit from where it stands or from the rig as built, and whether from there: along a flat valley steps stop on the way."""
    reached = refit.again(fitted)
    if as_built is None or not fitted.columns:
        return reached, False
    other = refit.of(fitted.columns, as_built, np.array([x / c.x for c, x in zip(fitted.columns, reached.x, strict=True)]))
    better = other.log_evidence > reached.log_evidence + _BETTER
    return (other if better else reached), better


def _in_full(linearised: Linearised) -> Refit:
    return Refit(linearised, linearised.basis.otherwise(1.0, 1.0), _ANY_SIZE)
