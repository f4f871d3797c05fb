"""What held-out data ask of a rig that fitted recordings leave open: a duty of its own may open a valve that no other did."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.model import DescribedModel
from ddh_twin_py.gap.shrink import size
from ddh_twin_py.gap.shrink.held_best import AtBest
from ddh_twin_py.gap.shrink.held_runs import HeldRuns, ratios_of

_NEARER = 0.5  # floors by which held-out data must come nearer where what is open of the rig is at its best for them
_TRIED, _ITS_PART = 4, 0.25  # parameters that moved farthest and are tried alone; share of what all do, from which one is named


def asked_of_rig(model: DescribedModel, fitted: Refitted, at_best: AtBest, runs: HeldRuns) -> str:
    """Names of the parameters that held-out data ask for otherwise than a fit has them; empty where that makes little difference.

    Args:
        at_best: the data beside the fit where what is open is at its best for them. runs: of the data.
    """
    as_run = runs.gap(fitted)
    nearer = as_run - at_best.gap
    if nearer < _NEARER:
        return ""
    names = [parameter.name for parameter in model.fitted_parameters(fitted.theta, np.zeros(model.size))]
    moved = np.abs(at_best.theta - fitted.theta)[: len(names)]
    alone = {}
    for i in np.argsort(-moved)[:_TRIED]:
        theta = fitted.theta.copy()
        theta[i] = at_best.theta[i]
        alone[names[i]] = as_run - size.gap(ratios_of(runs.held, runs.held.run(theta, fitted.acting)), runs.floor)
    return " and ".join(name for name in sorted(alone, key=lambda name: -alone[name]) if alone[name] > _ITS_PART * nearer)


def told(as_run: float, at_best: float, names: str, validation: bool) -> str:
    """A note on a gap of held-out data that another value of these parameters explains.

    Args:
        as_run, at_best: gap of held-out data with the fitted values and with those, in multiples of the floor. validation: whether they
            are a recording of their own; else they are the end of the one that was fitted.
    """
    shows = ("that duty shows of the rig what no fitted recording does, and it is within tolerance" if validation else
             "the end of the recording asks for another rig than what was fitted before it, within tolerance all the same")
    return f"the held-out data lie {as_run:.1f} times the floor off, but {at_best:.1f} with another {names}: {shows}"
