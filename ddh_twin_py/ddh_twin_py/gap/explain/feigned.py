"""What effects of a hypothesis may owe to laws of the rig itself that are a little off in another duty than they were fitted to.

Such a law looks like a small departure of the effect, whatever acts. With the effect it changes nothing, as that has any size; without it
the departure found, x, is no longer as unlikely: its evidence against none falls by

    x^2/(2 s^2) - x^2/(2 (s^2 + f^2)) - log((s^2 + f^2)/s^2)/2     s: of the departure, f: `effect.Effect.feigned`
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.gap.explain.refit import Refitted


def feigned(fitted: Refitted) -> float:
    """Log evidence that a hypothesis has too much for that; 0 or more."""
    each = zip(fitted.columns, fitted.x, np.diagonal(fitted.covariance), strict=True)
    return sum(_too_much(float(x), float(variance), column.effect.feigned) for column, x, variance in each if column.effect.feigned)


def _too_much(x: float, variance: float, feigned: float) -> float:
    if not 0.0 < variance < math.inf:
        return 0.0
    wide = variance + feigned**2
    return max(0.0, 0.5 * x**2 * (1.0 / variance - 1.0 / wide) - 0.5 * math.log(wide / variance))
