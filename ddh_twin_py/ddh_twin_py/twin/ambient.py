"""The air around the unit: readings smoothed, held between them."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.twin.intervals import INTERVAL

AMBIENT_LAG = 10.0
"""s over which ambient readings are smoothed."""
MOST_OFF = 1.0
"""K by which the smoothed air may be off all of the last three readings, ten times a sensor's noise: a gate that opens is not smoothed."""


class AmbientTracker:
    """Air temperature interval by interval.

    Args:
        assumed: K, what holds until the first reading. interval: s.

    Attributes:
        value: K, now. known: whether any reading came.
    """

    def __init__(self, assumed: float, interval: float = INTERVAL) -> None:
        self.value = assumed
        self.known = False
        self._read = assumed
        self._last = [assumed] * 3  # K, read
        self._share = 1.0 - np.exp(-interval / AMBIENT_LAG)

    def advance(self, read: np.ndarray) -> np.ndarray:
        """Air of each interval, K, (n,), from the readings made in them, K, (n,), NaN where none."""
        air = np.empty(read.size)
        for i, reading in enumerate(read):
            if reading == reading:  # not NaN
                self._read = float(reading)
                if not self.known:
                    self.hold(self._read, True)
                self._last = [*self._last[1:], self._read]
            self.value += self._share * (self._read - self.value)
            self.value = min(max(self.value, min(self._last) - MOST_OFF), max(self._last) + MOST_OFF)
            air[i] = self.value
        return air

    def hold(self, value: float, known: bool) -> None:
        """Take up a value from elsewhere, K."""
        self.value = self._read = value
        self._last = [value] * 3
        self.known = known
