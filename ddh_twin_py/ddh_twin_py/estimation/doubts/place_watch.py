"""Tells while the twin runs which temperature sensors are out of place: by the free run's temperatures, and by what the filter bends."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.doubts.air_watch import LONGEST, AirWatch
from ddh_twin_py.estimation.doubts.out_of_place import LEAST, OutOfPlace, far_off_zero, few, filter_is_off, look_exchanged, stand_still
from ddh_twin_py.estimation.doubts.still_watch import StillWatch
from ddh_twin_py.estimation.fusion.credibility import Credibility
from ddh_twin_py.estimation.fusion.inputs import Readings
from ddh_twin_py.estimation.fusion.state import FusionState
from ddh_twin_py.estimation.fusion.temperature_filter import NEVER_READ
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.lagged_readings import LaggedReadings
from ddh_twin_py.twin.sensor_errors import sensor_lags, temperature_zero_errors
from ddh_twin_py.twin.temperature_sensors import SENSORS, all_sensed

WINDOW = 60.0
"""s of data that are judged by themselves: long enough that two places do not cross, short enough to see connectors that are exchanged."""
LASTING = 60.0
"""s for which a zero error must be far off, or a sensor stand still: a loose contact comes back sooner, and an exchange is told sooner."""

_AS_FAR = 0.5  # of what one that stands still is off its place, that another may be off its own, before it is the free run that is wrong


class PlaceWatch:
    """Judges windows of readings beside the free run, and how long a zero error has been far off.

    Args:
        rig: the rig. interval: s.

    Attributes:
        told: what was told since the begin, and is left out.
    """

    def __init__(self, rig: Rig, interval: float) -> None:
        self._rig, self._interval = rig, interval
        self._lagging = LaggedReadings(sensor_lags(rig))
        self._zero, self._top_share = temperature_zero_errors(rig)[0], rig["tank.top_share"]
        self._credibility, self._air, self._stands = Credibility(rig), AirWatch(rig, interval), StillWatch(rig, LEAST)
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget everything, as at another time or of another rig."""
        self.told: list[OutOfPlace] = []
        self._lagging.begin_anew()
        self._far, self._far_for = "", 0.0  # sensor whose zero is far off, and for how many s it has been
        self._held, self._jumped = np.full(len(SENSORS), np.nan), False  # K, zeros as held before, and whether the far one jumped there
        self._begun_for: set[str] = set()  # sensors for which the filter was told to begin anew
        self._air.begin_anew()
        self._stands.begin_anew()
        self._still_for = 0.0  # s for which one has stood still
        self._off = np.full(len(SENSORS), np.nan)  # K, RMS by which each was off its place in the last window
        self._begin_window()

    @property
    def air(self) -> float:
        """K, of which the air was when it was last told soundly, NaN before."""
        return self._air.air

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
        paired = {sensor for found in self.told if len(found.sensors) > 1 for sensor in found.sensors}
        read = np.full(len(free), np.nan) if air is None else air
        found = (self._air.take(seen, readings, read, gone) or self._exchanged(seen, readings, paired)
                 or self._with_its_partner(self._still(seen, readings.without(gone), state)
                                           or self._far_off(state, len(free) * self._interval)))
        if found is not None:
            if found.sensors:  # of two that are exchanged, one may have been told alone
                self.told = [one for one in self.told if not one.within(found)] + [found]
            self._far, self._far_for = "", 0.0
            self._begin_window()
            self._air.begin_window()
            self._stands.begin_anew()
            self._still_for = 0.0
        return found

    def _exchanged(self, seen: np.ndarray, readings: Readings, paired: set[str]) -> OutOfPlace | None:
        """``paired``: sensors that are told to be exchanged already."""
        read = readings.without(paired)
        read = read.where(np.isfinite(seen[read.index]).all(axis=1))
        np.add.at(self._square, read.sensor, (read.temperature[:, None] - seen[read.index]) ** 2)
        np.add.at(self._count, read.sensor, 1)
        self._seconds += np.isfinite(seen[:, 0]).sum() * self._interval
        waits = self._seconds < LONGEST and np.any((self._count > 0) & (self._count < LEAST))
        if self._seconds < WINDOW or waits:
            return None
        off = self._off_each()
        self._off = np.diagonal(off)
        self._begin_window()
        return look_exchanged(off, self._rig)

    def _off_each(self) -> np.ndarray:
        """K, RMS by which each sensor is off each place in the window so far, (m, m), NaN of those that were read too seldom in it."""
        return np.sqrt(np.where(self._count < LEAST, np.nan, self._square.T / np.maximum(self._count, 1)).T)

    def _with_its_partner(self, found: OutOfPlace | None) -> OutOfPlace | None:
        """One that was found by itself, with the one that it looks exchanged with in a window that is not at its end, as that one is
        believed otherwise."""
        both = look_exchanged(self._off_each(), self._rig) if found is not None and found.sensors else None
        return both if both is not None and found.within(both) else found

    def _still(self, seen: np.ndarray, readings: Readings, state: FusionState) -> OutOfPlace | None:
        """One that stands still; where the filter, which goes by what was measured, can believe that, the unit does not run as told, and
        where another sensor is far off its place, too, the free run does not show where the places are."""
        self._stands.take(readings, seen[readings.index, readings.sensor])
        off = self._stands.still
        others = [k for k, sensor in enumerate(SENSORS) if sensor not in off and np.isfinite(self._off[k])]
        shown = bool(off) and all(self._off[k] <= _AS_FAR * max(off.values()) for k in others)
        doubted = shown and bool(self._credibility.doubt(state))
        self._still_for = self._still_for + len(seen) * self._interval if doubted else 0.0
        if self._still_for <= LASTING:
            return None
        return next(iter(stand_still(off, np.count_nonzero(state.refused != NEVER_READ))), None)

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
        """One that is held far off its zero for long; once its reading has jumped there, as no place does, doubts about others that follow,
        since what it read before was believed, are not the unit's."""
        found, jump = far_off_zero(self._credibility.offset(state), self._rig), np.abs(state.offset - self._held)
        self._held = state.offset.copy()
        jumped = found is not None and self._far == found.sensors[0] and self._jumped
        if found is not None and not jumped and self._credibility.doubted(state) > few(np.count_nonzero(state.refused != NEVER_READ)):
            found = None
        if found is None or found.sensors[0] != self._far:
            self._far, self._far_for = found.sensors[0] if found else "", 0.0
            self._jumped = found is not None and bool(jump[SENSORS.index(self._far)] > 0.5 * abs(found.off))
            if found is not None:
                self._air.forget()
            return None
        if self._air.near(found.sensors[0]) and found.sensors[0] not in self._begun_for:
            self._begun_for.add(found.sensors[0])
            return filter_is_off(found)
        self._far_for += seconds
        return found if self._far_for > LASTING else None
