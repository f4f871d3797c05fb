"""Runs of the model that several tests look at."""

import numpy as np
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.free_run import COMMAND_PARTS, free_run, settle
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.twin.intervals import command_size

INTERVAL = 0.05
START = 296.15


def lift_and_lower(cycles=1, speed=52.36, stroke_seconds=4.0, rest=1.0, ramp=120.0):
    """Speed command at the edges of 50 ms intervals, rad/s: lift, rest, lower, rest."""
    ramp_seconds = speed / ramp
    knots, values, now = [0.0], [0.0], 0.0
    for _ in range(cycles):
        for sign in (1.0, -1.0):
            for duration, value in ((ramp_seconds, sign * speed), (stroke_seconds, sign * speed), (ramp_seconds, 0.0), (rest, 0.0)):
                now += duration
                knots.append(now)
                values.append(value)
    edges = np.arange(0.0, now, INTERVAL)
    return np.interp(edges, knots, values)


def run(rig, command, step=1e-3, start_position=0.02, temperature=START, ambient=START, pressures=(5e5, 0.0)):
    """Free run over a command: operating points, temperatures, first and last hydraulic state, heat lost (J)."""
    n = command.size - 1
    command = np.interp(np.arange(command_size(n)) / COMMAND_PARTS, np.arange(n + 1), command)
    state = np.zeros(len(HYDRAULIC_STATES))
    settle(rig.parameters, state, start_position, *pressures)
    before = state.copy()
    nodes = np.full(N, temperature)
    points, temperatures = np.zeros(n, OPERATING_DTYPE), np.empty((n, N))
    lost = free_run(rig.parameters, state, nodes, command, np.full(n, ambient), INTERVAL, step, np.full(n, np.nan), points, temperatures)
    return points, temperatures, before, state, lost
