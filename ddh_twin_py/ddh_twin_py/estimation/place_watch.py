"""Tells while the twin runs which temperature sensors are out of place: by the free run's temperatures, and by what the filter bends."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.credibility import Credibility
from ddh_twin_py.estimation.out_of_place import (
    AIR,
    LEAST,
    NEAR,
    OutOfPlace,
    far_off_zero,
    few,
    filter_is_off,
    look_exchanged,
    look_exchanged_with_air,
    zero_unit,
)
from ddh_twin_py.estimation.temperature_filter import NEVER_READ
from ddh_twin_py.estimation.temperature_fusion import FusionState, Readings
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.lagged_readings import LaggedReadings
from ddh_twin_py.twin.sensor_errors import sensor_lags, temperature_zero_errors
from ddh_twin_py.twin.temperature_sensors import SENSORS, all_sensed

WINDOW = 60.0
"""s of data that are judged by themselves: long enough that two places do not cross, short enough to see connectors that are exchanged."""
_LONGEST = 600.0  # s for which slow sensors are waited for
SHORT_WINDOW = 20.0
"""s of data in which that of the air is judged: no other place crosses it, as it does not warm with the load."""
LASTING = 60.0
"""s for which a zero error must be far off: a loose contact comes back sooner."""


class PlaceWatch:
    """Judges windows of readings beside the free run, and how long a zero error has been far off.

    Args:
        rig: the rig. interval: s.

    Attributes:
        told: what was told since the begin, and is left out. air: K, of which the air was when it was last told soundly, NaN before.
    """

    def __init__(self, rig: Rig, interval: float) -> None:
        self._rig, self._interval = rig, interval
        self._lagging = LaggedReadings(sensor_lags(rig))
        self._zero, self._top_share = temperature_zero_errors(rig)[0], rig["tank.top_share"]
        self._credibility = Credibility(rig)
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget everything, as at another time or of another rig."""
        self.told: list[OutOfPlace] = []
        self._lagging.begin_anew()
        self._far, self._far_for = "", 0.0  # sensor whose zero is far off, and for how many s it has been
        self.air = np.nan
        self._near = np.zeros(len(SENSORS), bool)  # whether sensors read what the free run showed of their places, in the last short window
        self._begun_for: set[str] = set()  # sensors for which the filter was told to begin anew
        self._begin_window()
        self._begin_short()

    def _begin_short(self) -> None:
        """Squares, K^2, of what sensors are off their places and the air, and that of the air off all places, and off itself."""
        size = len(SENSORS)
        self._off, self._of_air, self._of_place, self._air_off = np.zeros(size), np.zeros(size), np.zeros(size), 0.0
        self._air_count, self._counted, self._air_sum, self._short = 0, np.zeros(size, np.int64), 0.0, 0.0

    def _begin_window(self) -> None:
        size = len(SENSORS)
        self._square, self._count, self._seconds = np.zeros((size, size)), np.zeros(size, np.int64), 0.0

    def take(self, free: np.ndarray, readings: Readings, state: FusionState, air: np.ndarray | None = None) -> OutOfPlace | None:
        """Take in n intervals; the sensors that are now told to be out of place, None where there are none; by no sensor, that it is the
        filter that is wrong, as the free run shows what a sensor reads that it holds far off, once for each sensor.

        Args:
            free: K, temperatures of the free run, (n, N), NaN where it says nothing. readings: of these intervals, off the air.
            state: of the filter, after them. air: K, as read, (n,), NaN where not; None: nobody does.
        """
        seen, gone = self._seen(free), {sensor for found in self.told for sensor in found.sensors}
        if air is None or AIR in gone:
            air = np.full(len(free), np.nan)
        found = (self._exchanged_with_air(seen, readings, air, gone) or self._exchanged(seen, readings, gone)
                 or self._far_off(state, len(free) * self._interval))
        if found is not None:
            if found.sensors:
                self.told.append(found)
            self._far, self._far_for = "", 0.0
            self._begin_window()
            self._begin_short()
        return found

    def _exchanged_with_air(self, seen: np.ndarray, readings: Readings, air: np.ndarray, gone: set[str]) -> OutOfPlace | None:
        known = np.isfinite(seen).all(axis=1)
        rows = np.flatnonzero(np.isfinite(air) & known)
        if np.isnan(self.air) and rows.size:
            self.air = float(np.median(air[rows]))
        told = known[readings.index] & ~np.isin(np.array(SENSORS)[readings.sensor], list(gone))
        index, sensor, temperature = readings.index[told], readings.sensor[told], readings.temperature[told]
        np.add.at(self._off, sensor, (temperature - seen[index, sensor]) ** 2)
        np.add.at(self._of_air, sensor, (temperature - self.air - self._zero[sensor]) ** 2)
        np.add.at(self._counted, sensor, 1)
        self._of_place += ((air[rows, None] - seen[rows]) ** 2).sum(axis=0)
        self._air_off += ((air[rows] - self.air) ** 2).sum()
        self._air_sum += air[rows].sum()
        self._air_count += rows.size
        self._short += known.sum() * self._interval
        waits = self._short < _LONGEST and (0 < self._air_count < LEAST or np.any((self._counted > 0) & (self._counted < LEAST)))
        if self._short < SHORT_WINDOW or waits:
            return None
        count = np.where(self._counted < LEAST, np.nan, self._counted)
        own = self._air_count if self._air_count >= LEAST else np.nan
        off, air_off = np.sqrt(self._off / count), float(np.sqrt(self._air_off / own))
        found = look_exchanged_with_air(off, np.sqrt(self._of_place / own), np.sqrt(self._of_air / count), air_off, self._rig)
        self._near = off < NEAR * zero_unit(self._rig)
        if air_off < NEAR * zero_unit(self._rig).max():  # as the day goes
            self.air = float(self._air_sum / own)
        self._begin_short()
        return found

    def _exchanged(self, seen: np.ndarray, readings: Readings, gone: set[str]) -> OutOfPlace | None:
        told = np.isfinite(seen[readings.index]).all(axis=1) & ~np.isin(np.array(SENSORS)[readings.sensor], list(gone))
        index, sensor = readings.index[told], readings.sensor[told]
        np.add.at(self._square, sensor, (readings.temperature[told, None] - seen[index]) ** 2)
        np.add.at(self._count, sensor, 1)
        self._seconds += np.isfinite(seen[:, 0]).sum() * self._interval
        waits = self._seconds < _LONGEST and np.any((self._count > 0) & (self._count < LEAST))
        if self._seconds < WINDOW or waits:
            return None
        mean = np.where(self._count < LEAST, np.nan, self._square.T / np.maximum(self._count, 1)).T
        self._begin_window()
        return look_exchanged(np.sqrt(mean), self._rig)

    def _seen(self, free: np.ndarray) -> np.ndarray:
        """What sensors would read of the free run, K, (n, m), NaN where it says nothing."""
        place = all_sensed(free, self._top_share)
        seen = np.full(place.shape, np.nan)
        known = np.isfinite(place).all(axis=1)
        edges = np.flatnonzero(np.diff(known, prepend=False, append=False))
        for first, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            if first > 0:
                self._lagging.begin_anew()
            seen[first:stop] = self._lagging.follow(place[first:stop], self._interval)
        if known.size and not known[-1]:
            self._lagging.begin_anew()
        return seen + self._zero

    def _far_off(self, state: FusionState, seconds: float) -> OutOfPlace | None:
        found = far_off_zero(self._credibility.offset(state), self._rig)
        if found is not None and self._credibility.doubted(state) > few(np.count_nonzero(state.refused != NEVER_READ)):
            found = None
        if found is None or found.sensors[0] != self._far:
            self._far, self._far_for = found.sensors[0] if found else "", 0.0
            if found is not None:  # what it read before says nothing
                self._near[:] = False
                self._begin_short()
            return None
        if found is not None and self._near[SENSORS.index(found.sensors[0])] and found.sensors[0] not in self._begun_for:
            self._begun_for.add(found.sensors[0])
            return filter_is_off(found)
        self._far_for += seconds
        return found if self._far_for > LASTING else None
