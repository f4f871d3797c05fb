"""How large an effect must be for a recording to show it.

With the information I of a column (the rig's parameters and the slack of the model's laws integrated out) a departure x of it
gives the score I x, and from there on detection is asked as the diagnosis itself asks (`hypotheses.weigh`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.hypotheses import LEAST, weigh
from ddh_twin_py.gap.linearised import Linearised

DETECTED = math.log(20.0)
"""Expected gain of log evidence over no effect from which an effect counts as detected."""
SIZES = {"faint": 2.2, "moderate": 5.0, "clear": 11.0}
"""Sizes by the rise of the worst signal, in multiples of its noise."""
_SMALLEST, _LARGEST = 1e-3, 1e3  # multiples of a column between which the smallest departure is looked for


@dataclass(frozen=True)
class Detection:
    """How one effect shows in a recording, by the way of it that shows least.

    Attributes:
        effect: id. unit: of the departures.
        smallest: departure that is detected, None where its bounds allow none.
        rise: of the worst signal there, in multiples of its noise. worst: that signal, empty where the effect moves none.
        gain: size (`SIZES`) to expected log evidence over no effect; None where the effect's bounds do not allow that size.
    """

    effect: str
    unit: str
    smallest: float | None
    rise: float | None
    worst: str
    gain: dict[str, float | None]

    def detects(self, size: str) -> bool | None:
        """Whether a size is detected, None where it is not possible."""
        return None if self.gain[size] is None else self.gain[size] >= DETECTED


def detection(linearised: Linearised, effect: Effect) -> Detection:
    """How an effect shows in a case, by the way of it that shows least."""
    ways = ways_of(linearised, effect.id)
    if not ways:
        return Detection(effect.id, effect.unit, None, None, "", dict.fromkeys(SIZES))
    smallest = {i: _smallest(linearised, i) for i in ways}
    within = [i for i in ways if smallest[i] is not None] or ways
    hardest = max(within, key=lambda i: (smallest[i] or 0.0) * linearised.columns[i].rise)
    column, found = linearised.columns[hardest], smallest[hardest]
    gain: dict[str, float | None] = {}
    for name, rise in SIZES.items():
        possible = [i for i in ways if rise <= linearised.columns[i].rise * linearised.columns[i].room]
        gain[name] = min((_gain(linearised, i, rise / linearised.columns[i].rise) for i in possible), default=None)
    return Detection(effect.id, effect.unit, None if found is None else found * column.x, None if found is None else found * column.rise,
                     column.worst, gain)


def ways_of(linearised: Linearised, effect: str) -> list[int]:
    """Columns of an effect that its bounds let stand out; all of them where none does."""
    every = [i for i, column in enumerate(linearised.columns) if column.effect.id == effect]
    possible = [i for i in every if linearised.columns[i].rise * linearised.columns[i].room >= SIZES["faint"]]
    return possible or every


def _gain(linearised: Linearised, column: int, departure: float) -> float:
    """Expected log evidence of a column that departs by so many multiples of it."""
    own = float(linearised.evidence.sums.information[column, column])
    return weigh(np.array([[own]]), np.array([own * departure]), np.array([linearised.columns[column].room]))[0]


def _smallest(linearised: Linearised, column: int) -> float | None:
    """Smallest departure, in multiples of a column, that is detected; None where none that is allowed is."""
    room = min(linearised.columns[column].room, _LARGEST)
    low, high = min(_SMALLEST, LEAST), room
    if _gain(linearised, column, high) < DETECTED:
        return None
    for _ in range(50):
        middle = math.sqrt(low * high)
        if _gain(linearised, column, middle) < DETECTED:
            low = middle
        else:
            high = middle
    return high
