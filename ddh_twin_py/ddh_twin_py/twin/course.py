"""Where a free run lost its command, and where it is taken up again from what is measured.

While no command is known the run's shaft stands. Where the machine moved on meanwhile, a run that followed the next command from there
would go into an end stop, cavitate, and fall by what its rod is put back at a standstill: it would turn nothing into heat.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.cylinder import rod_travel
from ddh_twin_py.physics.free_run import COMMAND_PARTS
from ddh_twin_py.physics.hydraulics import SPEED, SPEED_REFERENCE, VELOCITY
from ddh_twin_py.twin.intervals import HOLD
from ddh_twin_py.twin.rest import rest_at

STILL, CARRIED = 1.0, 5.0e-3
"""rad/s of a command up to which a rod rests, and m by which it is elsewhere than before."""


class Course:
    """Follows what is known of the command, interval by interval, of length ``interval`` (s).

    A run loses its course where the command becomes unknown (`intervals.HOLD` after the last message) and finds it in the first interval
    of known command, position and pressures' telemetry. A rod that rests before and after, within `CARRIED` of where it was, was never
    off; before the first command of all it takes longer than `HOLD` to lose it.
    """

    def __init__(self, interval: float) -> None:
        self._interval = interval
        self._lost = self._returned = False
        self._unknown = 0  # intervals, before the first command
        self._told = False
        self._command, self._position = 0.0, np.nan  # the last that were known on course

    def follow(self, measured: np.ndarray, command: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Whether the run is to be taken up at the begin of an interval, and whether it is off its course there, bool (n,) each.

        Args:
            measured: `soft_sensor.MEASURED_DTYPE`, (n,). command: rad/s, (`intervals.command_size` (n),), NaN where it is not known.
        """
        n = measured.shape[0]
        taken_up, off = np.zeros(n, bool), np.zeros(n, bool)
        finite = np.isfinite(command)
        known = finite[:-1].reshape(n, COMMAND_PARTS).all(axis=1) & finite[COMMAND_PARTS::COMMAND_PARTS]
        if known.all() and not self._lost:
            self._told = True
            self._keep(measured, command)
            return taken_up, off
        for k in range(n):
            here, edges = measured[k : k + 1], command[k * COMMAND_PARTS : (k + 1) * COMMAND_PARTS + 1]
            if not known[k]:
                self._unknown += 1
                self._lost |= self._told or self._unknown * self._interval > HOLD
            elif self._lost and self._rested(here, edges):
                self._lost = False
            elif self._lost and np.isfinite(here["rod_position"][0]) and here["hydraulic_age"][0] <= self._interval:
                self._lost = False
                taken_up[k] = True
            self._told |= bool(known[k])
            if known[k] and not self._lost:
                self._keep(here, edges)
            off[k] = self._lost
        return taken_up, off

    def _keep(self, measured: np.ndarray, command: np.ndarray) -> None:
        """Remember the newest position and command."""
        self._command = float(command[-1])
        position = measured["rod_position"][np.isfinite(measured["rod_position"])]
        if position.size:
            self._position = float(position[-1])

    def _rested(self, measured: np.ndarray, command: np.ndarray) -> bool:
        """Whether the rod rests where it did when the command was lost; where no position was ever read nothing tells otherwise."""
        position = float(measured["rod_position"][0])
        if np.isnan(self._position) and np.isnan(position):
            return True
        still = abs(self._command) <= STILL and np.abs(command).max() <= STILL
        return bool(still and abs(position - self._position) <= CARRIED)


def take_up(parameters: np.ndarray, state: np.ndarray, measured: np.void, command: np.ndarray, interval: float) -> None:
    """Set the hydraulic state to what is measured in an interval, at its begin; what moves steadily is at x - v t/2 there.

    A pressure that is not read is the one that holds the load, a speed that of the command, a velocity that of the shaft.

    Args:
        parameters: (1,). state: `HYDRAULIC_STATES`, in place. measured: means of the interval, position known, in SI.
        command: rad/s, at the edges of the parts of the interval. interval: s.
    """
    p = parameters[0]
    gained = 0.5 * float(command[-1] - command[0])
    speed = float(measured["speed"]) - gained if np.isfinite(measured["speed"]) else float(command[0])
    mean = float(measured["rod_velocity"])
    mean = mean if np.isfinite(mean) else (speed + gained) * rod_travel(p)
    position = float(measured["rod_position"]) - 0.5 * interval * mean
    rest_at(parameters, state, position, float(measured["pressure_piston_side"]), float(measured["pressure_rod_side"]))
    state[SPEED_REFERENCE] = state[SPEED] = speed
    state[VELOCITY] = mean - gained * rod_travel(p)
