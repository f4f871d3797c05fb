"""A model that missed what drives it, as a process that was stopped for a while, lacks the heat of that time and takes up what is fused.

What is fused needs some seconds itself until it knows again how warm the unit is; for so long the model follows it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_twin_py.estimation.fusion.start import UNDRIVEN, Undriven

MISSED = 5.0
"""s without what drives a model after which it lacks heat that is worth a word."""
FROM, FOLLOWS = 5.0, 20.0
"""s after which, and until which, it then is as warm as what is fused says, as far as that is known."""
_GIVEN_UP = 60.0  # s after which nothing is fused any more


class CatchUp:
    """Brings a model's temperatures back to fused ones, which may be told later than the model has run.

    Args:
        interval: s.
    """

    def __init__(self, interval: float) -> None:
        self._interval = interval
        self._undriven = Undriven(round(MISSED / interval))
        self._was_driven = False
        self._from = 0  # ns
        self._until: int | None = None  # ns, None while it follows nothing
        self._ends: list[int] = []  # ns, since it follows
        self._temperatures: list[np.ndarray] = []  # K, (models, N) at each

    def missed(self, driven: np.ndarray) -> list[tuple[int, float]]:
        """With which of n intervals that follow those before, bool (n,), it is driven again, and after how many s.

        These are `MISSED` or more; after `UNDRIVEN` nothing is to be followed, as readings tell anew how warm the unit is.
        What drives it must have been known before: a model that waits for its telemetry misses nothing.
        """
        rows = [(row, missed * self._interval) for row, missed in self._undriven.again(driven)
                if missed < round(UNDRIVEN / self._interval) and (self._was_driven or driven[:row].any())]
        self._was_driven |= bool(driven.any())
        return rows

    def begin(self, end_ns: int) -> None:
        """It is driven again in the interval that ends at this stamp, ns, and is to follow what is fused."""
        self._from, self._until = (end_ns + round((after - self._interval) * 1e9) for after in (FROM, FOLLOWS))
        self._ends, self._temperatures = [], []

    def ran(self, end_ns: int, temperatures: Sequence[np.ndarray]) -> None:
        """The model has run up to a stamp, ns, and is as warm as this now, K, (N,) each."""
        if self._until is None:
            return
        self._ends.append(end_ns)
        self._temperatures.append(np.array(temperatures))
        if end_ns > self._until + round(_GIVEN_UP * 1e9):
            self._stop()

    def take_up(self, stamp: int, fused: np.ndarray, deviation: np.ndarray, temperatures: Sequence[np.ndarray]) -> None:
        """Move a model's temperatures, K, (N,) each, in place, by what they were off fused ones that were told of a stamp, ns.

        Args:
            fused, deviation: K, (N,), and their standard deviations.
        """
        if self._until is None or not self._ends or stamp < max(self._from, self._ends[0]):
            return
        after = min(int(np.searchsorted(self._ends, stamp)), len(self._ends) - 1)
        before = max(after - 1, 0)
        span = self._ends[after] - self._ends[before]
        share = min((stamp - self._ends[before]) / span, 1.0) if span else 1.0
        then = self._temperatures[before] + share * (self._temperatures[after] - self._temperatures[before])
        off = _told(fused - then, deviation)
        for temperature, by in zip(temperatures, off, strict=True):
            temperature += by
        self._temperatures = [row + off for row in self._temperatures]
        if stamp >= self._until:
            self._stop()

    def _stop(self) -> None:
        self._until, self._ends, self._temperatures = None, [], []


def _told(off: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """What of differences, K, is likely more than what fused temperatures may be off themselves, of such standard deviations, (N,) each.

    James & Stein, Estimation with quadratic loss, Proc. 4th Berkeley Symp. 1 (1961), its positive part, of each node by itself.
    """
    square = off * off
    return np.where(square > deviation**2, off - deviation**2 / np.where(square > 0.0, off, 1.0), 0.0)
