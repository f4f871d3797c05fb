"""What two effects must bear before they are believed: any two explain a little of everything, a third that no catalogue has too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import expit

from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.classes import TELLS_APART
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.witnesses import columns_of_effects, lengths_of, witnesses

LOG_ODDS = -3.0
"""Of something unknown beside two effects: of 88 pairs that led on sealed recordings of an independent plant, with nothing else against
them, nine were not what acted; the last four that were said to be unknown by this alone were, or half of it."""
SAME, _SAME_SOFTNESS, _SAME_BOUNDS = 0.62, 0.12, (-1.0, 1.5)
"""Likeness of the signals that two effects speak through, at which it tells nothing; what of it adds 1 to those log odds; and at most."""
SLIGHT, _SLIGHT_SOFTNESS, _SLIGHT_BOUNDS = 2.67, 0.67, (-0.5, 1.5)
"""The same of the noises by which the lesser of two effects moves its worst signal: a fault that is faint moves it by some 2.2."""
_OWES = 1.5  # law errors of the greater effect, within which the lesser one may be its flaw and is not slight
CANCEL, _CANCEL_SOFTNESS = 0.5, 0.1
"""Share of what two effects do that they take from each other, at which it is as likely as not that something else acts: of two true pairs
0.36 and 0.44, of two that mimicked something else 0.67 and 0.76."""


def doubted(unknown: Unknown, linearised: Linearised, leader: Refitted) -> Unknown:
    """The same, more probable where the leading hypothesis consists of two effects that one cause in no catalogue would look like.

    Two faults rarely speak through the same signals, and each is large enough to be one. Two laws that together trace a third which nobody
    listed share its signals, and the lesser of them is as slight as the difference between the other law and this one.
    """
    if len(leader.columns) < 2:
        return unknown
    places = columns_of_effects(linearised, leader)
    share, likeness = cancelling(linearised, leader), _likeness(witnesses(linearised, leader))
    least, slight = _least_rise(linearised, leader, places)
    odds = LOG_ODDS + _told((likeness - SAME) / _SAME_SOFTNESS, _SAME_BOUNDS) + _told((SLIGHT - slight) / _SLIGHT_SOFTNESS, _SLIGHT_BOUNDS)
    note = (f"the two leading effects speak through the same signals (alike by {100.0 * likeness:.0f} %), and the lesser of them moves "
            f"none by more than {least:.1f} times its noise; one cause that no catalogue has may act instead")
    unknown = unknown.at_least(float(expit(odds)), note)
    note = (f"the two leading effects cancel {100.0 * share:.0f} % of what they do to the signals; something that no catalogue has may act "
            "instead")
    return unknown.checked("cancelling", share, CANCEL).at_least(float(expit((share - CANCEL) / _CANCEL_SOFTNESS)), note)


def proportioned(linearised: Linearised, leader: Refitted) -> bool:
    """Whether a hypothesis consists of two effects that could mimic a third in some proportion: they speak through the same signals."""
    return len(leader.columns) > 1 and _likeness(witnesses(linearised, leader)) >= SAME


def leans(kept: Refitted, both: Refitted, none: Refitted) -> bool:
    """Whether what is kept of a hypothesis needs an effect of it that is too slight to be one.

    It does where that effect adds more evidence than would tell two effects apart and than a law that is off costs the one that is kept.
    """
    owed = max(c.effect.law_error for c in kept.columns) ** 2 * max(0.0, kept.log_evidence - none.log_evidence)
    return both.log_evidence - kept.log_evidence > TELLS_APART + owed


def cancelling(linearised: Linearised, fitted: Refitted) -> float:
    """Share of what effects do to the signals, rig's parameters refitted, that they take from each other; 0 where they add up.

    With departures x and information I of their columns it is -sum of x_i I_ij x_j, i other than j, over sum of x_i I_ii x_i.
    """
    places = columns_of_effects(linearised, fitted)
    information = linearised.evidence.sums.information[np.ix_(places, places)]
    x = lengths_of(linearised, fitted, places)
    own = float(np.sum(x**2 * np.diagonal(information)))
    return max(0.0, (own - float(x @ information @ x)) / own) if own > 0.0 else 0.0


def _likeness(told: Sequence[Mapping[str, float]]) -> float:
    """Bhattacharyya's coefficient of two effects' shares: 0 where no signal tells of both, 1 where all tell alike of both."""
    one, other = told
    return sum(float(np.sqrt(share * other.get(name, 0.0))) for name, share in one.items())


def _least_rise(linearised: Linearised, fitted: Refitted, places: Sequence[int]) -> tuple[float, float]:
    """Noises by which the lesser of two effects moves its worst signal; and the same, without bound where it may be the other's flaw."""
    columns: list[Column] = [linearised.columns[i] for i in places]
    rises = np.abs(lengths_of(linearised, fitted, places)) * [c.rise for c in columns]
    greater = int(np.argmax(rises))
    least = float(rises.min())
    owed = _OWES * columns[greater].effect.law_error * float(rises[greater])
    return least, least if least > owed else np.inf


def _told(value: float, bounds: tuple[float, float]) -> float:
    return float(np.clip(value, *bounds))
