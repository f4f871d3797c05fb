"""What is called no effect: one that is too small to be seen and, without a commissioning recording, one within the sheet's tolerance."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.model import DescribedModel

BEYOND = 3.0
"""Standard deviations of the sheet's tolerance from which a quantity that it gives counts as an effect; it must lie there surely,
by one standard deviation of the estimate."""
STANDS_OUT = 2.5
"""Standard deviations of what tolerances can feign from which a departure does."""


def without_parameters(model: DescribedModel, found: Found) -> Found:
    """The same with the probability of what is no effect given to the sets without it."""
    probability: dict[tuple[str, ...], float] = {}
    for ids, p in found.probability.items():
        fitted = found.fitted.get(ids)
        mere = fitted.slight if fitted else set()
        if fitted and all(model.altered):
            mere |= within_tolerance(model, fitted)
        kept = tuple(name for name in ids if name not in mere)
        kept = kept if kept in found.fitted else ids  # what nobody fitted has no value
        probability[kept] = probability.get(kept, 0.0) + p
    return found.reweighed(probability)


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
