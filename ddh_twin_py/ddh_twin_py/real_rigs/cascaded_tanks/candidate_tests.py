"""Tests of the tanks that can be made: other courses of the pump's voltage, a second level sensor."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.real_rigs.cascaded_tanks.model import NOISE, Tanks
from ddh_twin_py.real_rigs.cascaded_tanks.recordings import STEP, TankRecord
from ddh_twin_py.real_rigs.next_test import DescribedTest
from ddh_twin_py.real_rigs.signals import signal

_STAIR, _FULL, _EMPTY = 600.0, 900.0, 1200.0  # s at a step, with a strong pump, with none


class TanksWithTwoSensors(Tanks):
    """A test in which the upper tank's level is read too; signal ``upper level``, V."""

    def __init__(self, record: TankRecord) -> None:
        super().__init__(record)
        self.signals = {**self.signals, "upper level": signal(self.time, np.zeros(self.time.size), NOISE, "V")}

    def predict(self, record: np.ndarray) -> dict[str, np.ndarray]:
        return {**super().predict(record), "upper level": self.levels(record)[0]}


def candidate_tests(record: TankRecord) -> list[DescribedTest]:
    """Tests within the range of voltages of a record."""
    low, high = float(record.pump.min()), float(record.pump.max())
    stairs = np.linspace(low, high, 6)
    courses = {
        "move the pump as in the identification record": record.pump,
        f"raise the pump's voltage in steps of 10 min from {low:.1f} to {high:.1f} V and lower it again":
            np.concatenate([_held(u, _STAIR) for u in (*stairs, *stairs[-2::-1])]),
        f"pump at {high:.1f} V for 15 min, until both tanks stand still, then let them empty with the pump off for 20 min":
            np.concatenate([_held(high, _FULL), _held(0.0, _EMPTY)]),
    }
    out = []
    for words, pump in courses.items():
        blank = TankRecord(words, pump, np.zeros(pump.size))
        if pump is not record.pump:
            out.append(DescribedTest(f"{words[:1].upper()}{words[1:]}.", Tanks(blank)))
        out.append(DescribedTest(f"Put a level sensor into the upper tank as well, then {words}.", TanksWithTwoSensors(blank)))
    return out


def _held(voltage: float, seconds: float) -> np.ndarray:
    return np.full(round(seconds / STEP), voltage)
