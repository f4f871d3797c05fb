"""Free run: the whole unit from speed command, payload and ambient, at a fixed step."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.balance import add_hydraulics, add_motor, clear, shaft_torque
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.physics.hydraulics import POSITION, PRESSURE_A, PRESSURE_B, SPEED, SPEED_REFERENCE, VELOCITY, coefficients, hydraulic_step
from ddh_twin_py.physics.thermal_network import (
    N, N_EDGES, N_SURFACES, N_WALLS, capacities, conductances, network_step, winding_resistance,
)
from ddh_twin_py.physics.valves import check_flow, relief_flow

HYDRAULIC_STEP = 1.0e-3
"""s, default step of pressures, piston and shaft; the thermal network moves once per interval."""


@kernel
def free_run(params, state, temperature, command, ambient, interval, step, measured_position, points, temperatures):
    """Run over consecutive intervals, in place on state (6) and temperature (N, K).

    Args:
        params: parameters, shape (1,).
        command: speed command at the n+1 edges of the intervals, rad/s; linear in between.
        ambient: K, per interval, shape (n,).
        interval: s. step: s, wanted hydraulic step; a whole number of them fills an interval.
        measured_position: m, per interval; where finite, the rod is put there before the
            interval (the free run at a standstill); NaN leaves it.
        points: out, operating points, shape (n,), see `balance.OPERATING_DTYPE`.
        temperatures: out, at the end of each interval, K, shape (n, N).
    Returns:
        heat lost to ambient, J.
    """
    p = params[0]
    edge, wall, surface = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3))
    capacity, work = np.empty(N), np.empty((N + 3, N))
    conductances(params, edge, wall, surface)
    count = max(1, int(round(interval / step)))
    h = interval / count
    lost = 0.0
    for k in range(points.shape[0]):
        if np.isfinite(measured_position[k]):
            state[POSITION] = measured_position[k]
        before = state[POSITION]
        point = points[k]
        clear(point)
        c = coefficients(temperature, p)
        resistance = winding_resistance(temperature, p)
        slope = (command[k + 1] - command[k]) / interval
        for m in range(count):
            early, late = hydraulic_step(state, command[k] + slope * (m * h), slope, h, c, p)
            for weight, speed, acceleration, pressure_a, pressure_b, velocity, position in (early, late):
                share = weight / count
                torque = shaft_torque(speed, acceleration, pressure_a, pressure_b, c, p)
                add_motor(point, share, speed, torque / p.motor_torque_constant, resistance, p)
                add_hydraulics(
                    point, share, speed, pressure_a, pressure_b, velocity, position,
                    check_flow(pressure_a, p), check_flow(pressure_b, p), relief_flow(pressure_b, p), c, p,
                )
        capacities(params, 0.5 * (before + state[POSITION]), capacity)
        lost += network_step(
            params, edge, wall, surface, capacity, temperature, ambient[k], point.heat,
            point.mean_square_current, point.flow, interval, work,
        )
        temperatures[k] = temperature
    return lost


@kernel
def settle(params, state, position, pressure_a, pressure_b):
    """Set the hydraulic state (6) to rest at measured pressures (Pa) and position (m)."""
    state[SPEED_REFERENCE] = 0.0
    state[SPEED] = 0.0
    state[PRESSURE_A] = pressure_a
    state[PRESSURE_B] = pressure_b
    state[VELOCITY] = 0.0
    state[POSITION] = position
