"""What the rates of the network's temperatures answer to each uncertain parameter: the filter's B, in closed form."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fusion.deviating_network import GROUP_OF_NODE, PUMP_CASE, PUMP_OIL, case_share, of_the_rest, pump_parts
from ddh_twin_py.estimation.fusion.uncertain_parameters import (
    AMBIENT_AT,
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
from ddh_twin_py.physics.compiled import equation
from ddh_twin_py.physics.thermal_network import (
    EDGES,
    END_WINDING,
    HOUSING,
    N,
    N_EDGES,
    N_SURFACES,
    N_WALLS,
    SLOT_WINDING,
    SURFACES,
    TANK_TOP,
    WALLS,
    copper_loss,
    surface_loss,
)

EDGE_I = np.array([edge[1] for edge in EDGES])
EDGE_J = np.array([edge[2] for edge in EDGES])
_SURFACE_NODE = np.array([surface[3] for surface in SURFACES])
_WALL_NODE = np.array([wall[1] for wall in WALLS])


@equation
def rate_slopes(params, deviation, edge, wall, surface, capacity, temperature, air, rate, heat, square, flow, gain):
    """Add the derivatives of the nodes' rates by the uncertain parameters, K/s per unit of each, to ``gain`` (N, N_UNCERTAIN).

    Args:
        edge, wall, surface, capacity: with the deviations applied. air: K. rate: of the nodes, K/s, (N,). heat: W, (N,), square: A^2, both
            without deviations. flow: m3/s.
    """
    p = params[0]
    slot, end = copper_loss(temperature, square, p)
    gain[SLOT_WINDING, 0] += slot / capacity[SLOT_WINDING]
    gain[END_WINDING, 0] += end / capacity[END_WINDING]
    for i in range(N):
        group = GROUP_OF_NODE[i]
        if group >= 0:
            gain[i, group] += heat[i] / capacity[i]
    gain[HOUSING, 2] += heat[HOUSING] / capacity[HOUSING]
    for k in range(N_SPLIT):
        for i in range(N):
            gain[i, SPLIT_AT + k] += SPLIT_SHARE[k, i] * heat[SPLIT_SOURCE[k]] / capacity[i]
    for k in range(2):
        share, at = case_share(k, p), PUMP_LOSS_AT + k * N_PUMP_LOSS
        case, oil = PUMP_CASE[k], PUMP_OIL[k]
        with_pressure, with_speed, leakage = pump_parts(k, temperature, heat, flow, p)
        gain[case, at] += share * with_pressure / capacity[case]
        gain[oil, at] += (1.0 - share) * with_pressure / capacity[oil]
        gain[case, at + 1] += share * with_speed / capacity[case]
        gain[oil, at + 1] += (1.0 - share) * with_speed / capacity[oil]
        gain[oil, at + 2] += leakage / capacity[oil]
    for k in range(N_EDGES):
        i, j = EDGE_I[k], EDGE_J[k]
        q = edge[k] / (1.0 + deviation[EDGE_AT + k]) * (temperature[j] - temperature[i])
        gain[i, EDGE_AT + k] += q / capacity[i]
        gain[j, EDGE_AT + k] -= q / capacity[j]
    for k in range(N_WALLS):
        i = _WALL_NODE[k]
        gain[i, WALL_AT + k] -= wall[k] / (1.0 + deviation[WALL_AT + k]) * (temperature[i] - air) / capacity[i]
        gain[i, AMBIENT_AT] += wall[k] / capacity[i]
    for k in range(N_SURFACES):
        i = _SURFACE_NODE[k]
        q = surface_loss(temperature[i], air, surface[k, 0], surface[k, 1], surface[k, 2])
        slope = surface_loss(temperature[i], air - 0.5, surface[k, 0], surface[k, 1], surface[k, 2]) - surface_loss(
            temperature[i], air + 0.5, surface[k, 0], surface[k, 1], surface[k, 2])
        gain[i, SURFACE_AT + k] -= q / (1.0 + deviation[SURFACE_AT + k]) / capacity[i]
        gain[i, AMBIENT_AT] += slope / capacity[i]
    for k in range(CAPACITY_NODES.shape[0]):
        i = CAPACITY_NODES[k]
        gain[i, CAPACITY_AT + k] -= rate[i] / (1.0 + deviation[CAPACITY_AT + k])
    gain[TANK_TOP, TANK_CAPACITY] -= rate[TANK_TOP] / (1.0 + deviation[TANK_CAPACITY])
    for k in range(N_UNKNOWN_HEATS):
        for i in range(N):
            gain[i, UNKNOWN_HEAT_AT + k] = UNKNOWN_HEAT_SHARE[k, i] / capacity[i]
    gain[END_WINDING, END_SHARE_AT] += end / capacity[END_WINDING]
    gain[SLOT_WINDING, END_SHARE_AT] -= slot * of_the_rest(p) / capacity[SLOT_WINDING]
