"""Tells which temperature sensors do not move at all although their places must, as one that came off, of which only noise is left.

Such a sensor need not be far off, and its noise does not repeat itself: a filter takes its place for one without losses.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fusion.inputs import Readings
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.sensor_errors import temperature_noise

STILL = 1.5
"""Noises that the RMS of readings about their own mean may be, of a sensor that stands still."""
_MOVES = 10.0
"""Noises that the RMS of what the free run shows of its place is about its own mean, at least, if that moves."""


class StillWatch:
    """Follows the readings of each sensor, and what is shown of its place without it, from when the sensor last moved.

    Args:
        rig: the rig. least: readings that tell something.
    """

    def __init__(self, rig: Rig, least: int) -> None:
        self._noise, self._least = temperature_noise(rig), least
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget everything."""
        size = len(SENSORS)  # readings; of what was read and shown, less the first read, the sums, K, and the sums of squares, K^2
        self._count, self._first, self._farthest = np.zeros(size), np.zeros(size), np.zeros(size)
        self._sum, self._square = np.zeros((size, 2)), np.zeros((size, 2))

    def take(self, readings: Readings, shown: np.ndarray) -> None:
        """Take in readings, off the air, and what they should be, K, (r,), NaN where nothing says so."""
        known = np.isfinite(shown)
        sensor, read, shown = readings.sensor[known], readings.temperature[known], shown[known]
        new, at = np.unique(sensor, return_index=True)
        self._first[new] = np.where(self._count[new] == 0.0, read[at], self._first[new])
        both = np.column_stack([read, shown]) - self._first[sensor][:, None]
        np.add.at(self._count, sensor, 1.0)
        np.add.at(self._sum, sensor, both)
        np.add.at(self._square, sensor, both**2)
        np.maximum.at(self._farthest, sensor, np.abs(read - shown))
        moved = (self._count >= self._least) & (self._about_mean()[:, 0] > STILL * self._noise)
        for sums in (self._count, self._farthest, self._sum, self._square):
            sums[moved] = 0.0

    @property
    def still(self) -> dict[str, float]:
        """Sensors that have not moved while their places have, by far, and the farthest that each was off its place meanwhile, K."""
        moves = self._about_mean()[:, 1] > _MOVES * self._noise
        found = np.flatnonzero((self._count >= self._least) & moves & (self._noise > 0.0))
        return {SENSORS[k]: float(self._farthest[k]) for k in found}

    def _about_mean(self) -> np.ndarray:
        """RMS about their means of what was read and of what was shown, K, (m, 2)."""
        count = np.maximum(self._count, 1.0)[:, None]
        return np.sqrt(np.maximum(self._square / count - (self._sum / count) ** 2, 0.0))
