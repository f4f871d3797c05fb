"""What a hypothesis must explain: as much as any one place does where that place's inputs are free.

Free inputs are crude: they know no course in time but those of phase, speed and warmth, and pay for each of them. A true effect, which has
one number, does better than they do at its own place and at any other. Where they do better than the best listed hypothesis, something acts
that is not listed, or not by its law.
"""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from ddh_twin_py.gap.evidence.hypotheses import weigh
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.witnesses import columns_of_effects

OUTDONE, OUTDONE_SHARE, _SOFTNESS = 10.0, 0.1, 2.5
"""Log evidence by which a place's free inputs may explain more than the best listed hypothesis, and the share of what that explains beyond
it, until something unknown is as likely. Beside 18 hypotheses that led rightly on recordings of an independent plant places explained 1 to
8,500 less; but a law that errs by 0.3 (`held_out_rules.FREEDOM`) leaves 0.3 squared of what it explains to inputs that are free."""


def outdone(unknown: Unknown, place: FreePlace, linearised: Linearised, leader: Refitted, none: Refitted) -> Unknown:
    """The same, more probable where a place's free inputs explain more than the leading hypothesis.

    Args:
        unknown: beside the leader. place: that explains most of all, by the effects that are listed. none: no effect, fitted.
    """
    explained = max(leader.log_evidence - min(none.log_evidence, _none_as_places_see_it(linearised)),
                    _by_the_linear_model(linearised, leader))
    ahead, limit = place.log_evidence - explained, OUTDONE + OUTDONE_SHARE * max(0.0, explained)
    where = place.signal or place.component
    note = (f"what may be lacking at {where}, freely in each phase of the cycle and at each speed and temperature, explains the recordings "
            f"better than the best listed hypothesis does, by {ahead:.0f} nats of evidence; it would not if that were true")
    return unknown.checked("outdone", ahead, limit).at_least(float(expit((ahead - limit) / _SOFTNESS)), note)


def _none_as_places_see_it(linearised: Linearised) -> float:
    """Log evidence of no effect over which places explain something: by the linear model, with the parameters within no bounds."""
    evidence = linearised.evidence
    return evidence.none.log_volume - 0.5 * evidence.sums.chi_square


def _by_the_linear_model(linearised: Linearised, leader: Refitted) -> float:
    """Log evidence that a hypothesis gains over none on the sums that places are compared on."""
    own = columns_of_effects(linearised, leader)
    sums, room = linearised.evidence.sums, np.array([linearised.columns[i].room for i in own])
    return weigh(sums.information[np.ix_(own, own)], sums.score[own], room, linearised.question.widths)[0]
