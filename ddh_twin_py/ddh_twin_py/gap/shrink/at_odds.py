"""Recordings of one case that do not go together: a validation of which the field shows nothing, a commissioning that misleads.

A cause is in the field recording, where it was sought. What the validation alone shows may as well be another rig, load or state.
"""

from __future__ import annotations

from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.model import DescribedModel
from ddh_twin_py.gap.shrink import size
from ddh_twin_py.gap.shrink.held_runs import HeldRuns, in_fitted

_EXPLAINED = 1.3  # floors within which a field recording is explained
_FAR = 2.0  # floors from which other recordings are off


def at_odds(model: DescribedModel, best: Refitted, runs: HeldRuns, as_is: float, before: float) -> list[str]:
    """What to ask about the recordings of a case of which something unknown is said; none where they go together.

    Args:
        best: hypothesis as fitted. runs: of held-out data.
        as_is, before: gap of these with the sheet's parameters, and as commissioned, in multiples of the floor.
    """
    said = []
    if "validation" in model.recordings:
        inside = size.of_all(in_fitted(model, best, runs.floor, acts=True))
        outside = runs.gap(best)
        if inside <= _EXPLAINED and outside > _FAR:
            paths = ", ".join(model.recordings["validation"])
            said.append(f"{paths}: it lies {outside:.1f} times the floor off with what explains the field recording to {inside:.1f}; is it "
                        "of the same rig, in the state of the field recording and with the payload that it declares? If it is, what it "
                        "shows does not act, or hardly, in the field recording's duty")
    if not all(model.altered) and before > max(_FAR, as_is):
        paths = ", ".join(model.recordings["commissioning"])
        said.append(f"{paths}: fitted to it, the twin is farther off what was recorded later ({before:.1f} times the floor) than "
                    f"with the sheet's parameters ({as_is:.1f}); is it of the same rig, and with the payload that it declares?")
    return said
