"""The hydraulic model on telemetry: soft sensor and free run side by side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.cylinder import holding_pressure
from ddh_twin_py.physics.free_run import HYDRAULIC_STEP, free_run, settle
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES, POSITION
from ddh_twin_py.physics.soft_sensor import soft_sensor
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.intervals import INTERVAL, STANDSTILL

RESIDUAL_SIGNALS = (
    ("speed", "speed", "rad/s"),
    ("torque", "torque", "N*m"),
    ("current", "current", "A"),
    ("voltage", "voltage", "V"),
    ("electrical_power", "electrical_power", "W"),
    ("pressure_piston_side", "pressure", "Pa"),
    ("pressure_rod_side", "pressure", "Pa"),
    ("rod_position", "rod_position", "m"),
    ("rod_velocity", "rod_velocity", "m/s"),
)
"""Signals that telemetry and model both have: name, key of the noise in the sheet, unit."""

_DRIVING = ("speed", "current", "current_square", "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity")
_FREE_RUN_NAME = {"current_square": "mean_square_current"}
UNSEEN = 5.0
"""s at the beginning that say nothing of a free run's fast signals: what moved before it began is not known."""
_SURE = 3.0  # standard deviations of a position, within which an end stop says better where the rod is


def off_the_stops(position: np.ndarray, rig: Rig, samples: float = 1.0) -> np.ndarray:
    """Positions (m), NaN where an end stop is as near as a mean of so many samples is sure.

    A stop is so stiff that a rod put back onto it by a noisy position would be pressed with several times its load.
    """
    reach = _SURE * rig.sensors["rod_position"].noise / np.sqrt(max(samples, 1.0))
    free = (position > reach) & (position < rig["cylinder.stroke"] - reach)
    return np.where(free, position, np.nan)


def _first(values: np.ndarray, default: float) -> float:
    """The first finite value, else the default."""
    finite = values[np.isfinite(values)]
    return float(finite[0]) if finite.size else default


@dataclass(frozen=True)
class HydraulicResult:
    """What the hydraulic model makes of n intervals.

    Attributes:
        soft: operating points from the measured pressures and speed, `OPERATING_DTYPE`, (n,).
        free: operating points of the free run, (n,).
        soft_temperature, free_temperature: K at the end of each interval, (n, N).
        known: true where the telemetry of the interval was there, (n,).
        settled: true from `UNSEEN` after the model began, (n,); before, the free run is not to be held against what was measured.
    """

    soft: np.ndarray
    free: np.ndarray
    soft_temperature: np.ndarray
    free_temperature: np.ndarray
    known: np.ndarray
    settled: np.ndarray


class HydraulicModel:
    """Soft sensor and free run of the hydraulics, advanced interval by interval.

    Args:
        rig: the rig. payload_mass: kg, what the rig says it lifts; None takes the sheet's.
        temperature: K, at the start, shape (N,) or one number.
        step: s, hydraulic step of the free run.
    """

    def __init__(self, rig: Rig, temperature: float | np.ndarray, payload_mass: float | None = None,
                 interval: float = INTERVAL, step: float = HYDRAULIC_STEP) -> None:
        self.rig = rig
        self.interval = interval
        self.step = step
        self._parameters = rig.declaring(payload_mass).parameters
        self.free_temperature = np.full(N, temperature, dtype=float)
        self.soft_temperature = self.free_temperature.copy()
        self._better = np.zeros(N)
        self._use_better = False
        self._state = np.zeros(len(HYDRAULIC_STATES))
        self._started = False
        self._placed = False
        self._run = 0  # intervals

    def use_temperatures(self, temperature: np.ndarray | None) -> None:
        """Take better known temperatures, K (N), for viscosity and resistance of the soft sensor; None: its own."""
        self._use_better = temperature is not None
        if temperature is not None:
            self._better[:] = temperature

    def advance(self, measured: np.ndarray, command: np.ndarray, ambient: np.ndarray) -> HydraulicResult:
        """Run n intervals.

        Args:
            measured: `MEASURED_DTYPE`, (n,). command: rad/s, shape
                (`intervals.command_size` (n),).
            ambient: K, (n,).
        """
        n = measured.shape[0]
        free = np.zeros(n, OPERATING_DTYPE)
        soft = np.zeros(n, OPERATING_DTYPE)
        free_temperature, soft_temperature = np.empty((n, N)), np.empty((n, N))
        self._place(measured)
        known_command = np.where(np.isfinite(command), command, 0.0)
        position = np.where(measured["standstill"] >= STANDSTILL, off_the_stops(measured["rod_position"], self.rig), np.nan)
        free_run(self._parameters, self._state, self.free_temperature, known_command, ambient, self.interval,
                 self.step, position, free, free_temperature)
        filled, known = self._filled(measured, free)
        soft_sensor(self._parameters, filled, self._better, self._use_better, self.interval, self.soft_temperature,
                    ambient, soft, soft_temperature)
        settled = self.interval * (self._run + np.arange(n)) >= UNSEEN
        self._run += n
        return HydraulicResult(soft, free, soft_temperature, free_temperature, known, settled)

    def _place(self, measured: np.ndarray) -> None:
        """Begin at rest at the measured pressures and position; take the position once it is there."""
        if not self._started:
            position = _first(measured["rod_position"], 0.5 * self.rig["cylinder.stroke"])
            rod_side = _first(measured["pressure_rod_side"], 0.0)
            holding = holding_pressure(position, rod_side, self._parameters[0])
            settle(self._parameters, self._state, position, _first(measured["pressure_piston_side"], holding), rod_side)
            self._started = True
            self._placed = bool(np.isfinite(measured["rod_position"]).any())
        elif not self._placed and np.isfinite(measured["rod_position"]).any():
            self._state[POSITION] = _first(measured["rod_position"], np.nan)
            self._placed = True

    @staticmethod
    def _filled(measured: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Telemetry with what is missing taken from the free run; and where nothing was missing."""
        filled = measured.copy()
        known = np.ones(measured.shape[0], dtype=bool)
        for name in _DRIVING:
            missing = ~np.isfinite(measured[name])
            filled[name][missing] = free[_FREE_RUN_NAME.get(name, name)][missing]
            known &= ~missing
        filled["acceleration"] = np.where(np.isfinite(filled["acceleration"]), filled["acceleration"], 0.0)
        return filled, known
