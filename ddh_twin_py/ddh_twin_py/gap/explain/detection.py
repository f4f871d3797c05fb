"""How large an effect must be for a recording to show it.

With the information I of a column (the rig's parameters and the slack of the model's laws integrated out) a departure x of it
gives the score I x, and from there on detection is asked as the diagnosis itself asks (`hypotheses.weigh`). A law may bend between
that departure and the one that its column was taken at: a valve shows nothing until it opens. So a run is made with the departure,
and where signals rise less than the column says, a larger one is sought.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.evidence.hypotheses import LEAST, weigh
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import Column, rise_of

DETECTED = math.log(20.0)
"""Expected gain of log evidence over no effect from which an effect counts as detected."""
SIZES = {"faint": 2.2, "moderate": 5.0, "clear": 11.0}
"""Sizes by the rise of the worst signal, in multiples of its noise."""
_SMALLEST, _LARGEST = 1e-3, 1e3  # multiples of a column between which the smallest departure is looked for
_CONFIRMED, _ATTEMPTS = 0.5, 6  # share of the rise promised by a column that a run must show; runs to find where it does

RiseAt = Callable[[Effect, int, float], float]
"""Rise of the worst signal, in multiples of its noise, where an effect acts by one of its laws with a departure."""


@dataclass(frozen=True)
class Detection:
    """How one effect shows in a recording, by the way of it that shows least.

    Attributes:
        effect: id. unit: of the departures.
        smallest: departure that is detected, None where its bounds allow none.
        rise: of the worst signal there, in multiples of its noise. worst: that signal, empty where the effect moves none.
        nominal: value of its quantity without the effect. beyond: whether machines never reach that departure, see `Effect.reached`.
        gain: size (`SIZES`) to expected log evidence over no effect; None where the effect's bounds do not allow that size.
    """

    effect: str
    unit: str
    smallest: float | None
    rise: float | None
    worst: str
    gain: dict[str, float | None]
    nominal: float = 0.0
    beyond: bool = False

    def detects(self, size: str) -> bool | None:
        """Whether a size is detected, None where it is not possible."""
        return None if self.gain[size] is None else self.gain[size] >= DETECTED


def detections(linearised: Linearised, effects: Sequence[Effect], pool: ThreadPoolExecutor) -> list[Detection]:
    """How effects show in a case, each by the way of it that shows least."""
    model = linearised.model
    altered = [i for i, acts in enumerate(model.altered) if acts]
    signals = [model.signals[i] for i in altered]
    base = [model.run_one(i, linearised.theta, (), roughly=True) for i in altered]

    def rise_at(effect: Effect, law: int, x: float) -> float:
        acted = [model.run_one(i, linearised.theta, [(effect, law, x)], roughly=True) for i in altered]
        return rise_of(signals, acted, base, model.witnesses.amplified)[0]

    return list(pool.map(lambda effect: detection(linearised, effect, rise_at), effects))


def detection(linearised: Linearised, effect: Effect, rise_at: RiseAt) -> Detection:
    """How an effect shows in a case, by the way of it that shows least; of one known for growing by the ways in which it grows."""
    ways = ways_of(linearised, effect.id)
    ways = [i for i in ways if effect.grows and linearised.columns[i].x > 0.0] or ways
    if not ways:
        return Detection(effect.id, effect.unit, None, None, "", dict.fromkeys(SIZES))
    smallest = {i: _smallest(linearised, i) for i in ways}
    within = [i for i in ways if smallest[i] is not None] or ways
    hardest = max(within, key=lambda i: (_beyond(linearised.columns[i], smallest[i]), (smallest[i] or 0.0) * linearised.columns[i].rise))
    column, found = linearised.columns[hardest], smallest[hardest]
    rise = None if found is None else found * column.rise
    found = None if found is None else _confirmed(lambda share: rise_at(effect, column.law, share * column.x), found, rise)
    gain: dict[str, float | None] = {}
    for name, size in SIZES.items():
        possible = [i for i in ways if size <= linearised.columns[i].rise * linearised.columns[i].room]
        gain[name] = min((_gain(linearised, i, size / linearised.columns[i].rise) for i in possible), default=None)
    model = linearised.model
    nominal = effect.reference(model.record(model.altered.index(True), linearised.theta))
    return Detection(effect.id, effect.unit, None if found is None else found * column.x, rise, column.worst, gain, nominal,
                     _beyond(column, found))


def ways_of(linearised: Linearised, effect: str) -> list[int]:
    """Columns of an effect that its bounds let stand out; all of them where none does."""
    every = [i for i, column in enumerate(linearised.columns) if column.effect.id == effect]
    possible = [i for i in every if linearised.columns[i].rise * linearised.columns[i].room >= SIZES["faint"]]
    return possible or every


def _beyond(column: Column, found: float | None) -> bool:
    """Whether a departure, in multiples of a column, is one that machines never reach."""
    low, high = column.effect.reached
    return found is not None and not low <= found * column.x <= high


def _confirmed(rise_at: Callable[[float], float], found: float, wanted: float) -> float:
    """The least departure from ``found`` to the column's own at which a run rises as the column promised ``found`` would.

    Args:
        rise_at: rise at a departure. found: departure; all in multiples of the column. wanted: rise, in multiples of noise.
    """
    if found >= 1.0 or rise_at(found) >= _CONFIRMED * wanted:
        return found
    low, high = found, 1.0
    for _ in range(_ATTEMPTS):
        middle = math.sqrt(low * high)
        if rise_at(middle) < wanted:
            low = middle
        else:
            high = middle
    return high


def _gain(linearised: Linearised, column: int, departure: float) -> float:
    """Expected log evidence of a column that departs by so many multiples of it."""
    own = float(linearised.evidence.sums.information[column, column])
    return weigh(np.array([[own]]), np.array([own * departure]), np.array([linearised.columns[column].room]),
                 linearised.question.widths)[0]


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
