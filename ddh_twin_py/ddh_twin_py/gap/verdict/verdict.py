"""From probabilities to one of the contract's verdicts."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ddh_twin_py.gap.explain.classes import classes_of
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.verdict.unknown import LISTED, Unknown

SURE = 0.7
"""Probability of a set, with what it cannot be told from, from which it is said to explain the gap."""
LIKELY = 0.5
"""Probability from which there is no gap, or from which its cause is unknown."""
UNKNOWN = "unknown"
NEARLY = 1.25
"""Multiple of the floor up to which a gap of held-out data is nearly none."""
NO_HELP = 5.0
"""Log odds that a hypothesis loses at most against no effect, where it brings held-out data no nearer."""
_SHRINKS = 0.95  # share of a gap that is left, from which a hypothesis hardly shrinks it
_LOUD, _RELIEVED = 20.0, 8.0  # log evidence of a hypothesis, and what of it is relief of parameters: larger than flaws of laws make them
_FAR, _NEARER = 2.0, 0.75  # floors that a signal is far off, and what of it is left where a hypothesis brings it much nearer
_NOTHING_LEFT = 0.2
"""What is left of every probability where held-out data have no gap: of 130 answers of no gap without commissioning 24 hid an effect."""


@dataclass(frozen=True)
class Verdict:
    """A verdict.

    Attributes:
        word: of the contract. leader: most probable set of listed effects. sets: set to probability; ``("unknown",)`` is
            outside the catalogue. effects: effect to marginal probability, largest first. together: probability of the leader with
            all that it cannot be told from; 0 where it is not asked.
    """

    word: str
    leader: tuple[str, ...]
    sets: dict[tuple[str, ...], float]
    effects: dict[str, float]
    together: float = 0.0


def less_believed(found: Found, lost: Mapping[tuple[str, ...], float]) -> Found:
    """The same where the leader does not help with held-out data: what is true would help there too.

    How strongly the field recording speaks for it still counts, as its effect may be one that the held-out duty does not show.

    Args:
        lost: log odds that sets of effects lose against none, the leader among them; those that are not told lose as much as it does.
    """
    odds = {ids: p * (math.exp(-lost.get(ids, lost[found.leader])) if ids else 1.0) for ids, p in found.probability.items()}
    return found.reweighed(odds)


def something_acting(found: Found, unknown: Unknown, probability: float, note: str) -> tuple[Found, Unknown]:
    """The same where the rig as commissioned would hardly show what was recorded since: what spoke for no effect speaks for nothing listed.

    Listed effects keep what they have: that no rig within reach explains the recordings without them is no evidence for one of them.

    Args:
        probability: that something acts. note: that says why.
    """
    lost = probability * found.probability.get((), 0.0)
    if lost <= 0.0:
        return found, unknown
    if lost < 1.0:
        found = found.reweighed({ids: p * (1.0 if ids else 1.0 - probability) for ids, p in found.probability.items()})
    whole = unknown.probability + (1.0 - unknown.probability) * lost
    return found, unknown.raised(whole, note) if probability >= LIKELY else replace(unknown, probability=whole)


def explains_a_signal(without: Mapping[str, float], beside: Mapping[str, float]) -> bool:
    """Whether a hypothesis brings a signal of held-out data much nearer that is far off without it.

    That all signals together are within the floor, or those that sum up no flaw of the laws, does not make it nothing: an effect that a
    single signal shows, as the winding shows its own resistance, is lost among many.

    Args:
        without, beside: RMS over floor of each signal without and beside it.
    """
    return any(off > _FAR and beside[name] < _NEARER * off for name, off in without.items())


def nothing_to_explain(gaps: Sequence[tuple[float, float]], speaks: float, relieved: float) -> bool:
    """Whether, without commissioning, nothing is to be explained: no gap beyond the floor, or hardly one that the leader does not shrink.

    Parameters take an effect up and leave no gap in other duties either, but at a price: they must leave the sheet far. An effect that
    relieves them of that is no flaw of the laws, which would not know where the sheet lies.

    Args:
        gaps: of held-out data without and beside the leader, in multiples of the floor, in each way in which they may be small: within the
            floor, or nearly and with the leader hardly less. speaks: log evidence of the leader over no effect.
        relieved: that part of it which parameters cost less, by their tolerances, than without it, for each of its effects.
    """
    small = any(without <= 1.0 or (without <= NEARLY and beside > _SHRINKS * without) for without, beside in gaps)
    return small and speaks < _LOUD and min(speaks, relieved) < _RELIEVED


def judge(found: Found, unknown: Unknown, nothing_beyond: bool = False) -> Verdict:
    """Judge what a search found and what is left beside it.

    Args:
        nothing_beyond: whether nothing is beyond the floor, so that there is nothing to explain.
    """
    leader, outside = found.leader, min(unknown.probability, 1.0 - LISTED)
    sets = {ids: (1.0 - outside) * p for ids, p in found.probability.items()}
    sets[(UNKNOWN,)] = outside
    sets = dict(sorted(sets.items(), key=lambda item: -item[1]))
    effects = marginal_of(sets)
    if nothing_beyond:  # what the field recording seems to speak for has nothing to explain elsewhere
        sets = {ids: _NOTHING_LEFT * p for ids, p in sets.items()}
        sets[()] = sets.get((), 0.0) + 1.0 - _NOTHING_LEFT
        sets = dict(sorted(sets.items(), key=lambda item: -item[1]))
        return Verdict("no_gap", (), sets, marginal_of(sets))
    if outside >= LIKELY:
        return Verdict("unknown", leader, sets, effects)
    if sets.get((), 0.0) >= LIKELY:
        return Verdict("no_gap", (), sets, effects)
    together = _together(found, sets, effects, leader) if leader else 0.0
    return Verdict("explained" if leader and together >= SURE else "ambiguous", leader, sets, effects, together)


def marginal_of(sets: dict[tuple[str, ...], float]) -> dict[str, float]:
    """Marginal probability of each effect, largest first."""
    effects = {name: float(sum(p for ids, p in sets.items() if name in ids)) for name in dict.fromkeys(n for ids in sets for n in ids)}
    return dict(sorted(effects.items(), key=lambda item: -item[1]))


def _together(found: Found, sets, effects, leader: tuple[str, ...]) -> float:
    """Probability of all sets that hold the leader, members of one class standing for each other."""
    classes, _ = classes_of(found.linearised, effects, found.fitted)
    of = {name: number for number, members in enumerate(classes) for name in members}

    def key(ids: tuple[str, ...]) -> Counter[int | str]:
        return Counter(of.get(name, name) for name in ids)

    return sum(p for ids, p in sets.items() if key(ids) >= key(leader))
