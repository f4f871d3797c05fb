"""Effects that a recording cannot tell apart."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ddh_twin_py.gap.evidence.hypotheses import WIDTH
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.refit import Refitted

TELLS_APART = 3.0
"""Log Bayes factor from which two effects count as told apart: expected by the sensitivities, or found by fits in full."""
NOTICEABLE = 0.05
"""Probability below which an effect is in no class."""


def separations(information: np.ndarray, departures: np.ndarray) -> np.ndarray:
    """Expected log Bayes factor of every column (row) against every other (column) where the first is the truth, (m, m).

    With information I (shared unknowns integrated out) and a departure x of the first, the best that
    the second can do leaves x^2 (I_11 - I_12^2 / (I_22 + 1/w^2)) / 2 unexplained; all of the first where it would have to act the other
    way, as a column acts in its own direction alone.

    Args:
        information: of columns, (m, m). departures: of each, in multiples of it, (m,).
    """
    own = np.diagonal(information)
    return 0.5 * departures[:, None] ** 2 * (own[:, None] - np.maximum(information, 0.0) ** 2 / (own + WIDTH**-2))


def separation(linearised: Linearised, one: int, other: int, departure: float) -> float:
    """The same of one column against another.

    Args:
        one, other: indices of columns. departure: of the first, in multiples of it.
    """
    pair = [one, other]
    return float(separations(linearised.evidence.sums.information[np.ix_(pair, pair)], np.full(2, departure))[0, 1])


def found_apart(fitted: Mapping[tuple[str, ...], Refitted], one: str, other: str, law_error: float = 0.0) -> float:
    """Log Bayes factor of an effect against another in its place, by fits in full; infinite where these do not show it.

    Sensitivities know neither how the rig's parameters bend nor how well either law is the rig's. A law that is off by 10 % costs its
    effect 1 % of what it explains, which is no evidence for another. Two that explain more together than one of them does stand in no
    one's place.

    Args:
        fitted: sets of effects, fitted; the one of most evidence that holds ``one`` and not ``other`` is asked.
        law_error: share by which a law may misjudge its effect; the square of it, of what ``one`` explains, is taken off.
    """
    places = [ids for ids in fitted if one in ids and other not in ids]
    best = max(places, key=lambda ids: fitted[ids].log_evidence, default=())
    rest = {*best} - {one}
    instead, without = fitted.get(tuple(sorted(rest | {other}))), fitted.get(tuple(sorted(rest)))
    if not best or instead is None:
        return math.inf
    log = fitted[best].log_evidence
    together = max((f.log_evidence for ids, f in fitted.items() if {one, other} <= {*ids}), default=-math.inf)
    if together - log > TELLS_APART:
        return math.inf
    unsure = law_error**2 * max(0.0, log - without.log_evidence) if without else 0.0
    return max(0.0, abs(log - instead.log_evidence) - unsure)


def classes_of(linearised: Linearised, probability: Mapping[str, float],
               fitted: Mapping[tuple[str, ...], Refitted]) -> tuple[list[list[str]], dict[str, str]]:
    """Classes among effects of noticeable probability, and why each member cannot be told from the others.

    Args:
        probability: of each effect. fitted: sets of effects, fitted in full.
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
            law_error = columns[best[lead]].effect.law_error
            expected = separation(linearised, best[lead], best[name], departures[lead])
            found = found_apart(fitted, lead, name, law_error)
            if min(expected, found) < TELLS_APART:
                members.append(name)
                said = f"is expected to tell them apart by {expected:.1f}" if expected < TELLS_APART else f"tells them apart by {found:.1f}"
                why[name] = _why(linearised, best[name], best[lead], name, lead, said)
                why.setdefault(lead, _why(linearised, best[lead], best[name], lead, name, said))
                break
        else:
            classes.append([name])
    return [members for members in classes if len(members) > 1], why


def _why(linearised: Linearised, one: int, other: int, name: str, lead: str, said: str) -> str:
    i = linearised.evidence.sums.information
    likeness = float(i[one, other] / np.sqrt(i[one, one] * i[other, other]))
    return (f"what {name} does to the signals is, after the rig's parameters are refitted, to {100.0 * likeness:.0f} % what {lead} does; "
            f"this recording {said} of the {TELLS_APART:.0f} that would be needed (log of odds)")
