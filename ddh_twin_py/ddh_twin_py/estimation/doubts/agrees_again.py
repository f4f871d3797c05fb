"""When a sensor that was left out is used again: it has agreed for a while with what is fused without it.

What made it look wrong may be over, as a drive that told ten times its current or connectors that were put right. A broken sensor that
crosses the estimate agrees for a moment only: it must follow the estimate as closely as a sound one, for as long as it takes, and twice as
long where it was left out again.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from ddh_twin_py.estimation.doubts.out_of_place import AIR, LEAST, NEAR, OutOfPlace, zero_unit
from ddh_twin_py.estimation.doubts.still_watch import STILL
from ddh_twin_py.estimation.fusion.inputs import Readings
from ddh_twin_py.estimation.fusion.result import FusionResult
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.sensor_errors import temperature_noise, temperature_zero_errors

AGREES = 120.0
"""s for which sensors must agree, times how often they were left out."""
_SILENT = 60.0  # s without a reading, after which a sensor has to agree from the beginning
_WITHIN = 2.0  # standard deviations of the estimate within which a sensor agrees, and of which what it was off must be more
_NEARER = 0.5  # of what it was off


class AgreesAgain:
    """Follows sensors that are left out.

    Args:
        rig: the rig. interval: s.
    """

    def __init__(self, rig: Rig, interval: float) -> None:
        self._interval, self._unit, self._zero = interval, zero_unit(rig), temperature_zero_errors(rig)[0]
        self._noise = temperature_noise(rig)
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget everything."""
        self._followed: dict[OutOfPlace, _Agreement] = {}
        self._times: Counter[tuple[str, ...]] = Counter()

    def follow(self, found: OutOfPlace) -> None:
        """These sensors are left out from now on; one of them that was followed alone comes back with the other."""
        self._followed = {one: agreement for one, agreement in self._followed.items() if not one.within(found)}
        self._times[found.sensors] += 1
        self._followed[found] = _Agreement()

    def take(self, readings: Readings, air_read: np.ndarray, result: FusionResult) -> list[OutOfPlace]:
        """Those who have agreed for long enough, after n intervals; they are followed no more.

        Args:
            readings: of these intervals, off the air. air_read: K, as read, (n,), NaN where not. result: what was fused meanwhile.
        """
        back = [found for found, agreement in self._followed.items() if self._agrees(found, agreement, readings, air_read, result)]
        for found in back:
            del self._followed[found]
        return back

    def _agrees(self, found: OutOfPlace, agreement: _Agreement, readings: Readings, air_read: np.ndarray, result: FusionResult) -> bool:
        off, expected, sure, reads = [], [], [], []
        for sensor in found.sensors:
            if sensor == AIR:
                read, at, place, spread = air_read[np.isfinite(air_read)], np.isfinite(air_read), result.ambient, self._unit.max()
            else:
                k = SENSORS.index(sensor)
                here = readings.sensor == k
                read, at, place = readings.temperature[here], readings.index[here], result.reading[:, k] + self._zero[k]
                spread = np.hypot(result.reading_standard_deviation[k], self._unit[k])
            off.append(read - place[at])
            expected.append(place.mean())
            sure.append(spread)
            reads.append(read)
        was_off = np.ptp(expected) if len(expected) > 1 else abs(found.off)
        if any(np.any(np.abs(one) > min(_WITHIN * spread, _NEARER * was_off)) for one, spread in zip(off, sure, strict=True)):
            agreement.begin()
        elif was_off > _WITHIN * max(sure):  # else it would seem to agree as it is
            agreement.passes(len(air_read) * self._interval)
            if any(read.size for read in reads):
                agreement.add(off, reads)
        if agreement.seconds < AGREES * self._times[found.sensors] or agreement.fewest < LEAST:
            return False
        closely = agreement.off() <= NEAR * self._unit.max() and not (found.still and self._stands_still(found, agreement))
        if not closely:
            agreement.forget_oldest()
        return closely

    def _stands_still(self, found: OutOfPlace, agreement: _Agreement) -> bool:
        """Whether a sensor that was told to stand still does so yet, as where its place has come to it."""
        return agreement.moved() <= STILL * self._noise[SENSORS.index(found.sensors[0])]


class _Agreement:
    """What sensors read and were off while they agreed: of each the K, and for how many s in all."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """They agree no more."""
        self._off: list[list[np.ndarray]] = []
        self._read: list[list[np.ndarray]] = []
        self._seconds: list[float] = []
        self._heard: set[int] = set()  # those that were read since
        self._since = 0.0  # s since the last readings of all

    def passes(self, seconds: float) -> None:
        """So many s went by; a silence is no agreement."""
        self._since += seconds
        if self._since > _SILENT:
            self.begin()

    def add(self, off: list[np.ndarray], read: list[np.ndarray]) -> None:
        """Some of them were read, and all agreed since all were read before."""
        if not self._off:
            self._since = 0.0
        self._heard |= {k for k, one in enumerate(read) if one.size}
        all_heard = len(self._heard) == len(read)
        self._seconds.append(self._since if all_heard else 0.0)
        self._off.append(off)
        self._read.append(read)
        if all_heard:
            self._heard, self._since = set(), 0.0

    def forget_oldest(self) -> None:
        """Go on without the first sixth: what is fused took its time to settle."""
        sixth = len(self._off) // 6 + 1
        del self._off[:sixth], self._read[:sixth], self._seconds[:sixth]

    @property
    def seconds(self) -> float:
        """In all."""
        return sum(self._seconds)

    @property
    def fewest(self) -> int:
        """Readings of the sensor that has the fewest."""
        return min((sum(map(len, column)) for column in zip(*self._off, strict=True)), default=0)

    def off(self) -> float:
        """RMS of what they were off, K, of the sensor of which it is the largest."""
        return max(float(np.sqrt(np.mean(np.concatenate(column) ** 2))) for column in zip(*self._off, strict=True))

    def moved(self) -> float:
        """RMS of what the first of them read about its mean, K."""
        return float(np.concatenate([read[0] for read in self._read]).std())
