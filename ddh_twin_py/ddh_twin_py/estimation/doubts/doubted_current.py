"""A drive's current that cannot be, as the shaft needs another: what pressures and speed ask for is taken in its place.

Copper loss goes with the square of the current, so that one by a decimal place too large heats the winding a hundredfold, for which its
sound sensor would be refused. The pressures that carry the load tell which of the two it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fusion.inputs import FusionInputs
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC
from ddh_twin_py.telemetry.units.unit_scales import UnitScales

TIMES = 2.5
"""How many times as much as the other one must be, current or what is asked for, to be told: friction and a worn pump make less."""
TURNING, _CREEPING = 10.0, 1.0
"""rad/s, of a shaft that turns: at less, friction may hold what the current does not; and of one that a current too large must turn."""
BEYOND = 1.5
"""Times the drive's limit that no current is, whatever the pressures say or do not say: of a sine the peak is 1.4 times its RMS."""
ON_THE_WHOLE = 1.6
"""The same of RMS over `_WHOLE`: what friction, a worn pump and tolerances make; a unit far from its sheet may need so much, so that the
current is used and what it heats is unsure."""
_TELLING = 0.3  # of rated current, that must be asked for
_CARRIES = 2.0  # times by which the force of the pressures may be off the load, up or down
_TOLD, _AGREED, _UNHEARD = 0.5, 5.0, 60.0  # s of intervals in a row that tell it, that end it, and that do where pressures tell nothing
_WHOLE = 10.0  # s of intervals that are judged on the whole


@dataclass(frozen=True)
class DoubtedCurrent:
    """Interval with which it was told, counted from the start of a call, how, in a line, whether the current is used again, and by how much
    of itself what it heats is unsure from here on, None where that is as before."""

    index: int
    why: str
    again: bool = False
    unsure: float | None = None


class CurrentWatch:
    """Holds the current of a drive against what pressures and speed ask of the shaft.

    Args:
        rig: the rig. interval: s. payload_mass: kg, what the rig says it lifts; None takes the sheet's.

    Attributes:
        doubted: why the current is not used now and what is, '' while it is.
    """

    def __init__(self, rig: Rig, interval: float, payload_mass: float | None = None) -> None:
        self._rig = rig
        self.lifts(payload_mass)
        self._limit = self._scales.current_limit
        self._least = _TELLING * self._scales.rated_torque / self._scales.torque_constant
        self._told, self._agreed, self._unheard = _TOLD / interval, _AGREED / interval, _AGREED / _UNHEARD
        self._on_whole = _WHOLE / interval
        self.begin_anew()

    def lifts(self, payload_mass: float | None) -> None:
        """The rig says that it lifts so much, kg; None: as its sheet says."""
        self._scales = UnitScales.of(self._rig.declaring(payload_mass))

    def begin_anew(self) -> None:
        """Forget what was told, as of another rig."""
        self.doubted = ""
        self._row = 0.0  # intervals in a row that speak against what is held now
        self._times = 1.0  # how many times what is asked for the current is held to be on the whole
        self._begin_whole()

    @property
    def unlike(self) -> str:
        """What the current is on the whole where it is used and what it heats is unsure, '' elsewhere."""
        return (f"{DRIVE_TOPIC} current is on the whole {self._times:.2g} times what pressures and speed ask of the shaft, more than "
                "tolerances allow; it is used, and what it heats is as unsure as that") if self._times != 1.0 else ""

    def _begin_whole(self) -> None:
        self._whole = np.zeros(3)  # intervals that tell, and the sums of squares, A^2, of current and what is asked for

    def take(self, inputs: FusionInputs, asked: Mapping[str, np.ndarray] | np.ndarray) -> tuple[FusionInputs, list[DoubtedCurrent]]:
        """The inputs of n intervals with a current that can be, and what was told in them.

        Args:
            asked: what the soft sensor makes of pressures and speed, by name, (n,) each: ``current``, A, ``speed``, rad/s,
                ``pressure_piston_side`` and ``pressure_rod_side``, Pa; NaN where it says nothing.
        """
        read, needed = np.sqrt(inputs.mean_square_current), np.abs(asked["current"])
        heard, beyond = self._heard(inputs, asked, read, needed), inputs.motor_known & (read > BEYOND * self._limit)
        odd = (heard & ((read > TIMES * needed) | (TIMES * read < needed))) | beyond
        if not self.doubted and not odd.any():
            self._row = 0.0 if heard.any() else self._row
            return inputs, self._on_the_whole(read[heard], needed[heard], len(inputs) - 1)
        unheard = inputs.motor_known & ~inputs.hydraulics_known & (read > self._least)
        used, told = np.ones(len(inputs), bool), []
        for k in range(len(inputs)):
            speaks = 1.0 if heard[k] or beyond[k] else self._unheard if self.doubted and unheard[k] else 0.0
            if speaks:
                self._row = self._row + speaks if bool(odd[k]) != bool(self.doubted) else 0.0
            if self._row >= (self._agreed if self.doubted else self._told) - 0.5 * self._unheard:
                told.append(self._turn(k, read[k], needed[k] if heard[k] else np.nan))
                self._row = 0.0
            used[k] = not self.doubted
        if told or self.doubted:
            self._begin_whole()
        else:
            like = heard & ~odd
            told = self._on_the_whole(read[like], needed[like], len(inputs) - 1)
        square = np.where(used, inputs.mean_square_current, np.nan_to_num(needed) ** 2)
        return replace(inputs, mean_square_current=square, motor_known=inputs.motor_known & used), told

    def _on_the_whole(self, read: np.ndarray, needed: np.ndarray, index: int) -> list[DoubtedCurrent]:
        """Whether the current, A, of so many intervals that tell is on the whole another share of what is asked for than is held."""
        self._whole += (len(read), (read**2).sum(), (needed**2).sum())
        if self._whole[0] < self._on_whole:
            return []
        times = max(float(np.sqrt(self._whole[1] / self._whole[2])), 1.0 / TIMES)
        self._begin_whole()
        if _within(times, math.sqrt(ON_THE_WHOLE)):  # well within, so that it does not come and go
            times = 1.0
        if times == self._times or times != 1.0 and _within(times / self._times, ON_THE_WHOLE):
            return []
        self._times = times
        why = self.unlike or f"{DRIVE_TOPIC} current is on the whole what pressures and speed ask of the shaft again"
        return [DoubtedCurrent(index, why, times == 1.0, abs(times**-2 - 1.0))]

    def _heard(self, inputs: FusionInputs, asked: Mapping[str, np.ndarray] | np.ndarray, read: np.ndarray,
               needed: np.ndarray) -> np.ndarray:
        """In which intervals pressures that carry the load say what the shaft needs, (n,)."""
        scales, speed = self._scales, np.abs(asked["speed"])
        force = scales.force(asked["pressure_piston_side"], asked["pressure_rod_side"])
        carries = (force * _CARRIES > scales.load) & (force < _CARRIES * scales.load)
        turns = (speed > TURNING) | ((read > needed) & (speed > _CREEPING))
        return inputs.motor_known & inputs.hydraulics_known & turns & carries & (needed > self._least)

    def _turn(self, index: int, read: float, needed: float) -> DoubtedCurrent:
        """Doubt the current with this interval, or believe it again; both in A, ``needed`` NaN where nothing tells."""
        if self.doubted:
            self.doubted = ""
            again = f"is what pressures and speed ask of the shaft again, and is used (now {read:.3g} A for {needed:.3g} A)"
            within = f"has been within the drive's limit of {self._limit:.3g} A for {_UNHEARD:.0f} s, and is used again"
            return DoubtedCurrent(index, f"{DRIVE_TOPIC} current {again if np.isfinite(needed) else within}", again=True)
        if not np.isfinite(needed):
            why = f"{read:.3g} A, more than the drive's limit of {self._limit:.3g} A allows, likely in another unit"
        elif read > 0.0:
            why = (f"{read / needed:.2g} times what pressures and speed ask of the shaft ({read:.3g} A for {needed:.3g} A), "
                   "likely in another unit or with a decimal place lost")
        else:
            why = f"0 where the shaft needs {needed:.3g} A"
        self.doubted = f"{DRIVE_TOPIC} current is {why}; what pressures and speed ask for, if they tell, is used in its place"
        return DoubtedCurrent(index, f"{self.doubted} until both agree")


def _within(times: float, most: float) -> bool:
    """Whether so many times is no more than that, up or down."""
    return 1.0 / most < times < most
