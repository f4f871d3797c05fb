"""How far to go along a step whose direction stems from another place and may lead nowhere."""

from __future__ import annotations

import math

_LEAST, _HALF = 0.1, 0.5  # bounds of a length after one that gained nothing, as shares of it
_SHORTEST = 0.02  # of a full step
_WORTH, _SHORTER = 2.0, 0.35  # promise of a length from which a shorter one, that share of it, is tried though the slope points upward


class Lengths:
    """Lengths to try, one after another, until one gains.

    A parabola through the costs known so far says where its lowest point is (safeguarded interpolation, Nocedal and Wright,
    Numerical Optimization, 2nd ed., 3.5): first with the slope that the linear model promises, then with the slope that two lengths
    show. Where that points upward the direction gains at no length; but what sticks and comes free makes no parabola, and where much was
    promised a shorter length is tried all the same.

    Args:
        promised: what a full step gains by the linear model, so that the cost falls with twice that at its begin.

    Attributes:
        next: length to try, as a share of the full step; 0 where no further one is worth it.
    """

    def __init__(self, promised: float) -> None:
        self.next = 1.0
        self._promised = promised
        self._slope = -2.0 * promised
        self._last: tuple[float, float] | None = None

    def lost(self, cost: float) -> None:
        """The length just tried raised the cost by so much, or went astray (infinite)."""
        length = self.next
        if self._last is not None and math.isfinite(self._last[1]):
            before, rise = self._last[0], self._last[1] / self._last[0]
            self._slope = (cost / length * before - rise * length) / (before - length)
        self._last = length, cost
        if self._slope < 0.0:
            lowest = -0.5 * self._slope * length / (cost - self._slope * length)  # as a share of this length
            self.next = length * min(max(lowest, _LEAST), _HALF)
        else:
            self.next = _SHORTER * length if self._promised * length >= _WORTH else 0.0
        if self.next < _SHORTEST:
            self.next = 0.0
