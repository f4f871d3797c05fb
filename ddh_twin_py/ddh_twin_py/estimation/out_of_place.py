"""Temperature sensors that cannot be where they are said to be: two that read each other's places, or one far off its zero.

A filter bends until such readings fit, and then states small uncertainties of what it fused. So they are left out once they are told:
what is fused rests on the models and the other sensors, and its uncertainty says so.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ddh_twin_py.estimation.credibility import FARTHEST_OFFSET
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.estimation.still_watch import StillWatch
from ddh_twin_py.estimation.temperature_fusion import Readings
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX
from ddh_twin_py.twin.sensor_errors import temperature_noise

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from ddh_twin_py.estimation.replay import ReplayResult, SensorComparison

FAR_OFF = 2.0 * FARTHEST_OFFSET
"""Standard deviations of its zero error by which a sensor is held off, from which nothing near it is believed."""
LEAST = 20
"""Readings that tell something."""
_FAR, NEAR = 10.0, 3.0
"""Noises and zero errors together: off its own place, and as near as it must be to the other's."""
AIR = "ambient"
"""The sensor of the air, which the network does not know."""
_AT_ONCE = 100  # intervals that are held against the free run at once
_AS_IT_WARMS = 1.0 / 3.0  # of what an exchanged sensor of the air is off the air, that it may be off the place that it reads


@dataclass(frozen=True)
class OutOfPlace:
    """Sensors that are told to be out of place, by name, and why, in a line; K by which a single one is off, whether it stands still."""

    sensors: tuple[str, ...]
    why: str
    off: float = 0.0
    still: bool = False

    @property
    def topics(self) -> str:
        """Relative topics of the sensors, in words."""
        return " and ".join(TEMPERATURE_PREFIX + sensor for sensor in self.sensors)

    def within(self, other: OutOfPlace) -> bool:
        """Whether all its sensors are among another's."""
        return set(self.sensors) <= set(other.sensors)

    @property
    def left_out(self) -> str:
        """Why, and that they are left out; of no sensor, that the estimate begins anew."""
        if not self.sensors:
            return f"{self.why}; the estimate begins anew"
        used = "neither is used" if len(self.sensors) > 1 else "it is not used"
        return f"{self.why}; {used}: what is fused is of the models and the other sensors"


def out_of_place(result: ReplayResult) -> str:
    """Which sensors these are, and what that means for what is fused, in one line; '' where none is."""
    said = [found.left_out for found in result.left_out]
    if pair := _pair(result):
        said.append(f"{pair.why}; what is fused of both may be off by more than is stated")
    elif result.zero_error is not None and abs(result.zero_error[1]) > FAR_OFF:
        said.append(f"{_far(result.zero_error)}; what is fused near it may be off by more than is stated")
    return "; ".join(said)


def without_those_out_of_place(run: Callable[[frozenset[str]], ReplayResult], without: Collection[str]) -> ReplayResult:
    """A replay without the sensors that it tells to be out of place.

    Two that look exchanged are left out at once. Those that stand still are where what is fused without them moves as the free run does,
    as on a unit that was told to move and did not. One that is far off its zero is where what is left then agrees: if more than `few` are,
    or another is in doubt yet, the unit is not what the twin takes it for, and all are used.

    Args:
        run: makes a replay without these sensors. without: sensors that are not used anyway.
    """
    unseen = frozenset(without)
    result = run(unseen)
    while (found := _pair(result)) is not None and not unseen.issuperset(found.sensors):
        unseen = unseen.union(found.sensors)
        result = replace(run(unseen), left_out=(*result.left_out, found))
    if still := _still(result):
        gone = unseen.union(*(found.sensors for found in still))
        tried = replace(run(gone), left_out=(*result.left_out, *still))
        if gone == unseen.union(*(found.sensors for found in _still(tried, fused=True))):
            result, unseen = tried, gone
    tried = result
    for _ in range(few(sum(sensor.used for sensor in result.sensors.values()))):
        found = far_off_zero(tried.zero_error, tried.rig) if tried.zero_error is not None else None
        if found is None or unseen.issuperset(found.sensors):
            break
        unseen = unseen.union(found.sensors)
        tried = replace(run(unseen), left_out=(*tried.left_out, found))
    return tried if tried.zero_error is not None and abs(tried.zero_error[1]) <= FARTHEST_OFFSET else result


def few(read: int) -> int:
    """Of so many sensors that are read, how many may be far off their zeros before it is the unit that is not what it is taken for."""
    return max(1, read // 4)


def _pair(result: ReplayResult) -> OutOfPlace | None:
    """Two that look exchanged and are not left out yet."""
    gone = {sensor for found in result.left_out for sensor in found.sensors}
    off = np.full((len(SENSORS), len(SENSORS)), np.nan)
    for one, two in itertools.product([name for name in result.sensors if name not in gone], repeat=2):
        off[SENSORS.index(one), SENSORS.index(two)] = _off(result.sensors[one], result.sensors[two])
    return look_exchanged(off, result.rig)


def stand_still(off: Mapping[str, float], read: int) -> list[OutOfPlace]:
    """Sensors that do not move while their places do, and how far each was off meanwhile, K, of so many that are read; none where they are
    more than `few`."""
    if len(off) > few(read):
        return []
    why = "stands still while its place must move, and was up to {:.1f} K off it meanwhile"
    return [OutOfPlace((sensor,), f"{TEMPERATURE_PREFIX}{sensor} {why.format(k)}", k, still=True) for sensor, k in off.items()]


def _still(result: ReplayResult, fused: bool = False) -> list[OutOfPlace]:
    """Those that do not move where the free run, or what is fused without them, says that they must."""
    read = {name: sensor for name, sensor in result.sensors.items() if sensor.used != fused}
    if not read:
        return []
    of = np.concatenate([np.full(sensor.row.size, SENSORS.index(name)) for name, sensor in read.items()])
    row, measured, shown = (np.concatenate([getattr(sensor, name) for sensor in read.values()])
                            for name in ("row", "measured", "fused" if fused else "predicted"))
    order = np.argsort(row, kind="stable")
    order = order[np.isfinite(measured[order])]
    watch, found = StillWatch(result.rig, LEAST), {}
    for part in np.split(order, np.searchsorted(row[order], np.arange(_AT_ONCE, len(result.time), _AT_ONCE))):
        watch.take(Readings(row[part], of[part], measured[part]), shown[part])
        found.update(watch.still)
    return stand_still(found, len(result.sensors))


def far_off_zero(zero_error: tuple[str, float, float], rig: Rig) -> OutOfPlace | None:
    """A sensor that is `FAR_OFF` its zero, of what `Credibility.offset` says; None where it is not.

    It must be as far off by the sheet's tolerance, too: a calibrated sensor's own is narrower, and less than that is harmless.
    """
    sensor, off, zero = zero_error
    least = FAR_OFF * rig.sensors["temperature"].offset_tolerance
    return OutOfPlace((sensor,), _far(zero_error), zero) if abs(off) > FAR_OFF and abs(zero - rig.zero_error(sensor)[0]) > least else None


def filter_is_off(held: OutOfPlace) -> OutOfPlace:
    """Of a sensor that is held far off its zero and reads what the free run shows of its place: the estimate is wrong, not the sensor."""
    return OutOfPlace((), f"{held.why}, and reads what the free run shows there")


def _far(zero_error: tuple[str, float, float]) -> str:
    sensor, off, zero = zero_error
    return f"{TEMPERATURE_PREFIX}{sensor} is held to read {zero:+.1f} K off, {abs(off):.0f} standard deviations of its zero error"


def look_exchanged(off: np.ndarray, rig: Rig) -> OutOfPlace | None:
    """The two sensors that are far off what the free run shows of their own places, and near what it shows of each other's.

    Args:
        off: K, RMS by which each of `SENSORS` (row) is off what the free run shows at the place of each (column), (m, m), NaN where too
            little tells.
    """
    unit = zero_unit(rig)
    own = np.diagonal(off) / unit
    near = off < NEAR * unit[:, None]
    for one, two in itertools.combinations(np.flatnonzero(own > _FAR).tolist(), 2):
        if near[one, two] and near[two, one]:
            return _exchanged(SENSORS[one], SENSORS[two], "what the free run shows of the other")
    return None


def look_exchanged_with_air(off: np.ndarray, of_place: np.ndarray, of_air: np.ndarray, air: float, rig: Rig) -> OutOfPlace | None:
    """The sensor that stays as cool as the air was while its place warms, where that of the air warms as this place does.

    No load warms the air. How warm it is the sensors tell at a begin, not the free run, so that one of the two is held against that.

    Args:
        off: K, RMS by which each of `SENSORS` is off what the free run shows of its place, (m,), NaN where too little tells. of_place: the
            same of the air's sensor. of_air: by which each is off the air, and air: by which the air's sensor is.
    """
    unit = zero_unit(rig)
    if not air > _FAR * unit.max():
        return None
    like = (off > _FAR * unit) & (of_air < NEAR * unit) & (of_place < _AS_IT_WARMS * air)
    k = int(np.argmin(np.where(like, of_place, np.inf)))
    return _exchanged(AIR, SENSORS[k], "what the other must") if like[k] else None


def zero_unit(rig: Rig) -> np.ndarray:
    """Noise and tolerance of the zero of each of `SENSORS` together, K, (m,)."""
    unit = np.hypot(temperature_noise(rig), rig.sensors["temperature"].offset_tolerance)
    return np.where(unit > 0.0, unit, np.inf)


def _exchanged(one: str, two: str, reads: str) -> OutOfPlace:
    return OutOfPlace((one, two), f"{TEMPERATURE_PREFIX}{one} and {TEMPERATURE_PREFIX}{two} look exchanged, as each reads {reads}")


def _off(read: SensorComparison, of: SensorComparison) -> float:
    """RMS, K, by which a reading is off what the free run shows at a place, NaN where too little tells."""
    order = np.argsort(of.time, kind="stable")
    if not read.time.size or not order.size:
        return np.nan
    off = read.measured - np.interp(read.time, of.time[order], of.predicted[order])
    off = off[np.isfinite(off)]
    return float(np.sqrt(np.mean(off**2))) if off.size >= LEAST else np.nan
