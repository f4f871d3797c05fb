"""The hydraulic model on telemetry: soft sensor and free run side by side."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.free_run import COMMAND_PARTS, HYDRAULIC_STEP, free_run
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES, POSITION
from ddh_twin_py.physics.soft_sensor import soft_sensor
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.course import Course, take_up
from ddh_twin_py.twin.intervals import INTERVAL, STANDSTILL
from ddh_twin_py.twin.rest import first_finite, rest_at

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

_PRESSURES = ("pressure_piston_side", "pressure_rod_side")
_DRIVING = ("speed", "current", "current_square", *_PRESSURES, "rod_position", "rod_velocity")
_FREE_RUN_NAME = {"current_square": "mean_square_current"}
UNSEEN = 5.0
"""s at the beginning that say nothing of a free run's fast signals: what moved before it began is not known."""
_FALLS = 0.02  # m/s, of a run's rod at a standstill at which it is put back: what a leak lets sink is slower, one that fell is lifted
_AHEAD = 1200  # intervals that are run before it is looked whether the rod fell, as what follows a fall is run once more
_SURE = 3.0  # standard deviations of a position, within which an end stop says better where the rod is


def off_the_stops(position: np.ndarray, rig: Rig, samples: float = 1.0) -> np.ndarray:
    """Positions (m), NaN where an end stop is as near as a mean of so many samples is sure.

    A stop is so stiff that a rod put back onto it by a noisy position would be pressed with several times its load.
    """
    reach = _SURE * rig.sensors["rod_position"].noise / np.sqrt(max(samples, 1.0))
    free = (position > reach) & (position < rig["cylinder.stroke"] - reach)
    return np.where(free, position, np.nan)


@dataclass(frozen=True)
class HydraulicResult:
    """What the hydraulic model makes of n intervals.

    Attributes:
        soft: operating points from the measured pressures and speed, `OPERATING_DTYPE`, (n,).
        free: operating points of the free run, (n,).
        soft_temperature, free_temperature: K at the end of each interval, (n, N).
        known: true where the telemetry of the interval was there, (n,).
        settled: true from `UNSEEN` after the model began or was taken up, (n,); before, the free run is not to be held against what was
            measured.
        off: true where the free run lost its command, until it is taken up from what is measured, unless it turns out to have rested
            (`course`), (n,). taken_up: true where it was, at the begin of an interval, (n,).
    """

    soft: np.ndarray
    free: np.ndarray
    soft_temperature: np.ndarray
    free_temperature: np.ndarray
    known: np.ndarray
    settled: np.ndarray
    off: np.ndarray
    taken_up: np.ndarray


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
        self.begin_again()

    def begin_again(self) -> None:
        """Begin at rest at what is measured next, as warm as it is."""
        self._state = np.zeros(len(HYDRAULIC_STATES))
        self._started = False
        self._placed = False
        self._course = Course(self.interval)
        self._run = 0  # intervals since the begin, or since it was taken up
        self._falls = 0  # of the rod, in the standstill in hand

    @property
    def temperatures(self) -> tuple[np.ndarray, ...]:
        """Temperatures of the free run and of the soft sensor, K, (N,) each; to be changed in place."""
        return self.free_temperature, self.soft_temperature

    @staticmethod
    def driven(measured: np.ndarray, command: np.ndarray) -> np.ndarray:
        """In which of n intervals it is known what drives the free run, bool (n,): the command; see `advance`."""
        return np.isfinite(command[:-1]).reshape(measured.shape[0], COMMAND_PARTS).all(axis=1)

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
        taken_up, off = self._course.follow(measured, command)
        standing = measured["standstill"] >= STANDSTILL
        position = np.where(standing, off_the_stops(measured["rod_position"], self.rig), np.nan)
        since = self.interval * (self._run + np.arange(n))
        self._run += n
        for first, stop in pairwise(np.unique([0, *np.flatnonzero(taken_up), n]).tolist()):
            if taken_up[first]:
                edges = known_command[first * COMMAND_PARTS : (first + 1) * COMMAND_PARTS + 1]
                take_up(self._parameters, self._state, measured[first], edges, self.interval)
                self._run = n - first
                since[first:] = self.interval * np.arange(n - first)
            rows = slice(first, stop)
            self._advance_free(measured[rows], standing[rows], known_command[first * COMMAND_PARTS : stop * COMMAND_PARTS + 1],
                               ambient[rows], position[rows], free[rows], free_temperature[rows])
        filled, known = self._filled(measured, free)
        soft_sensor(self._parameters, filled, self._better, self._use_better, self.interval, self.soft_temperature,
                    ambient, soft, soft_temperature)
        return HydraulicResult(soft, free, soft_temperature, free_temperature, known, (since >= UNSEEN) & ~off, off, taken_up)

    def _advance_free(self, measured: np.ndarray, standing: np.ndarray, command: np.ndarray, ambient: np.ndarray, position: np.ndarray,
                      free: np.ndarray, free_temperature: np.ndarray) -> None:
        """The free run over intervals that follow each other, its rod put to positions (m, NaN: left alone) while it stands.

        A rod that falls whenever it is put back would be lifted by nothing, over and over: once in a standstill it is set to rest at the
        measured pressures, and where these do not hold it, it is left where it falls.
        """
        begin, n = 0, free.shape[0]
        if self._falls > 1:
            self._let_go(standing, position, 0)
        while begin < n:
            state, temperature = self._state.copy(), self.free_temperature.copy()
            end = min(n, begin + _AHEAD)
            self._run_free(slice(begin, end), command, ambient, position, free, free_temperature)
            fallen = np.flatnonzero(np.isfinite(position[begin:end]) & (np.abs(free["rod_velocity"][begin:end]) > _FALLS))
            stop = begin + int(fallen[0]) + 1 if fallen.size else end
            if not standing[begin:stop].all():
                self._falls = 0
            if not fallen.size:
                begin = end
                continue
            self._falls += 1
            self._state[:], self.free_temperature[:] = state, temperature
            self._run_free(slice(begin, stop), command, ambient, position, free, free_temperature)
            if self._falls > 1:
                self._let_go(standing, position, stop)
            else:
                pressures = (float(measured[name][stop - 1]) for name in _PRESSURES)
                rest_at(self._parameters, self._state, float(position[stop - 1]), *pressures)
            begin = stop

    def _run_free(self, rows: slice, command: np.ndarray, ambient: np.ndarray, position: np.ndarray, free: np.ndarray,
                  free_temperature: np.ndarray) -> None:
        """The free run over some of the intervals that are given."""
        edges = command[rows.start * COMMAND_PARTS : rows.stop * COMMAND_PARTS + 1]
        free_run(self._parameters, self._state, self.free_temperature, edges, ambient[rows], self.interval, self.step, position[rows],
                 free[rows], free_temperature[rows])

    @staticmethod
    def _let_go(standing: np.ndarray, position: np.ndarray, begin: int) -> None:
        """Put the rod nowhere from an interval on until it is moved again."""
        moves = np.flatnonzero(~standing[begin:])
        position[begin : begin + int(moves[0]) if moves.size else None] = np.nan

    def _place(self, measured: np.ndarray) -> None:
        """Begin at rest at the measured pressures and position, or amid the stroke until a position is there."""
        if not self._started:
            position = first_finite(measured["rod_position"], 0.5 * self.rig["cylinder.stroke"])
            rest_at(self._parameters, self._state, position, *(first_finite(measured[name], np.nan) for name in _PRESSURES))
            self._started = True
            self._placed = bool(np.isfinite(measured["rod_position"]).any())
        elif not self._placed and np.isfinite(measured["rod_position"]).any():
            self._state[POSITION] = first_finite(measured["rod_position"], np.nan)
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
