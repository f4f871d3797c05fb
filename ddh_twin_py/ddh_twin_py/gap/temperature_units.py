"""Temperatures within a sensor's range that are likely given in degF, told by places that are about as warm.

Of 20 degC a sensor in degF makes 68, which none of this machine's ranges forbids; what is beyond them is screening's. Where most
sensors are in degF and the air is cool, nothing tells.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.telemetry.in_order import in_order
from ddh_twin_py.telemetry.recording import Recording, Stream
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, TEMPERATURE_SENSORS, ZERO_CELSIUS

_LEAST = 20  # samples that tell something
_SHARE = 0.05  # of the samples, coldest or warmest, that may be otherwise
_HOT = 55.0  # degC, of air that hardly any place has
_RESTED = 2.0  # K by which a motor that has rested differs from the air
_WITH_OIL = ("pump_1_case", "pump_2_case", "tank_oil", "tank_wall", "cylinder_barrel", "line_a", "line_b")
_HELD_AGAINST = {  # degF adds 32 K at 0 degC and more above
    "ambient": (np.min, TEMPERATURE_SENSORS, 30.0, (-60.0, 3.0), "the coldest place of the machine"),
    "motor_winding": (np.min, ("motor_housing",), 30.0, (-5.0, 45.0), "motor_housing"),
    "motor_housing": (np.min, ("motor_winding",), 15.0, (-45.0, 5.0), "motor_winding"),
    **dict.fromkeys(_WITH_OIL, (np.median, _WITH_OIL, 30.0, (-10.0, 10.0), "the median of the others that hold oil")),
}
"""What of which others each sensor is held against; by how much, K, it never is warmer, and how much warmer it is at least and at most; the
same in words."""


def temperature_units(recording: Recording) -> list[str]:
    """One sentence for each topic that is likely in degF; without the recording's name."""
    read = {name: read for name, stream in recording.temperatures.items() if (read := _readings(stream))[0].size >= _LEAST}
    said = {name: _beside_others(name, read) or (_hot_air(read[name][1]) if name == "ambient" else "") for name in read}
    return [f"{recording.namespace}/{TEMPERATURE_PREFIX}{name} temperature {text}" for name, text in said.items() if text]


def _readings(stream: Stream) -> tuple[np.ndarray, np.ndarray]:
    """Times and degC of what was read, in order of time."""
    known = in_order(stream.time, stream.values[:, 0])
    return stream.time[known], stream.values[known, 0] - ZERO_CELSIUS


def _beside_others(name: str, read: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> str:
    """That a reading is far too warm beside others and would fit them in degF; '' where it is not."""
    which, places, never, (lowest, highest), words = _HELD_AGAINST[name]
    time, own = read[name]
    others = [np.interp(time, *read[place]) for place in places if place in read and place != name]
    if not others:
        return ""
    against, right = which(others, axis=0), _from_degf(own)
    least, most = np.quantile(right - against, (_SHARE, 1.0 - _SHARE))
    if np.quantile(own - against, _SHARE) < never or least < lowest or most > highest:
        return ""
    if name == "motor_winding" and "ambient" in read and abs(against[0] - read["ambient"][1][0]) > _RESTED:
        return ""  # a winding at work is warmer than its housing by as much
    return (f"looks as if given in degF: it reads {own.mean():.0f} degC on average, {words} {against.mean():.0f} degC; it would be "
            f"{right.mean():.0f} degC")


def _hot_air(read: np.ndarray) -> str:
    """That the air is as hot as hardly ever; '' where it is not. All others may be in degF as well, as one device reads them."""
    if np.quantile(read, _SHARE) < _HOT:
        return ""
    return (f"looks as if given in degF, perhaps with others: it reads {read.mean():.0f} degC on average, as warm as air hardly ever is; "
            f"it would be {_from_degf(read).mean():.0f} degC")


def _from_degf(values: np.ndarray) -> np.ndarray:
    """degC of readings in degF."""
    return (values - 32.0) / 1.8
