"""Recordings of one case that do not go together: a validation of which the field shows nothing, a commissioning that misleads.

A cause is in the field recording, where it was sought. What the validation alone shows may as well be another rig, load or state.
"""

from __future__ import annotations

from collections.abc import Mapping

from ddh_twin_py.gap import size
from ddh_twin_py.gap.held_runs import HeldRuns
from ddh_twin_py.gap.model import Diagnosable
from ddh_twin_py.gap.refit import Refitted

_EXPLAINED = 1.3  # floors within which a field recording is explained
_FAR = 2.0  # floors from which other recordings are off


def at_odds(model: Diagnosable, best: Refitted, runs: HeldRuns, as_is: Mapping[str, float], before: Mapping[str, float]) -> list[str]:
    """What to ask about the recordings of a case of which something unknown is said; none where they go together.

    Args:
        best: hypothesis as fitted. runs: of held-out data.
        as_is, before: multiples of their noise by which signals of these are off with the sheet's parameters, and as commissioned.
    """
    said, floor = [], runs.floor
    if "validation" in model.recordings:
        fitted = [(s, p) for s, p, altered in zip(model.signals, best.predictions, model.altered, strict=True) if altered]
        inside = size.gap({name: ratio for name, ratio in size.pooled(fitted).items() if name in floor}, floor)
        outside = runs.gap(best)
        if inside <= _EXPLAINED and outside > _FAR:
            paths = ", ".join(model.recordings["validation"])
            said.append(f"{paths}: it lies {outside:.1f} times the floor off with what explains the field recording to {inside:.1f}; is it "
                        "of the same rig, in the state of the field recording and with the payload that it declares? If it is, what it "
                        "shows does not act, or hardly, in the field recording's duty")
    unfitted, commissioned = size.gap(as_is, floor), size.gap(before, floor)
    if not all(model.altered) and commissioned > max(_FAR, unfitted):
        paths = ", ".join(model.recordings["commissioning"])
        said.append(f"{paths}: fitted to it, the twin is farther off what was recorded later ({commissioned:.1f} times the floor) than "
                    f"with the sheet's parameters ({unfitted:.1f}); is it of the same rig, and with the payload that it declares?")
    return said
