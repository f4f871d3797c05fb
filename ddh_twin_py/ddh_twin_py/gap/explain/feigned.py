"""What effects of a hypothesis may owe to laws of the rig itself that are a little off in another duty than they were fitted to.

Such a law looks like a small departure of the effect, whatever acts. With the effect it changes nothing, as that has any size; without it
the departure found is no longer as unlikely. With s the standard deviation of that departure and f the one that the law may feign
(`effect.Effect.feigned`), it explains f^2/(s^2 + f^2) of what the effect gains over the hypothesis without it, as a departure x that costs
x^2/(2 s^2) without it costs x^2/(2 (s^2 + f^2)) then. Without a large departure the rig's parameters give way, which costs less than its
s about the optimum says; what it does cost, the gain, tells the s that counts on the way: x^2/(2 s^2) is no more than that.
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
    for column, x, variance in zip(fitted.columns, fitted.x, np.diagonal(fitted.covariance), strict=True):
        may = column.effect.feigned**2
        if may and 0.0 < variance < np.inf:
            rest = set(fitted.effects) - {column.effect.id}
            gained = fitted.log_evidence - max(other.log_evidence for ids, other in others.items() if rest >= set(ids))
            if gained > 0.0:
                owed += gained * may / (max(variance, 0.5 * x**2 / gained) + may)
    return owed
