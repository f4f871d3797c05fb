"""What effects of a hypothesis may owe to laws of the rig itself that are a little off in another duty than they were fitted to.

Such a law looks like a small departure of the effect, whatever acts. With the effect it changes nothing, as that has any size; without it
the departure found is no longer as unlikely. With s the standard deviation of that departure and f the one that the law may feign
(`effect.Effect.feigned`), it explains f^2/(s^2 + f^2) of what the effect gains over the hypothesis without it, as a departure x that costs
x^2/(2 s^2) without it costs x^2/(2 (s^2 + f^2)) then.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.gap.evidence.hypotheses import Ids
from ddh_twin_py.gap.explain.refit import Refitted


def feigned(fitted: Refitted, others: Mapping[Ids, Refitted]) -> float:
    """Log evidence that a hypothesis may owe to them; 0 or more.

    Args:
        others: hypotheses that were fitted, no effect among them.
    """
    owed = 0.0
    for column, variance in zip(fitted.columns, np.diagonal(fitted.covariance), strict=True):
        may = column.effect.feigned**2
        if may and 0.0 < variance < np.inf:
            rest = set(fitted.effects) - {column.effect.id}
            without = max(other.log_evidence for ids, other in others.items() if rest >= set(ids))
            owed += may / (variance + may) * max(0.0, fitted.log_evidence - without)
    return owed
