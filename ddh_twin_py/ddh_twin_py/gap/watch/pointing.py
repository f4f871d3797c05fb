"""Which component the open signals point to, where they alone tell; the diagnosis weighs the rest.

The free run takes no measured value, so that a sensor that reads wrong moves its own signal alone, while what is
really otherwise in the machine moves others too, by amounts that balances of force and torque give.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ddh_twin_py.gap.watch.running_test import SignalStatus
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

_CLEARLY = 2.0  # how much larger than detectable the move of another signal must be, to be missed
_TOGETHER = {"motor": ("motor_winding", "motor_housing"), "tank": ("tank_oil", "tank_wall")}
PISTON, ROD = "pressure_piston_side", "pressure_rod_side"


def pointed_component(statuses: Sequence[SignalStatus], rig: Rig) -> tuple[str, str]:
    """Component and the reason; ('', why not) where the open signals fit more than one, ('', '') where none is open."""
    opened = {status.signal: status for status in statuses if status.opened}
    if not opened:
        return "", ""
    closed = {status.signal: status.detectable for status in statuses if not status.opened and status.tested}
    if len(opened) == 1 and next(iter(opened)) in (PISTON, ROD):
        (signal, status), = opened.items()
        return _lonely_pressure(signal, abs(status.size), closed, rig)
    for component, sensors in _TOGETHER.items():
        names = [TEMPERATURE_PREFIX + sensor for sensor in sensors]
        if set(opened) == set(names) and len({opened[name].size > 0.0 for name in names}) == 1:
            return component, f"{' and '.join(names)} depart together and no other signal does"
    return "", "the open signals fit more than one component; the action diagnose weighs them"


def _lonely_pressure(signal: str, size: float, closed: Mapping[str, float], rig: Rig) -> tuple[str, str]:
    """A pressure that departs alone: its transducer, where a real one would have been seen elsewhere.

    A real change of the piston side's pressure changes the shaft's torque, D·p/2pi, and with it the current; one of
    the rod side's changes the piston side's, p_A = p_B·A_B/A_A at the same load.
    """
    if signal == PISTON:
        other, unit = "current", "A"
        moved = rig["pump_1.displacement"] * size / (2.0 * math.pi) / rig["motor.torque_constant"]
    else:
        other, unit = PISTON, "Pa"
        moved = size * (1.0 - (rig["cylinder.rod"] / rig["cylinder.bore"]) ** 2)
    least = closed.get(other)
    if least is None:
        return "", f"{signal} departs alone, and {other} is not tested yet, which would tell the transducer from the machine"
    if moved < _CLEARLY * least:
        return "", f"{signal} departs alone; a real one would move {other} by {moved:.3g} {unit}, too little to be missed"
    return "sensor", f"{signal} departs alone; a real one would move {other} by {moved:.3g} {unit}, {least:.3g} {unit} would be seen"
