"""The free run's equations as a right-hand side dy/dt = f(t, y), for solvers that choose their own steps.

Built from the functions that the kernels are made of. Differences to the kernel's problem, the
same for every solver: dry friction acts with v/sqrt(v^2 + e^2) in place of its sign, since these
solvers know no set-valued force; the drive follows its command without the current limit (the
cycle timed here stays below it); viscosities follow temperature within an interval too.

State, scaled so that one tolerance serves all: pressures and chamber motion by `SCALE`,
temperatures as the rise over the start in kelvin.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE, add_further_heat, add_hydraulics, add_motor, clear, motor_current
from ddh_twin_py.physics.compiled import inlined, kernel
from ddh_twin_py.physics.cylinder import (
    END_STOP_STIFFNESS,
    chamber_volume_piston_side,
    chamber_volume_rod_side,
    coulomb_friction,
    lifted_mass,
    load_force,
    piston_area,
    rod_side_area,
)
from ddh_twin_py.physics.hydraulics import coefficients, pump_flows
from ddh_twin_py.physics.motor import iron_coefficients, magnet_factor
from ddh_twin_py.physics.oil import VAPOUR_PRESSURE, compressibility
from ddh_twin_py.physics.thermal_network import (
    N,
    N_EDGES,
    N_SURFACES,
    N_WALLS,
    ROTOR,
    capacities,
    conductances,
    network_rates,
    winding_resistance,
)
from ddh_twin_py.physics.valves import check_flow, relief_flow

MECHANICAL = ("pressure_piston_side", "pressure_rod_side", "rod_velocity", "rod_position", "speed")
"""States before the N temperatures."""
STATES = len(MECHANICAL) + N
SCALE = (1.0e6, 1.0e6, 0.1, 0.1, 50.0)
"""Pa, Pa, m/s, m, rad/s: what 1 is of each mechanical state."""
FRICTION_WIDTH = 1.0e-4
"""m/s over which regularised dry friction changes its sign."""


@inlined
def where(condition, yes, no):
    """One of two values; a function so that a symbolic version can stand in for it."""
    return yes if condition else no


@inlined
def derivatives(y, start, command, command_rate, ambient, params, point, edge, wall, surface, capacity, temperature, rate, out):
    """Fill out (STATES) with dy/dt.

    Args:
        y: scaled state, (STATES,). start: K, temperature at which the rises begin.
        command: rad/s. command_rate: rad/s2. ambient: K.
        params: (1,). point: scratch, one operating point. edge, wall, surface: of `conductances`.
        capacity, temperature, rate: scratch, (N,).
    """
    p = params[0]
    raw_a, raw_b = y[0] * SCALE[0], y[1] * SCALE[1]
    velocity, position, speed = y[2] * SCALE[2], y[3] * SCALE[3], y[4] * SCALE[4]
    for i in range(N):
        temperature[i] = start + y[5 + i]
    pressure_a, pressure_b = max(raw_a, VAPOUR_PRESSURE), max(raw_b, VAPOUR_PRESSURE)
    c = coefficients(temperature, pressure_a, pressure_b, p)
    check_a, check_b, relief = check_flow(pressure_a, p), check_flow(pressure_b, p), relief_flow(pressure_b, p)
    acceleration = (command - speed) / p.motor_speed_loop_time_constant

    flow_1, flow_2, _, _ = pump_flows(speed, pressure_a, pressure_b, c, p)
    through = p.cylinder_cross_leakage * (pressure_a - pressure_b)
    within = min(max(position, 0.0), p.cylinder_stroke)
    middle = 0.5 * p.cylinder_stroke
    volume_a = p.line_a_volume + chamber_volume_piston_side(where(raw_a > VAPOUR_PRESSURE, within, middle), p)
    volume_b = p.line_b_volume + chamber_volume_rod_side(where(raw_b > VAPOUR_PRESSURE, within, middle), p)
    net_a = flow_1 + check_a - through - piston_area(p) * velocity
    net_b = flow_2 + check_b - relief + through + rod_side_area(p) * velocity
    dry = coulomb_friction(velocity, pressure_a - pressure_b, p)
    direction = velocity / math.sqrt(velocity * velocity + FRICTION_WIDTH * FRICTION_WIDTH)
    stop = END_STOP_STIFFNESS * (min(position, 0.0) + max(position - p.cylinder_stroke, 0.0))
    force = (pressure_a * piston_area(p) - pressure_b * rod_side_area(p) - load_force(position, p)
             - p.cylinder_friction_viscous * velocity - stop - dry * direction)
    out[0] = net_a / (compressibility(raw_a, p) * volume_a) / SCALE[0]
    out[1] = net_b / (compressibility(raw_b, p) * volume_b + p.line_b_compliance) / SCALE[1]
    out[2] = force / lifted_mass(p) / SCALE[2]
    out[3] = velocity / SCALE[3]
    out[4] = acceleration / SCALE[4]

    clear(point)
    magnets, resistance, iron = magnet_factor(temperature[ROTOR], p), winding_resistance(temperature, p), iron_coefficients(p)
    torque = add_hydraulics(point, 1.0, speed, pressure_a, pressure_b, velocity, position, check_a, check_b, relief, c, p)
    current = motor_current(speed, acceleration, torque, magnets * p.motor_torque_constant, p)
    add_motor(point, 1.0, speed, current, resistance, magnets, iron, p)
    add_further_heat(point, p)
    capacities(params, position, capacity)
    network_rates(params, edge, wall, surface, capacity, temperature, ambient + p.surroundings_enclosure_rise, point.heat,
                  point.mean_square_current, point.flow, rate)
    for i in range(N):
        out[5 + i] = rate[i]


WORK = N_EDGES + N_WALLS + 3 * N_SURFACES + 3 * N
"""Numbers of scratch that a right-hand side needs."""


class Problem:
    """A run of the continuous model: parameters, command and scratch, kept alive for compiled callbacks.

    Args:
        params: (1,). command: rad/s at the edges of equal periods, (n + 1,), linear in between.
        period: s. start: K, of every node and of ambient. state: `hydraulics.HYDRAULIC_STATES` at the start.
    """

    def __init__(self, params: np.ndarray, command: np.ndarray, period: float, start: float, state: np.ndarray) -> None:
        self.params, self.command, self.period, self.start = params, np.ascontiguousarray(command), period, start
        self.point, self.work = np.zeros(1, OPERATING_DTYPE), np.zeros(WORK)
        edge, wall = self.work[:N_EDGES], self.work[N_EDGES:N_EDGES + N_WALLS]
        surface = self.work[N_EDGES + N_WALLS:N_EDGES + N_WALLS + 3 * N_SURFACES].reshape(N_SURFACES, 3)
        conductances(params, edge, wall, surface)
        self.initial = np.zeros(STATES)
        self.initial[:5] = np.array([state[2], state[3], state[4], state[5], state[1]]) / SCALE
        self.times = np.arange(command.size) * period

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """dy/dt, compiled; what scipy calls."""
        out = np.empty(STATES)
        rates(t, y, self.command, self.period, self.start, self.params, self.point, self.work, out)
        return out


@kernel
def rates(t, y, command, period, start, params, point, work, out):
    """Fill out (STATES) with dy/dt at time t (s); see `Problem`."""
    at = min(int(t / period), command.shape[0] - 2)
    slope = (command[at + 1] - command[at]) / period
    second = N_EDGES + N_WALLS
    third = second + 3 * N_SURFACES
    derivatives(
        y, start, command[at] + slope * (t - at * period), slope, start, params, point[0], work[:N_EDGES], work[N_EDGES:second],
        work[second:third].reshape((N_SURFACES, 3)), work[third:third + N], work[third + N:third + 2 * N], work[third + 2 * N:], out,
    )
