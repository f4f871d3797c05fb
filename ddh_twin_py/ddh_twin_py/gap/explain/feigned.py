"""What hypotheses without an effect may owe to laws of the rig itself that are a little off in another duty than they were fitted to.

Such a law looks like a small departure of the effect, whatever acts. With the effect it changes nothing, as that has any size; without it
the departure found is no longer as unlikely. With s the standard deviation of that departure and f the one that the law may feign
(`effect.Effect.feigned`), it makes good f^2/(s^2 + f^2) of what the effect gains over the hypothesis without it: a departure x that costs
x^2/(2 s^2) without it costs x^2/(2 (s^2 + f^2)) then. Without a large departure the rig's parameters give way, which costs less than its
s about the optimum says; what it does cost, the gain, tells the s that counts on the way: x^2/(2 s^2) is no more than that.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.gap.evidence.hypotheses import Ids
from ddh_twin_py.gap.explain.refit import Refitted


def made_good(fitted: Mapping[Ids, Refitted]) -> dict[Ids, float]:
    """Log evidence, more than 0, that hypotheses gain by such a law, of those that were fitted with and without an effect it may feign."""
    out: dict[Ids, float] = {}
    for ids, with_it in fitted.items():
        for column, x, variance in zip(with_it.columns, with_it.x, np.diagonal(with_it.covariance), strict=True):
            rest, may = tuple(name for name in ids if name != column.effect.id), column.effect.feigned**2
            if not may or rest not in fitted or not 0.0 < variance < np.inf:
                continue
            gained = with_it.log_evidence - fitted[rest].log_evidence
            if gained > 0.0:
                out[rest] = max(out.get(rest, 0.0), gained * may / (max(variance, 0.5 * x**2 / gained) + may))
    return out
