"""The free run's runs of the paper's cycle, of which the table of its results is made.

Minav, Papini, Pietola: A Thermal Analysis of Direct Driven Hydraulics. Its cycle is run four times by
the free run: once for each reading of its text, which names both 500 rpm and 0.2 m/s although
they do not belong together, once at the ambient of its thermal image, and once with a pump 2 that fits the cylinder's area ratio.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.cylinder import piston_area
from ddh_twin_py.physics.equivalent_current import mean_square
from ddh_twin_py.physics.motor_only import motor_only
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, N
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.paper_cycle import AMBIENT, CHAMBER, CYCLES, PAYLOAD, ROD_SPEED, SPEED_RPM, Reading, read_as


@dataclass(frozen=True)
class Runs:
    """The paper's cycle in all its readings.

    Attributes:
        rig: as given, with the paper's payload. slow, fast: 500 rpm and 0.2 m/s. cold: 500 rpm at the chamber's temperature.
        matched: 500 rpm with pump 2 that fits the area ratio. equivalent_time, equivalent: s and K of the motor at the
            constant equivalent current (paper, eq. 6), (n,) and (n, number of motor nodes).
    """

    rig: Rig
    slow: Reading
    fast: Reading
    cold: Reading
    matched: Reading
    equivalent_time: np.ndarray
    equivalent: np.ndarray


def area_ratio(rig: Rig) -> float:
    """Area of the rod side over that of the piston side."""
    return 1.0 - (rig["cylinder.rod"] / rig["cylinder.bore"]) ** 2


def paper_runs(rig: Rig, progress: Callable[[float], None] = lambda share: None) -> Runs:
    """Run the paper's cycle in all readings."""
    rig = rig.with_values({"load.payload_mass": PAYLOAD}, source="paper")
    fast_rpm = ROD_SPEED * piston_area(rig.parameters[0]) / rig["pump_1.displacement"] * 60.0
    slow = read_as("500 rpm", rig, SPEED_RPM, AMBIENT)
    progress(0.25)
    fast = read_as("0.2 m/s", rig, fast_rpm, AMBIENT)
    progress(0.5)
    cold = read_as("500 rpm at 10 degC", rig, SPEED_RPM, CHAMBER)
    progress(0.75)
    fitting = rig.with_values({"pump_2.displacement": area_ratio(rig) * rig["pump_1.displacement"]}, source="fits the area ratio")
    matched = read_as("500 rpm, pump 2 that fits", fitting, SPEED_RPM, AMBIENT)
    runs = Runs(rig, slow, fast, cold, matched, *_equivalent_current(rig, slow))
    progress(1.0)
    return runs


def _equivalent_current(rig: Rig, reading: Reading) -> tuple[np.ndarray, np.ndarray]:
    """Motor at the constant current I_M^2/2 (paper, eq. 6), I_M the largest of the lift, over `CYCLES` cycles."""
    step = 0.05
    n = int(round(CYCLES * reading.cycle / step))
    square = mean_square(float(np.max(reading.points["current"][reading.lift()])))
    speed = np.full(n, float(np.mean(reading.points["speed_absolute"])))
    points, temperatures = np.zeros(n, OPERATING_DTYPE), np.empty((n, N))
    motor_only(
        rig.parameters, speed, np.full(n, math.sqrt(square)), np.full(n, square), np.full(n, reading.start), step,
        np.full(N, reading.start), points, temperatures,
    )
    return step * np.arange(1, n + 1), temperatures[:, : len(MOTOR_NODES)]
