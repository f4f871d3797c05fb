"""The thermal network of the whole unit: motor, oil, solids, ambient.

Nodes carry a heat capacity; edges conduct; oil carries its enthalpy along with the flow; five
surfaces lose heat to ambient by natural convection and radiation, two line walls by a fixed
conductance. The network is a table of nodes and edges, so that a further path is one more row.

C_i dT_i/dt = P_i + sum_j G_ij (T_j - T_i) + rho c sum_(flows k to i) Q_k (T_from(k) - T_i) - G_ia (T_i - T_a)
              - A_i (h_i |dT|^1.25 sign(dT) + eps_i sigma (T_i^4 - T_a^4)),  dT = T_i - T_a

C heat capacity J/K, P heat W, G conductance W/K, Q flow m3/s, A area m2, h convection W/(m2 K^1.25), T in K.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.physics import cylinder
from ddh_twin_py.physics.compiled import equation, kernel
from ddh_twin_py.physics.motor import phase_resistance, resistance_factor
from ddh_twin_py.physics.network_elimination import factorise, solve
from ddh_twin_py.physics.oil import volumetric_heat_capacity

MIXED = 1.0e-5
"""K/W between the layers of a tank that is mixed."""
STEFAN_BOLTZMANN = 5.670374419e-8
"""W/(m2*K^4)"""

NODES = (
    "slot_winding", "end_winding", "teeth", "rotor", "yoke", "housing",
    "line_a_wall", "line_b_wall", "tank_wall", "valve_block", "valve_oil",
    "chamber_a_oil", "chamber_b_oil", "cylinder_barrel", "line_a_oil", "line_b_oil",
    "pump_1_case", "pump_2_case", "pump_1_oil", "pump_2_oil", "tank_oil_top", "tank_oil",
)
"""Thermal nodes in the order of every temperature array; leaves first, so that elimination fills little."""

N = len(NODES)
(SLOT_WINDING, END_WINDING, TEETH, ROTOR, YOKE, HOUSING,
 LINE_A_WALL, LINE_B_WALL, TANK_WALL, VALVE_BLOCK, VALVE_OIL,
 CHAMBER_A, CHAMBER_B, BARREL, LINE_A, LINE_B,
 PUMP_1_CASE, PUMP_2_CASE, PUMP_1_OIL, PUMP_2_OIL, TANK_TOP, TANK) = range(N)
"""Oil returns into the tank's upper layer and is drawn from the lower, which is `TANK`."""

MOTOR_NODES = NODES[:6]
HYDRAULIC_NODES = NODES[6:]

EDGES = (
    ("motor.thermal.slot_to_end_winding", SLOT_WINDING, END_WINDING),
    ("motor.thermal.slot_to_teeth", SLOT_WINDING, TEETH),
    ("motor.thermal.end_winding_to_housing", END_WINDING, HOUSING),
    ("motor.thermal.teeth_to_yoke", TEETH, YOKE),
    ("motor.thermal.teeth_to_rotor", TEETH, ROTOR),
    ("motor.thermal.yoke_to_housing", YOKE, HOUSING),
    ("motor.thermal.rotor_to_housing", ROTOR, HOUSING),
    ("pump_1.oil_to_case", PUMP_1_OIL, PUMP_1_CASE),
    ("pump_2.oil_to_case", PUMP_2_OIL, PUMP_2_CASE),
    ("pump_case_link", PUMP_1_CASE, PUMP_2_CASE),
    ("line_a.oil_to_wall", LINE_A, LINE_A_WALL),
    ("line_b.oil_to_wall", LINE_B, LINE_B_WALL),
    ("cylinder.oil_to_barrel_piston_side", CHAMBER_A, BARREL),
    ("cylinder.oil_to_barrel_rod_side", CHAMBER_B, BARREL),
    ("tank.oil_to_wall", TANK, TANK_WALL),
    ("tank.oil_to_wall", TANK_TOP, TANK_WALL),
    ("tank.mixing_resistance", TANK_TOP, TANK),
    ("valve_block.oil_to_block", VALVE_OIL, VALVE_BLOCK),
    ("motor.flange_conductance", HOUSING, PUMP_1_CASE),
)
"""Conducting edges: path of the conductance in the sheet (W/K), and the two nodes. The tank's
layers share the wall by their volumes and are tied by the inverse of their resistance."""

SURFACES = (
    ("motor.thermal.housing_area", "motor.thermal.housing_convection", "motor.thermal.housing_emissivity", HOUSING),
    ("pump_1.case_area", "pump_1.convection", "pump_1.emissivity", PUMP_1_CASE),
    ("pump_2.case_area", "pump_2.convection", "pump_2.emissivity", PUMP_2_CASE),
    ("cylinder.barrel_area", "cylinder.convection", "cylinder.emissivity", BARREL),
    ("tank.area", "tank.convection", "tank.emissivity", TANK_WALL),
)
"""Surfaces in natural convection and radiation: area (m2), convection (W/(m2 K^1.25)), emissivity (1), node."""

WALLS = (
    ("line_a.wall_to_ambient", LINE_A_WALL),
    ("line_b.wall_to_ambient", LINE_B_WALL),
    ("valve_block.block_to_ambient", VALVE_BLOCK),
    ("tank.mount_conductance", TANK_WALL),
)
"""Nodes that lose heat to ambient by a fixed conductance (W/K)."""

CAPACITIES = (
    ("motor.thermal.slot_winding_capacity", SLOT_WINDING),
    ("motor.thermal.end_winding_capacity", END_WINDING),
    ("motor.thermal.teeth_capacity", TEETH),
    ("motor.thermal.rotor_capacity", ROTOR),
    ("motor.thermal.yoke_capacity", YOKE),
    ("motor.thermal.housing_capacity", HOUSING),
    ("line_a.wall_capacity", LINE_A_WALL),
    ("line_b.wall_capacity", LINE_B_WALL),
    ("tank.wall_capacity", TANK_WALL),
    ("cylinder.barrel_capacity", BARREL),
    ("pump_1.case_capacity", PUMP_1_CASE),
    ("pump_2.case_capacity", PUMP_2_CASE),
    ("valve_block.capacity", VALVE_BLOCK),
)
"""Heat capacities of the solids, J/K."""

FLOWS = (
    ("tank", "pump_1", TANK, PUMP_1_OIL), ("pump_1", "tank", PUMP_1_OIL, TANK_TOP),
    ("pump_1", "line_a", PUMP_1_OIL, LINE_A), ("line_a", "pump_1", LINE_A, PUMP_1_OIL),
    ("line_a", "chamber_a", LINE_A, CHAMBER_A), ("chamber_a", "line_a", CHAMBER_A, LINE_A),
    ("tank", "line_a", TANK, LINE_A),
    ("tank", "pump_2", TANK, PUMP_2_OIL), ("pump_2", "tank", PUMP_2_OIL, TANK_TOP),
    ("pump_2", "line_b", PUMP_2_OIL, LINE_B), ("line_b", "pump_2", LINE_B, PUMP_2_OIL),
    ("line_b", "chamber_b", LINE_B, CHAMBER_B), ("chamber_b", "line_b", CHAMBER_B, LINE_B),
    ("tank", "line_b", TANK, LINE_B),
    ("line_b", "valve", LINE_B, VALVE_OIL), ("valve", "tank", VALVE_OIL, TANK_TOP),
    ("chamber_a", "chamber_b", CHAMBER_A, CHAMBER_B), ("chamber_b", "chamber_a", CHAMBER_B, CHAMBER_A),
    ("tank_top", "tank", TANK_TOP, TANK),
    ("tank_top", "pump_1", TANK_TOP, PUMP_1_OIL), ("tank_top", "pump_2", TANK_TOP, PUMP_2_OIL),
)
"""Oil flows between control volumes, each counted in its own direction, m3/s, not below zero."""
FLOW_PATHS = tuple(f"{flow[0]}>{flow[1]}" for flow in FLOWS)
"""Their names in messages."""

N_EDGES, N_SURFACES, N_WALLS, N_FLOWS = len(EDGES), len(SURFACES), len(WALLS), len(FLOWS)
_EDGE_I = np.array([edge[1] for edge in EDGES])
_EDGE_J = np.array([edge[2] for edge in EDGES])
_SURFACE_NODE = np.array([surface[3] for surface in SURFACES])
_WALL_NODE = np.array([wall[1] for wall in WALLS])
_FLOW_FROM = np.array([flow[2] for flow in FLOWS])
_FLOW_TO = np.array([flow[3] for flow in FLOWS])

_GAMMA = 1.0 - 1.0 / np.sqrt(2.0)


@kernel
def conductances(params, edge, wall, surface):
    """Fill edge (N_EDGES) and wall (N_WALLS) conductances, W/K, and surface (N_SURFACES, 3) as in `SURFACES`."""
    p = params[0]
    edge[0] = p.motor_slot_to_end_winding
    edge[1] = p.motor_slot_to_teeth
    edge[2] = p.motor_end_winding_to_housing
    edge[3] = p.motor_teeth_to_yoke
    edge[4] = p.motor_teeth_to_rotor
    edge[5] = p.motor_yoke_to_housing
    edge[6] = p.motor_rotor_to_housing
    edge[7] = p.pump_1_oil_to_case
    edge[8] = p.pump_2_oil_to_case
    edge[9] = p.pump_case_link
    edge[10] = p.line_a_oil_to_wall
    edge[11] = p.line_b_oil_to_wall
    edge[12] = p.cylinder_oil_to_barrel_piston_side
    edge[13] = p.cylinder_oil_to_barrel_rod_side
    edge[14] = p.tank_oil_to_wall * (1.0 - p.tank_top_share)
    edge[15] = p.tank_oil_to_wall * p.tank_top_share
    edge[16] = 1.0 / (p.tank_mixing_resistance + MIXED)
    edge[17] = p.valve_block_oil_to_block
    edge[18] = p.motor_flange_conductance
    wall[0] = p.line_a_wall_to_ambient
    wall[1] = p.line_b_wall_to_ambient
    wall[2] = p.valve_block_block_to_ambient
    wall[3] = p.tank_mount_conductance
    surface[0, 0], surface[0, 1], surface[0, 2] = p.motor_housing_area, p.motor_housing_convection, p.motor_housing_emissivity
    surface[1, 0], surface[1, 1], surface[1, 2] = p.pump_1_case_area, p.pump_1_convection, p.pump_1_emissivity
    surface[2, 0], surface[2, 1], surface[2, 2] = p.pump_2_case_area, p.pump_2_convection, p.pump_2_emissivity
    surface[3, 0], surface[3, 1], surface[3, 2] = p.cylinder_barrel_area, p.cylinder_convection, p.cylinder_emissivity
    surface[4, 0], surface[4, 1], surface[4, 2] = p.tank_area, p.tank_convection, p.tank_emissivity


@kernel
def capacities(params, position, capacity):
    """Fill capacity (N), J/K, for a rod position, m: chambers and tank hold what the piston leaves them.

    Oil: rho c V; the tank's upper layer max(s V - (A_A - A_B) x, s V/10), the lower (1 - s) V, s ``tank.top_share``.
    """
    p = params[0]
    rho_c = volumetric_heat_capacity(p)
    capacity[SLOT_WINDING] = p.motor_slot_winding_capacity
    capacity[END_WINDING] = p.motor_end_winding_capacity
    capacity[TEETH] = p.motor_teeth_capacity
    capacity[ROTOR] = p.motor_rotor_capacity
    capacity[YOKE] = p.motor_yoke_capacity
    capacity[HOUSING] = p.motor_housing_capacity
    capacity[LINE_A_WALL] = p.line_a_wall_capacity
    capacity[LINE_B_WALL] = p.line_b_wall_capacity
    capacity[TANK_WALL] = p.tank_wall_capacity
    capacity[BARREL] = p.cylinder_barrel_capacity
    capacity[PUMP_1_CASE] = p.pump_1_case_capacity
    capacity[PUMP_2_CASE] = p.pump_2_case_capacity
    capacity[VALVE_BLOCK] = p.valve_block_capacity
    within = min(max(position, 0.0), p.cylinder_stroke)
    capacity[CHAMBER_A] = rho_c * cylinder.chamber_volume_piston_side(within, p)
    capacity[CHAMBER_B] = rho_c * cylinder.chamber_volume_rod_side(within, p)
    capacity[LINE_A] = rho_c * p.line_a_volume
    capacity[LINE_B] = rho_c * p.line_b_volume
    capacity[PUMP_1_OIL] = rho_c * p.pump_1_oil_volume
    capacity[PUMP_2_OIL] = rho_c * p.pump_2_oil_volume
    drawn = (cylinder.piston_area(p) - cylinder.rod_side_area(p)) * within
    upper = p.tank_top_share * p.tank_oil_volume  # what is drawn below sinks from above: the upper layer alone grows and shrinks
    capacity[TANK_TOP] = rho_c * max(upper - drawn, 0.1 * upper)
    capacity[TANK] = rho_c * (p.tank_oil_volume - upper)
    capacity[VALVE_OIL] = rho_c * p.valve_block_oil_volume


@equation
def copper_loss(temperature, mean_square_current, p):
    """Copper loss in slot and end winding, W (paper, eq. 1 and 2): 3 R_20 (1 + alpha (T - 20 degC)) i^2 by their shares.

    ``temperature`` in K, (N,); ``mean_square_current`` in A^2, of the rms phase current.
    """
    total = 3.0 * p.motor_phase_resistance_20C * mean_square_current
    share = p.motor_end_winding_copper_share
    slot = (1.0 - share) * total * resistance_factor(temperature[SLOT_WINDING], p)
    end = share * total * resistance_factor(temperature[END_WINDING], p)
    return slot, end


@equation
def winding_resistance(temperature, p):
    """Phase resistance at the network's winding temperatures, ohm."""
    return phase_resistance(temperature[SLOT_WINDING], temperature[END_WINDING], p)


@equation
def surface_loss(temperature, ambient, area, convection, emissivity):
    """Heat from a surface to ambient, W: A (h |dT|^1.25 sign(dT) + eps sigma (T^4 - T_a^4)).

    Temperatures in K, numbers or arrays (n,), ``area`` A in m2, ``convection`` h in W/(m2*K^1.25), ``emissivity`` eps.
    """
    difference = temperature - ambient
    natural = convection * difference * np.sqrt(np.sqrt(np.abs(difference)))
    return area * (natural + emissivity * STEFAN_BOLTZMANN * (temperature**4 - ambient**4))


@kernel
def network_rates(params, edge, wall, surface, capacity, temperature, ambient, heat, mean_square_current, flow, rate):
    """Fill rate (N), K/s.

    Args:
        params: the rig's parameters, shape (1,).
        edge, wall, surface: see `conductances`.
        capacity: J/K, shape (N,).
        temperature: K, shape (N,). ambient: K.
        heat: W into each node, without copper loss, shape (N,).
        mean_square_current: A^2, of the rms phase current.
        flow: m3/s, shape (N_FLOWS,), see `FLOWS`.
    Returns:
        heat lost to ambient, W.
    """
    lost = _powers(params, edge, wall, surface, temperature, ambient, heat, mean_square_current, flow, rate)
    for i in range(N):
        rate[i] /= capacity[i]
    return lost


@equation
def _powers(params, edge, wall, surface, temperature, ambient, heat, mean_square_current, flow, rate):
    """What each node takes up, W, into rate (N); see `network_rates`."""
    p = params[0]
    for i in range(N):
        rate[i] = heat[i]
    slot, end = copper_loss(temperature, mean_square_current, p)
    rate[SLOT_WINDING] += slot
    rate[END_WINDING] += end
    for k in range(N_EDGES):
        q = edge[k] * (temperature[_EDGE_J[k]] - temperature[_EDGE_I[k]])
        rate[_EDGE_I[k]] += q
        rate[_EDGE_J[k]] -= q
    rho_c = volumetric_heat_capacity(p)
    for k in range(N_FLOWS):
        rate[_FLOW_TO[k]] += rho_c * flow[k] * (temperature[_FLOW_FROM[k]] - temperature[_FLOW_TO[k]])
    lost = 0.0
    for k in range(N_WALLS):
        q = wall[k] * (temperature[_WALL_NODE[k]] - ambient)
        rate[_WALL_NODE[k]] -= q
        lost += q
    for k in range(N_SURFACES):
        i = _SURFACE_NODE[k]
        q = surface_loss(temperature[i], ambient, surface[k, 0], surface[k, 1], surface[k, 2])
        rate[i] -= q
        lost += q
    return lost


@kernel
def network_jacobian(params, edge, wall, surface, capacity, temperature, ambient, mean_square_current, flow, jacobian):
    """Fill jacobian (N, N), 1/s: derivative of `network_rates`, which has the same arguments, by temperature."""
    _power_slopes(params, edge, wall, surface, temperature, ambient, mean_square_current, flow, 1.0, jacobian)
    for i in range(N):
        for j in range(N):
            jacobian[i, j] /= capacity[i]


@equation
def _power_slopes(params, edge, wall, surface, temperature, ambient, mean_square_current, flow, factor, jacobian):
    """Fill jacobian (N, N): derivative of `_powers` by temperature, W/K, times a factor."""
    p = params[0]
    jacobian[:, :] = 0.0
    total = factor * 3.0 * p.motor_phase_resistance_20C * mean_square_current * p.motor_copper_temperature_coefficient
    jacobian[SLOT_WINDING, SLOT_WINDING] += (1.0 - p.motor_end_winding_copper_share) * total
    jacobian[END_WINDING, END_WINDING] += p.motor_end_winding_copper_share * total
    for k in range(N_EDGES):
        i, j, g = _EDGE_I[k], _EDGE_J[k], factor * edge[k]
        jacobian[i, i] -= g
        jacobian[i, j] += g
        jacobian[j, j] -= g
        jacobian[j, i] += g
    rho_c = factor * volumetric_heat_capacity(p)
    for k in range(N_FLOWS):
        g = rho_c * flow[k]
        jacobian[_FLOW_TO[k], _FLOW_FROM[k]] += g
        jacobian[_FLOW_TO[k], _FLOW_TO[k]] -= g
    for k in range(N_WALLS):
        jacobian[_WALL_NODE[k], _WALL_NODE[k]] -= factor * wall[k]
    for k in range(N_SURFACES):
        i = _SURFACE_NODE[k]
        natural = 1.25 * surface[k, 1] * math.sqrt(math.sqrt(abs(temperature[i] - ambient)))
        radiation = 4.0 * surface[k, 2] * STEFAN_BOLTZMANN * temperature[i] ** 3
        jacobian[i, i] -= factor * surface[k, 0] * (natural + radiation)


@kernel
def network_step(params, edge, wall, surface, capacity, temperature, ambient, heat, mean_square_current, flow, step, work):
    """Advance temperature (N) in place by step seconds under constant inputs; see `network_step_between` and `network_rates`."""
    return network_step_between(params, edge, wall, surface, capacity, temperature, ambient, heat, heat, mean_square_current, flow, flow,
                                step, work)


@kernel
def network_step_between(params, edge, wall, surface, capacity, temperature, ambient, heat_early, heat_late, mean_square_current,
                         flow_early, flow_late, step, work):
    """Advance temperature (N) in place by step seconds: ROS2, linearly implicit, second order, L-stable.

    Verwer et al., SIAM J. Sci. Comput. 20 (1999) 1456; gamma = 1 - 1/sqrt(2). ``work`` is a
    scratch array of shape (N + 3, N). Heat goes from ``heat_early`` to ``heat_late``, W, (N,), flows likewise, m3/s,
    (N_FLOWS,); the other inputs, see `network_rates`, are constant over the step.

    Returns:
        heat lost to ambient over the step, J.
    """
    # The equations are kept as (C - gamma h dP/dT) k = P, so that nothing is divided by the capacities.
    matrix, first, second, trial = work[:N], work[N], work[N + 1], work[N + 2]
    _power_slopes(params, edge, wall, surface, temperature, ambient, mean_square_current, flow_early, -_GAMMA * step, matrix)
    for i in range(N):
        matrix[i, i] += capacity[i]
    factorise(matrix)
    lost = _powers(params, edge, wall, surface, temperature, ambient, heat_early, mean_square_current, flow_early, first)
    solve(matrix, first)
    for i in range(N):
        trial[i] = temperature[i] + step * first[i]
    lost += _powers(params, edge, wall, surface, trial, ambient, heat_late, mean_square_current, flow_late, second)
    for i in range(N):
        second[i] -= 2.0 * capacity[i] * first[i]
    solve(matrix, second)
    for i in range(N):
        temperature[i] += step * (1.5 * first[i] + 0.5 * second[i])
    return 0.5 * step * lost
