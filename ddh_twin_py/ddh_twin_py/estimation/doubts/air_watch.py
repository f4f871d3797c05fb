"""Tells while the twin runs that the sensors of the air and of a place are exchanged, in windows too short for a place to cross the air."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.doubts.out_of_place import AIR, LEAST, NEAR, OutOfPlace, look_exchanged_with_air, zero_unit
from ddh_twin_py.estimation.fusion.inputs import Readings
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.sensor_errors import temperature_zero_errors
from ddh_twin_py.twin.temperature_sensors import SENSORS

SHORT_WINDOW = 20.0
"""s of data in which that of the air is judged: no other place crosses it, as it does not warm with the load."""
LONGEST = 600.0
"""s for which slow sensors are waited for."""


class AirWatch:
    """Judges windows of the air's sensor and the others beside the free run.

    Args:
        rig: the rig. interval: s.

    Attributes:
        air: K, of which the air was when it was last told soundly, NaN before.
    """

    def __init__(self, rig: Rig, interval: float) -> None:
        self._rig, self._interval, self._zero = rig, interval, temperature_zero_errors(rig)[0]
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget everything."""
        self.air = np.nan
        self._near = np.zeros(len(SENSORS), bool)
        self.begin_window()

    def begin_window(self) -> None:
        """Judge only what comes from now on."""
        size = len(SENSORS)  # sums of squares, K^2, of what sensors are off their places and the air, and that of the air off all places
        self._off, self._of_air, self._of_place, self._air_off = np.zeros(size), np.zeros(size), np.zeros(size), 0.0
        self._air_count, self._count, self._air_sum, self._seconds = 0, np.zeros(size, np.int64), 0.0, 0.0

    def forget(self) -> None:
        """What sensors read in the last window says nothing now."""
        self._near[:] = False
        self.begin_window()

    def near(self, sensor: str) -> bool:
        """Whether a sensor read in the last window what the free run showed of its place."""
        return bool(self._near[SENSORS.index(sensor)])

    def take(self, seen: np.ndarray, readings: Readings, air: np.ndarray, gone: set[str]) -> OutOfPlace | None:
        """Take in n intervals; whether a sensor and that of the air are exchanged, once a window is full.

        Args:
            seen: K, what sensors would read of the free run, (n, m), NaN where it says nothing. readings: of these intervals, off the air.
            air: K, as read, (n,), NaN where not. gone: sensors that are left out.
        """
        if AIR in gone:
            air = np.full(len(seen), np.nan)
        known = np.isfinite(seen).all(axis=1)
        rows = np.flatnonzero(np.isfinite(air) & known)
        if np.isnan(self.air) and rows.size:
            self.air = float(np.median(air[rows]))
        read = readings.without(gone)
        read = read.where(known[read.index])
        np.add.at(self._off, read.sensor, (read.temperature - seen[read.index, read.sensor]) ** 2)
        np.add.at(self._of_air, read.sensor, (read.temperature - self.air - self._zero[read.sensor]) ** 2)
        np.add.at(self._count, read.sensor, 1)
        self._of_place += ((air[rows, None] - seen[rows]) ** 2).sum(axis=0)
        self._air_off += ((air[rows] - self.air) ** 2).sum()
        self._air_sum += air[rows].sum()
        self._air_count += rows.size
        self._seconds += known.sum() * self._interval
        waits = self._seconds < LONGEST and (0 < self._air_count < LEAST or np.any((self._count > 0) & (self._count < LEAST)))
        return None if self._seconds < SHORT_WINDOW or waits else self._judged()

    def _judged(self) -> OutOfPlace | None:
        count = np.where(self._count < LEAST, np.nan, self._count)
        own = self._air_count if self._air_count >= LEAST else np.nan
        off, air_off = np.sqrt(self._off / count), float(np.sqrt(self._air_off / own))
        found = look_exchanged_with_air(off, np.sqrt(self._of_place / own), np.sqrt(self._of_air / count), air_off, self._rig)
        unit = zero_unit(self._rig)
        self._near = off < NEAR * unit
        if air_off < NEAR * unit.max():  # as the day goes
            self.air = float(self._air_sum / own)
        self.begin_window()
        return found
