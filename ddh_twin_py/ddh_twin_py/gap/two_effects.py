"""What two effects must bear before they are believed: any two explain a little of everything, a third that no catalogue has too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ddh_twin_py.gap.linearised import Linearised
from ddh_twin_py.gap.refit import Refitted
from ddh_twin_py.gap.unknown import Unknown

DOUBT = 0.12
"""Probability of something unknown beside two effects: of 45 pairs that led on sealed recordings of an independent plant, with nothing else
against them, six were not what acted."""
CANCEL, CANCEL_DOUBT = 0.3, 0.5
"""Share of what two effects do that cancels, from which it is as likely as not that something else acts."""


def doubted(unknown: Unknown, linearised: Linearised, leader: Refitted) -> Unknown:
    """The same, more probable where the leading hypothesis consists of two effects, the more where they cancel each other."""
    if len(leader.columns) < 2:
        return unknown
    share = cancelling(linearised, leader)
    if share >= CANCEL:
        note = f"the two leading effects cancel {share:.0%} of what they do to the signals; something that no catalogue has may act instead"
        return unknown.raised(CANCEL_DOUBT, note)
    return replace(unknown, probability=max(unknown.probability, DOUBT))


def cancelling(linearised: Linearised, fitted: Refitted) -> float:
    """Share of what effects do to the signals, rig's parameters refitted, that they take from each other; 0 where they add up.

    With departures x and information I of their columns it is -sum of x_i I_ij x_j, i other than j, over sum of x_i I_ii x_i.
    """
    ways = [(column.effect.id, column.law, column.x > 0.0) for column in linearised.columns]
    places = [ways.index((column.effect.id, column.law, column.x > 0.0)) for column in fitted.columns]
    information = linearised.evidence.sums.information[np.ix_(places, places)]
    x = fitted.x / np.array([column.x for column in fitted.columns])
    own = float(np.sum(x**2 * np.diagonal(information)))
    return max(0.0, (own - float(x @ information @ x)) / own) if own > 0.0 else 0.0
