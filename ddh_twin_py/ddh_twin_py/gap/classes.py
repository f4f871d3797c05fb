"""Effects that a recording cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_twin_py.gap.hypotheses import WIDTH
from ddh_twin_py.gap.linearised import Linearised

TELLS_APART = 3.0
"""Expected log Bayes factor from which two effects count as told apart."""
NOTICEABLE = 0.05
"""Probability below which an effect is in no class."""


def separation(linearised: Linearised, one: int, other: int, departure: float) -> float:
    """Expected log Bayes factor of a column against another where the first is the truth.

    With information I (shared unknowns integrated out) and a departure x of the first, the best that
    the second can do leaves x^2 (I_11 - I_12^2 / (I_22 + 1/w^2)) / 2 unexplained.

    Args:
        one, other: indices of columns. departure: of the first, in multiples of it.
    """
    i = linearised.evidence.sums.information
    return 0.5 * departure**2 * float(i[one, one] - i[one, other] ** 2 / (i[other, other] + WIDTH**-2))


def classes_of(linearised: Linearised, probability: dict[str, float]) -> tuple[list[list[str]], dict[str, str]]:
    """Classes among effects of noticeable probability, and why each member cannot be told from the others.

    Args:
        probability: of each effect.
    """
    columns = linearised.columns
    best: dict[str, int] = {}
    departures: dict[str, float] = {}
    for index, column in enumerate(columns):
        own = column.effect.id
        if probability.get(own, 0.0) < NOTICEABLE:
            continue
        single = linearised.evidence.of([index])
        if own not in best or single.log_evidence > linearised.evidence.of([best[own]]).log_evidence:
            best[own], departures[own] = index, float(single.departure[0])
    names = sorted(best, key=lambda name: -probability[name])
    classes: list[list[str]] = []
    why: dict[str, str] = {}
    for name in names:
        for members in classes:
            lead = members[0]
            apart = separation(linearised, best[lead], best[name], departures[lead])
            if apart < TELLS_APART:
                members.append(name)
                why[name] = _why(linearised, best[name], best[lead], name, lead, apart)
                why.setdefault(lead, _why(linearised, best[lead], best[name], lead, name, apart))
                break
        else:
            classes.append([name])
    return [members for members in classes if len(members) > 1], why


def _why(linearised: Linearised, one: int, other: int, name: str, lead: str, apart: float) -> str:
    i = linearised.evidence.sums.information
    likeness = float(i[one, other] / np.sqrt(i[one, one] * i[other, other]))
    return (f"what {name} does to the signals is, after the rig's parameters are refitted, to {100.0 * likeness:.0f} % what {lead} does; "
            f"this recording is expected to tell them apart by {apart:.1f} of the {TELLS_APART:.0f} that would be needed (log of odds)")


def marginal(probability: dict[tuple[str, ...], float], ids: Sequence[str]) -> dict[str, float]:
    """Probability that each effect acts, alone or beside another."""
    return {name: float(sum(p for effects, p in probability.items() if name in effects)) for name in ids}
