"""A drive's current that cannot be, as the shaft needs another: what pressures and speed ask for is taken in its place.

Copper loss goes with the square of the current, so that one by a decimal place too large heats the winding a hundredfold, for which its
sound sensor would be refused. The pressures that carry the load tell which of the two it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.temperature_fusion import FusionInputs
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC
from ddh_twin_py.telemetry.unit_scales import UnitScales

TIMES = 5.0
"""How many times as much as the other one must be, current or what is asked for, to be told: friction and a worn pump make less."""
TURNING = 10.0
"""rad/s, of a shaft that turns: at less, friction may hold what the current does not."""
_TELLING = 0.3  # of rated current, that must be asked for
_CARRIES = 3.0  # times by which the force of the pressures may be off the load, up or down
_TOLD, _AGREED = 0.5, 5.0  # s of intervals in a row that tell it, and that end it


@dataclass(frozen=True)
class DoubtedCurrent:
    """Interval with which it was told, counted from the start of a call, and how, in a line."""

    index: int
    why: str


class CurrentWatch:
    """Holds the current of a drive against what pressures and speed ask of the shaft.

    Args:
        rig: the rig. interval: s. payload_mass: kg, what the rig says it lifts; None takes the sheet's.

    Attributes:
        doubted: why the current is not used now, '' while it is.
    """

    def __init__(self, rig: Rig, interval: float, payload_mass: float | None = None) -> None:
        self._rig = rig
        self.lifts(payload_mass)
        self._least = _TELLING * self._scales.rated_torque / self._scales.torque_constant
        self._told, self._agreed = round(_TOLD / interval), round(_AGREED / interval)
        self.begin_anew()

    def lifts(self, payload_mass: float | None) -> None:
        """The rig says that it lifts so much, kg; None: as its sheet says."""
        self._scales = UnitScales.of(self._rig.declaring(payload_mass))

    def begin_anew(self) -> None:
        """Forget what was told, as of another rig."""
        self.doubted = ""
        self._row = 0  # intervals in a row that speak against what is held now

    def take(self, inputs: FusionInputs, asked: Mapping[str, np.ndarray] | np.ndarray) -> tuple[FusionInputs, DoubtedCurrent | None]:
        """The inputs of n intervals with a current that can be, and what was told in them, None where nothing was.

        Args:
            asked: what the soft sensor makes of pressures and speed, by name, (n,) each: ``current``, A, ``speed``, rad/s,
                ``pressure_piston_side`` and ``pressure_rod_side``, Pa; NaN where it says nothing.
        """
        read, needed = np.sqrt(inputs.mean_square_current), np.abs(asked["current"])
        scales = self._scales
        force = asked["pressure_piston_side"] * scales.piston_area - asked["pressure_rod_side"] * scales.rod_side_area
        tells = inputs.motor_known & inputs.hydraulics_known & (np.abs(asked["speed"]) > TURNING) & (needed > self._least)
        odd = tells & ((read > TIMES * needed) | (TIMES * read < needed))
        odd &= (force * _CARRIES > scales.load) & (force < _CARRIES * scales.load)
        if not self.doubted and not odd.any():
            self._row = 0 if tells.any() else self._row
            return inputs, None
        used, told = np.ones(len(inputs), bool), None
        for k in range(len(inputs)):
            if tells[k]:
                self._row = self._row + 1 if bool(odd[k]) != bool(self.doubted) else 0
            if self._row >= (self._agreed if self.doubted else self._told):
                told, self._row = self._turn(k, read[k], needed[k]), 0
            used[k] = not self.doubted
        square = np.where(used, inputs.mean_square_current, np.nan_to_num(needed) ** 2)
        return replace(inputs, mean_square_current=square, motor_known=inputs.motor_known & used), told

    def _turn(self, index: int, read: float, needed: float) -> DoubtedCurrent:
        """Doubt the current with this interval, or believe it again; both in A."""
        if self.doubted:
            self.doubted = ""
            return DoubtedCurrent(index, f"{DRIVE_TOPIC} current is what pressures and speed ask of the shaft again, and is used")
        self.doubted = (f"{DRIVE_TOPIC} current is {read / needed:.2g} times what pressures and speed ask of the shaft ({read:.3g} A for "
                        f"{needed:.3g} A), likely in another unit or with a decimal place lost")
        return DoubtedCurrent(index, f"{self.doubted}; what they ask for is used in its place until both agree")
