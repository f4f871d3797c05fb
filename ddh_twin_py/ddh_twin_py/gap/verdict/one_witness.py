"""What an effect must bear that a single signal tells of: a sensor that fails in a way that no catalogue has tells the same."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.witnesses import witnesses

DOUBT = 0.25
"""Probability of something unknown beside an effect of which one signal alone tells: of two that led so on sealed recordings of an
independent plant one was a sensor that drifts; drawn towards the one in twenty of all others."""
_HEARD, _ALONE = 0.75, 0.95
"""Share of what tells of an effect that the loudest signal may have without doubt, and from which it stands alone."""


def doubted_alone(unknown: Unknown, linearised: Linearised, leader: Refitted) -> Unknown:
    """The same, more probable where one effect leads and one signal bears nearly all evidence of it.

    A wrong flow, force or heat shows in several signals. What one alone shows may be its sensor. A listed fault of a sensor speaks through
    that sensor by nature and is not doubted for it.
    """
    if leader.columns[0].effect.domain == "measurement":
        return unknown
    (shares,) = witnesses(linearised, leader)
    loudest = max(shares, key=shares.get)
    doubt = DOUBT * float(np.clip((shares[loudest] - _HEARD) / (_ALONE - _HEARD), 0.0, 1.0))
    if doubt == 0.0:
        return unknown
    note = (f"{100.0 * shares[loudest]:.0f} % of what tells of {leader.effects[0]} is told by {loudest}; a fault of that sensor may look "
            "the same")
    return unknown.raised(doubt, note)
