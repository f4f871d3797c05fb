"""Temperature sensors that cannot be where they are said to be: two that read each other's places, or one far off its zero.

A filter bends until such readings fit, and then states small uncertainties of what it fused.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from ddh_twin_py.estimation.credibility import FARTHEST_OFFSET
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

if TYPE_CHECKING:
    from ddh_twin_py.estimation.replay import ReplayResult, SensorComparison

_FAR, _NEAR = 10.0, 3.0  # noises and zero errors together: off its own place, and as near as it must be to the other's
_FAR_OFF = 2.0 * FARTHEST_OFFSET
"""Standard deviations of its zero error by which a sensor is held off, from which nothing near it is believed."""
_LEAST = 20  # readings that tell something


def out_of_place(result: ReplayResult) -> str:
    """Which sensors these are, in one line; '' where none is."""
    if pair := _exchanged(result):
        one, two = (TEMPERATURE_PREFIX + name for name in pair)
        return (f"{one} and {two} look exchanged, as each reads what the free run shows of the other; what is fused of both may be off by "
                "more than is stated")
    if result.zero_error is None or abs(result.zero_error[1]) <= _FAR_OFF:
        return ""
    sensor, off, zero = result.zero_error
    return (f"{TEMPERATURE_PREFIX}{sensor} is held to read {zero:+.1f} K off, {abs(off):.0f} standard deviations of its zero error; "
            "what is fused near it may be off by more than is stated")


def _exchanged(result: ReplayResult) -> tuple[str, str] | None:
    """The two sensors that are far off what the free run shows of their own places, and near what it shows of each other's."""
    zero = float(result.rig.sensors["temperature"].offset_tolerance)
    told = {name: sensor for name, sensor in result.sensors.items() if sensor.time.size}
    unit = {name: float(np.hypot(sensor.noise, zero)) or np.inf for name, sensor in told.items()}
    far = [name for name, sensor in told.items() if _off(sensor, sensor) > _FAR * unit[name]]
    pairs = [(one, two) for one, two in itertools.combinations(far, 2)
             if _off(told[one], told[two]) < _NEAR * unit[one] and _off(told[two], told[one]) < _NEAR * unit[two]]
    return pairs[0] if pairs else None


def _off(read: SensorComparison, of: SensorComparison) -> float:
    """RMS, K, by which a reading is off what the free run shows at a place, NaN where too little tells."""
    order = np.argsort(of.time, kind="stable")
    off = read.measured - np.interp(read.time, of.time[order], of.predicted[order])
    off = off[np.isfinite(off)]
    return float(np.sqrt(np.mean(off**2))) if off.size >= _LEAST else np.nan
