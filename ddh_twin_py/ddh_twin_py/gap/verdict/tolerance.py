"""What is called no effect: one that is too small to be seen and, without a commissioning recording, one within the sheet's tolerance."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

import numpy as np

from ddh_twin_py.gap.evidence.hypotheses import Ids
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.model import DescribedModel

BEYOND = 3.0
"""Standard deviations of the sheet's tolerance from which a quantity that it gives counts as an effect; it must lie there surely,
by one standard deviation of the estimate."""
STANDS_OUT = 2.5
"""Standard deviations of what tolerances can feign from which a departure does."""
_NO_SHARE = 1.0e-3  # of a set's probability, that is not given away


def without_parameters(model: DescribedModel, found: Found) -> Found:
    """The same with the probability of what is no effect given to the sets without it."""
    probability: dict[Ids, float] = {}
    for ids, p in found.probability.items():
        fitted = found.fitted.get(ids)
        mere = dict(fitted.slightness) if fitted else {}
        if fitted and all(model.altered):
            mere |= dict.fromkeys(within_tolerance(model, fitted), 1.0)
        for kept, share in _kept(ids, mere):
            kept = kept if kept in found.fitted else ids  # what nobody fitted has no value
            probability[kept] = probability.get(kept, 0.0) + share * p
    return found.reweighed(probability)


def _kept(ids: Ids, mere: Mapping[str, float]) -> list[tuple[Ids, float]]:
    """What may be left of a set, each with its share: effects are none with the probabilities ``mere``, each by itself."""
    left = []
    for count in range(len(ids) + 1):
        for kept in itertools.combinations(ids, count):
            left.append((kept, math.prod(1.0 - mere.get(name, 0.0) if name in kept else mere.get(name, 0.0) for name in ids)))
    return [(kept, share) for kept, share in left if share > _NO_SHARE]


def within_tolerance(model: DescribedModel, fitted: Refitted) -> set[str]:
    """Effects of a hypothesis within `BEYOND` deviations of the sheet's value, or within `STANDS_OUT` of what tolerances can feign."""
    number = model.altered.index(True)
    sheet = model.record(number, fitted.theta * 0.0)
    plain = model.record(number, fitted.theta)
    tolerances = model.tolerances()
    mere = set()
    for column, x, spread in zip(fitted.columns, fitted.x, np.sqrt(np.diagonal(fitted.covariance)), strict=True):
        if abs(x) < STANDS_OUT * spread:
            mere.add(column.effect.id)
            continue
        acted = model.record(number, fitted.theta, [(column.effect, column.law, float(x))])
        far = []
        for field, std in tolerances.items():
            if acted[field][0] != plain[field][0]:
                unsure = float(spread) * abs(float(acted[field][0] - plain[field][0]) / float(x))
                far.append(None if std is None else (abs(float(acted[field][0] - sheet[field][0])) - unsure) / std)
        if far and None not in far and max(far) < BEYOND:
            mere.add(column.effect.id)
    return mere
