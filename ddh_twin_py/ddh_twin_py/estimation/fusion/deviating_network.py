"""The thermal network with the filter's deviations applied: conductances, heat capacities, heat into the nodes.

Deviations are those of `uncertain_parameters`, relative but for temperatures and unknown heats.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.estimation.fusion.uncertain_parameters import (
    CAPACITY_AT,
    CAPACITY_NODES,
    EDGE_AT,
    END_SHARE_AT,
    N_PUMP_LOSS,
    N_SPLIT,
    N_UNKNOWN_HEATS,
    PUMP_LOSS_AT,
    SPLIT_AT,
    SPLIT_SHARE,
    SPLIT_SOURCE,
    SURFACE_AT,
    TANK_CAPACITY,
    UNKNOWN_HEAT_AT,
    UNKNOWN_HEAT_SHARE,
    WALL_AT,
)
from ddh_twin_py.physics.compiled import equation, kernel
from ddh_twin_py.physics.oil import viscosity_ratio
from ddh_twin_py.physics.thermal_network import (
    BARREL,
    CHAMBER_A,
    CHAMBER_B,
    END_WINDING,
    HOUSING,
    LINE_A,
    LINE_B,
    N,
    N_EDGES,
    N_SURFACES,
    N_WALLS,
    PUMP_1_CASE,
    PUMP_1_OIL,
    PUMP_2_CASE,
    PUMP_2_OIL,
    ROTOR,
    SLOT_WINDING,
    TANK_TOP,
    TEETH,
    YOKE,
    capacities,
    conductances,
    copper_loss,
)

_HEAT_NODES = (
    np.array([SLOT_WINDING, END_WINDING]), np.array([TEETH, YOKE]), np.array([ROTOR]),
    np.array([BARREL, CHAMBER_A, CHAMBER_B]), np.array([LINE_A]), np.array([LINE_B]),
)
PUMP_CASE, PUMP_OIL = np.array([PUMP_1_CASE, PUMP_2_CASE]), np.array([PUMP_1_OIL, PUMP_2_OIL])
GROUP_OF_NODE = np.full(N, -1)
"""Which of the first deviations scales a node's own heat; -1: none."""
for _group, _nodes in enumerate(_HEAT_NODES):
    GROUP_OF_NODE[_nodes] = _group


@kernel
def scaled_network(params, deviation, edge, wall, surface):
    """Conductances of the network with the filter's deviations (N_UNCERTAIN) applied."""
    conductances(params, edge, wall, surface)
    for k in range(N_EDGES):
        edge[k] *= 1.0 + deviation[EDGE_AT + k]
    for k in range(N_WALLS):
        wall[k] *= 1.0 + deviation[WALL_AT + k]
    for k in range(N_SURFACES):
        surface[k, 1] *= 1.0 + deviation[SURFACE_AT + k]
        surface[k, 2] *= 1.0 + deviation[SURFACE_AT + k]


@kernel
def scaled_capacity(params, deviation, position, capacity):
    """Heat capacities with the filter's deviations applied."""
    capacities(params, position, capacity)
    for k in range(CAPACITY_NODES.shape[0]):
        capacity[CAPACITY_NODES[k]] *= 1.0 + deviation[CAPACITY_AT + k]
    capacity[TANK_TOP] *= 1.0 + deviation[TANK_CAPACITY]


@equation
def _parts(case, oil, share, drawn, returned, displacement, leakage, constant, viscous, ratio):
    """What the heat of a pump's case and oil, W, is made of: friction with pressure, friction with speed, leakage, W.

    The case has its share of the friction, the oil the rest and the leakage, L (mu_0/mu) p^2 = Q_leak^2 mu/(L mu_0). The part with speed
    is |w| (T_0 + b mu/mu_0 |w|), |w| = 2 pi swept/D; a pump sweeps what it draws from the tank, or returns to it beside the leakage.

    Args:
        case, oil: W. drawn, returned: m3/s. displacement: m3/rev. leakage: L, m3/(s*Pa). ratio: mu/mu_0.
    """
    friction = min(case / max(share, 0.05), case + oil)
    leaking = math.sqrt(max(case + oil - friction, 0.0) * leakage / ratio)
    speed = 2.0 * math.pi * (drawn + max(returned - leaking, 0.0)) / displacement
    with_speed = min(speed * (constant + viscous * ratio * speed), max(friction, 0.0))
    return friction - with_speed, with_speed, case + oil - friction


@equation
def pump_parts(k, temperature, heat, flow, p):
    """`_parts` of pump k (0, 1)."""
    if k == 0:
        return _parts(heat[PUMP_1_CASE], heat[PUMP_1_OIL], p.pump_1_friction_share_to_case, flow[0] + flow[19], flow[1],
                      p.pump_1_displacement, p.pump_1_leakage, p.pump_1_friction_constant, p.pump_1_friction_viscous,
                      viscosity_ratio(temperature[PUMP_1_OIL], p))
    return _parts(heat[PUMP_2_CASE], heat[PUMP_2_OIL], p.pump_2_friction_share_to_case, flow[7] + flow[20], flow[8],
                  p.pump_2_displacement, p.pump_2_leakage, p.pump_2_friction_constant, p.pump_2_friction_viscous,
                  viscosity_ratio(temperature[PUMP_2_OIL], p))


@kernel
def scaled_heat(params, deviation, temperature, heat, square, flow, out):
    """Heat into the nodes, W, (N,), with the filter's deviations and unknown heats; motor friction warms rotor and housing alike.

    Of the copper loss, which the network works out itself, it holds only what goes to the end winding in place of the slot.
    """
    p = params[0]
    for i in range(N):
        group = GROUP_OF_NODE[i]
        out[i] = heat[i] * (1.0 + deviation[group]) if group >= 0 else heat[i]
    out[HOUSING] = heat[HOUSING] * (1.0 + deviation[2])
    for k in range(N_SPLIT):
        change = deviation[SPLIT_AT + k] * heat[SPLIT_SOURCE[k]]
        for i in range(N):
            out[i] += SPLIT_SHARE[k, i] * change
    for k in range(2):
        share, at = case_share(k, p), PUMP_LOSS_AT + k * N_PUMP_LOSS
        with_pressure, with_speed, leakage = pump_parts(k, temperature, heat, flow, p)
        friction = deviation[at] * with_pressure + deviation[at + 1] * with_speed
        out[PUMP_CASE[k]] += share * friction
        out[PUMP_OIL[k]] += (1.0 - share) * friction + deviation[at + 2] * leakage
    slot, end = copper_loss(temperature, square * (1.0 + deviation[0]), p)
    out[END_WINDING] += deviation[END_SHARE_AT] * end
    out[SLOT_WINDING] -= deviation[END_SHARE_AT] * slot * of_the_rest(p)
    for k in range(N_UNKNOWN_HEATS):
        for i in range(N):
            out[i] += UNKNOWN_HEAT_SHARE[k, i] * deviation[UNKNOWN_HEAT_AT + k]


@equation
def case_share(k, p):
    """Share of the friction of pump k (0, 1) that heats its case."""
    return p.pump_1_friction_share_to_case if k == 0 else p.pump_2_friction_share_to_case


@equation
def of_the_rest(p):
    """The end winding's share of the copper loss over the slot's."""
    return p.motor_end_winding_copper_share / max(1.0 - p.motor_end_winding_copper_share, 1.0e-9)
