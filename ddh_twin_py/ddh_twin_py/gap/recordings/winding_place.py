"""A winding's sensor at another place: what heats the machine is never colder than what it heats, nor cool while oil warms alone."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.in_order import in_order
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

_LEAST = 20  # samples that tell something
_SHARE = 0.05  # of the time, in which it may be otherwise
_COOL = 1.0  # K by which a winding that does nothing is warmer than its housing
_WARMS = 5.0  # K by which one place warms, and is warmer than all others that hold oil, to be told
_HOLD_OIL = ("pump_1_case", "pump_2_case", "tank_oil", "tank_wall", "cylinder_barrel", "line_a", "line_b")
_ENDS = 0.1  # of the recording, at either end


def warms_instead(recording: Recording) -> str:
    """Which place warms as a winding does while that stays as cool as its housing, in a line without the recording's name; else ''.

    Oil warms by what the pump gives it and flows through all that holds it: none of these warms alone, and not without the winding.
    """
    read = {}
    for name, stream in recording.temperatures.items():
        known = in_order(stream.time, stream.values[:, 0])
        if known.size >= _LEAST:
            read[name] = stream.time[known], stream.values[known, 0]
    if not {"motor_winding", "motor_housing"} < set(read):
        return ""
    time, winding = read["motor_winding"]
    if np.quantile(winding - np.interp(time, *read["motor_housing"]), 1.0 - _SHARE) > _COOL:
        return ""
    holding = {name: read[name] for name in _HOLD_OIL if name in read}
    last = {name: _at_end(*held) for name, held in holding.items()}
    warmed = {name: last[name] - _at_begin(*held) for name, held in holding.items()}
    name = max(last, key=last.get, default="")
    others = [other for other in last if other != name]
    if len(others) < 2 or warmed[name] < _WARMS or last[name] - max(last[other] for other in others) < _WARMS:
        return ""
    most = max(0.0, *(warmed[other] for other in others))
    if most > 0.5 * warmed[name]:
        return ""
    return (f"{recording.namespace}/{TEMPERATURE_PREFIX}motor_winding stays as cool as motor_housing while {name} warms by "
            f"{warmed[name]:.0f} K, and nothing else that holds oil by more than {most:.1f} K; their sensors are likely exchanged")


def _at_begin(time: np.ndarray, values: np.ndarray) -> float:
    return float(np.median(values[time <= time[0] + _ENDS * (time[-1] - time[0])]))


def _at_end(time: np.ndarray, values: np.ndarray) -> float:
    return float(np.median(values[time >= time[-1] - _ENDS * (time[-1] - time[0])]))
