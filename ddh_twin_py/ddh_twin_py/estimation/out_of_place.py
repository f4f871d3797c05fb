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
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX
from ddh_twin_py.twin.sensor_errors import temperature_noise

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from ddh_twin_py.estimation.replay import ReplayResult, SensorComparison

FAR_OFF = 2.0 * FARTHEST_OFFSET
"""Standard deviations of its zero error by which a sensor is held off, from which nothing near it is believed."""
LEAST = 20
"""Readings that tell something."""
_FAR, _NEAR = 10.0, 3.0  # noises and zero errors together: off its own place, and as near as it must be to the other's


@dataclass(frozen=True)
class OutOfPlace:
    """Sensors that are told to be out of place, by name, and why, in a line."""

    sensors: tuple[str, ...]
    why: str

    @property
    def left_out(self) -> str:
        """Why, and that they are left out."""
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

    Two that look exchanged are left out at once. One that is far off its zero is where what is left then agrees: if more than `few` are,
    or another is in doubt yet, the unit is not what the twin takes it for, and all are used.

    Args:
        run: makes a replay without these sensors. without: sensors that are not used anyway.
    """
    unseen = frozenset(without)
    result = run(unseen)
    while (found := _pair(result)) is not None and not unseen.issuperset(found.sensors):
        unseen = unseen.union(found.sensors)
        result = replace(run(unseen), left_out=(*result.left_out, found))
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


def far_off_zero(zero_error: tuple[str, float, float], rig: Rig) -> OutOfPlace | None:
    """A sensor that is `FAR_OFF` its zero, of what `Credibility.offset` says; None where it is not.

    It must be as far off by the sheet's tolerance, too: a calibrated sensor's own is narrower, and less than that is harmless.
    """
    sensor, off, zero = zero_error
    least = FAR_OFF * rig.sensors["temperature"].offset_tolerance
    return OutOfPlace((sensor,), _far(zero_error)) if abs(off) > FAR_OFF and abs(zero - rig.zero_error(sensor)[0]) > least else None


def _far(zero_error: tuple[str, float, float]) -> str:
    sensor, off, zero = zero_error
    return f"{TEMPERATURE_PREFIX}{sensor} is held to read {zero:+.1f} K off, {abs(off):.0f} standard deviations of its zero error"


def look_exchanged(off: np.ndarray, rig: Rig) -> OutOfPlace | None:
    """The two sensors that are far off what the free run shows of their own places, and near what it shows of each other's.

    Args:
        off: K, RMS by which each of `SENSORS` (row) is off what the free run shows at the place of each (column), (m, m), NaN where too
            little tells.
    """
    unit = np.hypot(temperature_noise(rig), rig.sensors["temperature"].offset_tolerance)
    unit = np.where(unit > 0.0, unit, np.inf)
    own = np.diagonal(off) / unit
    near = off < _NEAR * unit[:, None]
    for one, two in itertools.combinations(np.flatnonzero(own > _FAR).tolist(), 2):
        if near[one, two] and near[two, one]:
            first, second = TEMPERATURE_PREFIX + SENSORS[one], TEMPERATURE_PREFIX + SENSORS[two]
            return OutOfPlace((SENSORS[one], SENSORS[two]),
                              f"{first} and {second} look exchanged, as each reads what the free run shows of the other")
    return None


def _off(read: SensorComparison, of: SensorComparison) -> float:
    """RMS, K, by which a reading is off what the free run shows at a place, NaN where too little tells."""
    order = np.argsort(of.time, kind="stable")
    if not read.time.size or not order.size:
        return np.nan
    off = read.measured - np.interp(read.time, of.time[order], of.predicted[order])
    off = off[np.isfinite(off)]
    return float(np.sqrt(np.mean(off**2))) if off.size >= LEAST else np.nan
