"""Soft sensor: what measured pressures, speed and current say about losses, flows and heat.

Each interval of telemetry becomes one operating point. Valve flows are not measured: the check
valves give what the cylinder took in beyond what the pump delivered while a side lay at tank
pressure or below; the relief valve follows its law at the measured pressure.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics import hydraulics
from ddh_twin_py.physics.balance import add_further_heat, add_hydraulics, add_motor, clear, motor_current
from ddh_twin_py.physics.compiled import equation, kernel
from ddh_twin_py.physics.cylinder import piston_area, rod_side_area
from ddh_twin_py.physics.motor import iron_coefficients, magnet_factor
from ddh_twin_py.physics.thermal_network import (
    N,
    N_EDGES,
    N_SURFACES,
    N_WALLS,
    ROTOR,
    capacities,
    conductances,
    network_step,
    winding_resistance,
)
from ddh_twin_py.physics.valves import relief_flow

MEASURED_FIELDS = (
    "speed_command", "speed", "acceleration", "torque", "current", "current_square", "voltage", "electrical_power",
    "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity", "drive_age", "hydraulic_age",
    "standstill",
)
MEASURED_DTYPE = np.dtype([(name, np.float64) for name in MEASURED_FIELDS])
"""Telemetry of one interval, means in SI; ages (s) of the newest samples, time at standstill (s)."""

SUCTION_BELOW = 1.5e5
"""Pa gauge: a side that reads less can be fed by its check valve: 0.3 bar below the tank, with three deviations of a transducer's zero."""


@equation
def make_up_flow(pressure, wanted, delivered):
    """Flow through a check valve by continuity, m3/s: max(0, wanted - delivered) where pressure (Pa gauge) is below `SUCTION_BELOW`."""
    return max(0.0, wanted - delivered) if pressure < SUCTION_BELOW else 0.0


@equation
def operating_point(point, m, temperature, iron, p):
    """Fill one operating point from the means ``m`` over an interval (a row of `MEASURED_DTYPE`).

    ``temperature`` in K, (N,); ``iron`` from `motor.iron_coefficients`.

    Torque, current, voltage and power are those that the model expects from pressures and
    speed; the copper loss is that of the measured current.
    """
    clear(point)
    c = hydraulics.coefficients(temperature, m.pressure_piston_side, m.pressure_rod_side, p)
    magnets = magnet_factor(temperature[ROTOR], p)
    resistance = winding_resistance(temperature, p)
    flow_1, flow_2, _, _ = hydraulics.pump_flows(m.speed, m.pressure_piston_side, m.pressure_rod_side, c, p)
    pump_torque = add_hydraulics(
        point, 1.0, m.speed, m.pressure_piston_side, m.pressure_rod_side, m.rod_velocity, m.rod_position,
        make_up_flow(m.pressure_piston_side, piston_area(p) * m.rod_velocity, flow_1),
        make_up_flow(m.pressure_rod_side, -rod_side_area(p) * m.rod_velocity, flow_2),
        relief_flow(m.pressure_rod_side, p), c, p,
    )
    current = motor_current(m.speed, m.acceleration, pump_torque, magnets * p.motor_torque_constant, p)
    add_motor(point, 1.0, m.speed, current, resistance, magnets, iron, p)
    add_further_heat(point, p)
    point.mean_square_current = m.current_square
    point.loss_copper = 3.0 * resistance * m.current_square


@kernel
def soft_sensor(params, measured, better_temperature, use_better, interval, temperature, ambient, points, temperatures):
    """Run over consecutive intervals, in place on temperature (N, K), the network without sensors.

    Args:
        measured: means of each interval, shape (n,), see `MEASURED_DTYPE`; a pressure,
            velocity or position that nobody measured is filled in by the caller.
        better_temperature: K, shape (N,), better known temperatures for viscosity and
            resistance; taken where ``use_better`` is true, else the network's own.
        ambient: K, shape (n,). interval: s.
        points, temperatures: out, as in `free_run`.
    Returns:
        heat lost to ambient, J.
    """
    p = params[0]
    edge, wall, surface = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3))
    capacity, work = np.empty(N), np.empty((N + 3, N))
    conductances(params, edge, wall, surface)
    iron = iron_coefficients(p)
    lost = 0.0
    for k in range(points.shape[0]):
        m = measured[k]
        operating_point(points[k], m, better_temperature if use_better else temperature, iron, p)
        capacities(params, m.rod_position, capacity)
        lost += network_step(
            params, edge, wall, surface, capacity, temperature, ambient[k] + p.surroundings_enclosure_rise, points[k].heat,
            points[k].mean_square_current, points[k].flow, interval, work,
        )
        temperatures[k] = temperature
    return lost
