"""The motor's thermal network driven by measured current and speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.motor_only import motor_only
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, N
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.intervals import INTERVAL


@dataclass(frozen=True)
class MotorResult:
    """What the motor model makes of n intervals.

    Attributes:
        points: operating points with the motor's fields and heat filled, (n,).
        temperature: K at the end of each interval, (n, number of motor nodes).
        known: true where current and speed were measured, (n,).
    """

    points: np.ndarray
    temperature: np.ndarray
    known: np.ndarray


class MachineThermal:
    """The motor's network alone, advanced interval by interval; ``temperature`` at the start in K."""

    def __init__(self, rig: Rig, temperature: float | np.ndarray, interval: float = INTERVAL) -> None:
        self.interval = interval
        self._parameters = rig.parameters
        self.temperature = np.full(N, temperature, dtype=float)

    def begin_again(self) -> None:
        """Nothing but its temperatures is carried from interval to interval, and these are kept."""

    @property
    def temperatures(self) -> tuple[np.ndarray, ...]:
        """Temperatures, K, (N,); to be changed in place."""
        return (self.temperature,)

    @staticmethod
    def driven(measured: np.ndarray) -> np.ndarray:
        """In which of n intervals it is known what drives the motor, bool (n,): its speed and current, `MEASURED_DTYPE` (n,)."""
        return np.isfinite(measured["speed"]) & np.isfinite(measured["current_square"])

    def advance(self, measured: np.ndarray, ambient: np.ndarray) -> MotorResult:
        """Run n intervals: ``measured`` of `MEASURED_DTYPE` (n,), ``ambient`` in K (n,).

        A motor whose telemetry stopped is taken as standing and reported as not known.
        """
        n = measured.shape[0]
        known = self.driven(measured)
        speed = np.where(known, measured["speed"], 0.0)
        current = np.where(known, measured["current"], 0.0)
        square = np.where(known, measured["current_square"], 0.0)
        points, temperatures = np.zeros(n, OPERATING_DTYPE), np.empty((n, N))
        motor_only(self._parameters, speed, current, square, ambient, self.interval, self.temperature, points, temperatures)
        return MotorResult(points, temperatures[:, :len(MOTOR_NODES)], known)
