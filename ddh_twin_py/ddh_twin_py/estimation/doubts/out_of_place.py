"""Temperature sensors that cannot be where they are said to be: two that read each other's places, or one far off its zero.

A filter bends until such readings fit, and then states small uncertainties of what it fused. So they are left out once they are told:
what is fused rests on the models and the other sensors, and its uncertainty says so.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fusion.credibility import FARTHEST_OFFSET
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX
from ddh_twin_py.twin.sensor_errors import temperature_noise

FAR_OFF = 2.0 * FARTHEST_OFFSET
"""Standard deviations of its zero error by which a sensor is held off, from which nothing near it is believed."""
LEAST = 20
"""Readings that tell something."""
_FAR, NEAR = 10.0, 3.0
"""Noises and zero errors together: off its own place, and as near as it must be to the other's."""
AIR = "ambient"
"""The sensor of the air, which the network does not know."""
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


def few(read: int) -> int:
    """Of so many sensors that are read, how many may be far off their zeros before it is the unit that is not what it is taken for."""
    return max(1, read // 4)


def stand_still(off: Mapping[str, float], read: int) -> list[OutOfPlace]:
    """Sensors that do not move while their places do, and how far each was off meanwhile, K, of so many that are read; none where they are
    more than `few`."""
    if len(off) > few(read):
        return []
    why = "stands still while its place must move, and was up to {:.1f} K off it meanwhile"
    return [OutOfPlace((sensor,), f"{TEMPERATURE_PREFIX}{sensor} {why.format(k)}", k, still=True) for sensor, k in off.items()]


def far_off_zero(zero_error: tuple[str, float, float], rig: Rig) -> OutOfPlace | None:
    """A sensor that is `FAR_OFF` its zero, of what `Credibility.offset` says; None where it is not.

    It must be as far off by the sheet's tolerance, too: a calibrated sensor's own is narrower, and less than that is harmless.
    """
    sensor, off, zero = zero_error
    least = FAR_OFF * rig.sensors["temperature"].offset_tolerance
    return OutOfPlace((sensor,), far(zero_error), zero) if abs(off) > FAR_OFF and abs(zero - rig.zero_error(sensor)[0]) > least else None


def filter_is_off(held: OutOfPlace) -> OutOfPlace:
    """Of a sensor that is held far off its zero and reads what the free run shows of its place: the estimate is wrong, not the sensor."""
    return OutOfPlace((), f"{held.why}, and reads what the free run shows there")


def far(zero_error: tuple[str, float, float]) -> str:
    """That a sensor is held to be so far off its zero, of what `Credibility.offset` says, in words."""
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
