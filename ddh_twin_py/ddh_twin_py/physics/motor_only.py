"""The motor alone: losses and network from measured current and speed."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.balance import add_further_heat, add_motor, clear
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.physics.motor import iron_coefficients, magnet_factor
from ddh_twin_py.physics.thermal_network import (
    N,
    N_EDGES,
    N_FLOWS,
    N_SURFACES,
    N_WALLS,
    ROTOR,
    capacities,
    conductances,
    network_step,
    winding_resistance,
)


@kernel
def motor_only(params, speed, current, current_square, ambient, interval, temperature, points, temperatures):
    """Run over consecutive intervals, in place on temperature (N, K).

    The whole network is stepped with the hydraulics at rest; the motor shares no path with them (but a flange, where a rig file has one).

    Args:
        speed (rad/s), current (A), current_square (A^2): means of each interval, (n,).
        ambient: K, (n,). interval: s.
        points: out, operating points (n,), motor fields alone. temperatures: out, K, (n, N).
    """
    p = params[0]
    edge, wall, surface = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3))
    capacity, work, flow = np.empty(N), np.empty((N + 3, N)), np.zeros(N_FLOWS)
    conductances(params, edge, wall, surface)
    capacities(params, 0.0, capacity)
    iron = iron_coefficients(p)
    for k in range(points.shape[0]):
        clear(points[k])
        resistance = winding_resistance(temperature, p)
        add_motor(points[k], 1.0, speed[k], current[k], resistance, magnet_factor(temperature[ROTOR], p), iron, p)
        add_further_heat(points[k], p)
        points[k].mean_square_current = current_square[k]
        points[k].loss_copper = 3.0 * resistance * current_square[k]
        network_step(
            params, edge, wall, surface, capacity, temperature, ambient[k] + p.surroundings_enclosure_rise, points[k].heat,
            current_square[k], flow, interval, work,
        )
        temperatures[k] = temperature
