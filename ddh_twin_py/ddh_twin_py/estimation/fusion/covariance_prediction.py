"""The filter's covariance, moved over an epoch: transition, P_dd <- [Phi Psi] P [Phi Psi]^T, and what is not certain in it.

Phi = (I - h A)^-1 and Psi = Phi h B, implicit so that fast oil volumes settle and never ring; A is the network's Jacobian,
B `rate_slopes`. Second-order terms are what a conductance or a lag and a temperature difference, both uncertain, make together.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.estimation.fusion.deviating_network import scaled_capacity, scaled_heat, scaled_network
from ddh_twin_py.estimation.fusion.rate_slopes import EDGE_I, EDGE_J, rate_slopes
from ddh_twin_py.estimation.fusion.uncertain_parameters import (
    AMBIENT_AT,
    EDGE_AT,
    LAG_AT,
    N_UNCERTAIN,
    N_UNKNOWN_HEATS,
    UNKNOWN_HEAT_AT,
    UNKNOWN_HEAT_STD,
    UNKNOWN_HEAT_TIME,
)
from ddh_twin_py.physics.compiled import equation, kernel
from ddh_twin_py.physics.network_elimination import factorise, solve
from ddh_twin_py.physics.thermal_network import (
    CHAMBER_A,
    CHAMBER_B,
    END_WINDING,
    LINE_A,
    LINE_B,
    N,
    N_EDGES,
    N_SURFACES,
    N_WALLS,
    PUMP_1_OIL,
    PUMP_2_OIL,
    SLOT_WINDING,
    TANK,
    TANK_TOP,
    VALVE_OIL,
    copper_loss,
    network_jacobian,
    network_rates,
)

_UNKNOWN_HEAT_TIME = 60.0  # s, correlation time of what is not a state: heat while telemetry is missing, errors of the node's own heat
_UNKNOWN_HEAT = 0.3  # W per node, standard deviation
_UNKNOWN_SHARE = 0.005  # of the node's own heat
_LAG_SHARE = 0.5  # of the whole second-order term of an uncertain lag: readings do not rise for ever
_BILINEAR_TIME = 15.0  # s, how long the product of an uncertain conductance and an uncertain difference keeps its size
_MIXING = 0.001  # K per square root of s, oil of the small volumes: means over a stroke are not the strokes
_OFFSET_DRIFT = 1.0e-4  # K per square root of s
_SMALL_OIL = np.array([CHAMBER_A, CHAMBER_B, LINE_A, LINE_B, PUMP_1_OIL, PUMP_2_OIL])


@kernel
def predict_covariance(params, dynamic, deviation, covariance, sensor_node, lag, heat, unknown, square, flow, position, ambient, elapsed,
                       transition):
    """Move the covariance over ``elapsed`` seconds with mean inputs, in place.

    Args:
        covariance: (N + m + m + N_UNCERTAIN) square: temperatures, readings, offsets, parameters.
        heat: W, mean, (N,). unknown: W, standard deviation of heat that no model knows, (N,).
        square: A^2. flow: m3/s, (N_FLOWS,). position: m. ambient: K.
        transition: out, derivative of the dynamic part after ``elapsed`` by dynamic part and parameters
            before, (N + m, N + m + N_UNCERTAIN); what a smoother needs.
    """
    edge, wall, surface = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3))
    capacity, scaled, rate = np.empty(N), np.empty(N), np.empty(N)
    scaled_network(params, deviation, edge, wall, surface)
    scaled_capacity(params, deviation, position, capacity)
    temperature = dynamic[:N]
    scaled_heat(params, deviation, temperature, heat, square, flow, scaled)
    air, scaled_square = ambient + deviation[AMBIENT_AT], square * (1.0 + deviation[0])
    jacobian, gain = np.empty((N, N)), np.zeros((N, N_UNCERTAIN))
    network_jacobian(params, edge, wall, surface, capacity, temperature, air, scaled_square, flow, jacobian)
    network_rates(params, edge, wall, surface, capacity, temperature, air, scaled, scaled_square, flow, rate)
    rate_slopes(params, deviation, edge, wall, surface, capacity, temperature, air, rate, heat, square, flow, gain)

    bilinear, lagging = np.empty(N_EDGES), np.empty(sensor_node.shape[0])
    _second_order(covariance, edge, deviation, sensor_node, bilinear, lagging)
    valve_rate = -jacobian[VALVE_OIL, VALVE_OIL]  # 1/s
    _take_transition(jacobian, gain, elapsed, transition)
    _take_lags(params, dynamic, deviation, sensor_node, lag, elapsed, transition)
    _move(covariance, transition)
    _let_unknown_heats_fade(covariance, elapsed)
    _add_heat_noise(params, temperature, heat, unknown, square, capacity, valve_rate, elapsed, transition, covariance)
    for k in range(_SMALL_OIL.shape[0]):
        covariance[_SMALL_OIL[k], _SMALL_OIL[k]] += _MIXING * _MIXING * elapsed
    _add_bilinear_noise(edge, capacity, bilinear, elapsed, transition, covariance)
    d = dynamic.shape[0]
    for k in range(sensor_node.shape[0]):
        covariance[N + k, N + k] += _LAG_SHARE * elapsed / (lag[k] * (1.0 + deviation[LAG_AT + k])) * lagging[k]
        covariance[d + k, d + k] += _OFFSET_DRIFT * _OFFSET_DRIFT * elapsed


@equation
def _second_order(covariance, edge, deviation, sensor_node, bilinear, lagging):
    """Variance of what uncertain conductances make of uncertain differences, W^2, (N_EDGES,), and lags of what they follow, K^2, (m,)."""
    first_parameter = N + 2 * sensor_node.shape[0]
    for k in range(N_EDGES):
        i, j, at = EDGE_I[k], EDGE_J[k], first_parameter + EDGE_AT + k
        difference = covariance[i, i] + covariance[j, j] - 2.0 * covariance[i, j]
        nominal = edge[k] / (1.0 + deviation[EDGE_AT + k])
        bilinear[k] = nominal * nominal * covariance[at, at] * max(difference, 0.0)
    for k in range(sensor_node.shape[0]):
        i, j, at = sensor_node[k], N + k, first_parameter + LAG_AT + k
        lagging[k] = covariance[at, at] * max(covariance[i, i] + covariance[j, j] - 2.0 * covariance[i, j], 0.0)


@equation
def _take_transition(jacobian, gain, elapsed, transition):
    """Rows of the temperatures in ``transition``, from A (N, N), which is overwritten, and B (N, N_UNCERTAIN)."""
    d = transition.shape[0]
    transition[:, :] = 0.0
    for i in range(N):
        for j in range(N):
            jacobian[i, j] *= -elapsed
        jacobian[i, i] += 1.0
    factorise(jacobian)
    column = np.empty(N)
    for j in range(N):
        column[:] = 0.0
        column[j] = 1.0
        solve(jacobian, column)
        transition[:N, j] = column
    for j in range(N_UNCERTAIN):
        for i in range(N):
            column[i] = elapsed * gain[i, j]
        solve(jacobian, column)
        transition[:N, d + j] = column


@equation
def _take_lags(params, dynamic, deviation, sensor_node, lag, elapsed, transition):
    """Rows of the lagged readings in ``transition``, once those of the temperatures are there."""
    d = dynamic.shape[0]
    for k in range(sensor_node.shape[0]):
        share = 1.0 + deviation[LAG_AT + k]
        decay = 1.0 / (1.0 + elapsed / (lag[k] * share))
        node, beside, top = sensor_node[k], sensor_node[k], 0.0
        if node == TANK:
            beside, top = TANK_TOP, params[0].tank_top_share
        transition[N + k, N + k] = decay
        for j in range(N):
            transition[N + k, j] = (1.0 - decay) * ((1.0 - top) * transition[node, j] + top * transition[beside, j])
        for j in range(N_UNCERTAIN):
            transition[N + k, d + j] = (1.0 - decay) * ((1.0 - top) * transition[node, d + j] + top * transition[beside, d + j])
        reads = (1.0 - top) * dynamic[node] + top * dynamic[beside]
        transition[N + k, d + LAG_AT + k] -= (1.0 - decay) * (reads - dynamic[N + k]) / share


@equation
def _move(covariance, transition):
    """Take the covariance through ``transition``, in place; offsets and parameters stay."""
    d, size = transition.shape[0], covariance.shape[0]
    first_parameter = size - N_UNCERTAIN
    rows = np.empty((d + N_UNCERTAIN, size))
    rows[:d] = covariance[:d]
    rows[d:] = covariance[first_parameter:]
    moved = np.dot(transition, rows)  # (d, size)
    right = np.empty((d, d + N_UNCERTAIN))
    right[:, :d] = moved[:, :d]
    right[:, d:] = moved[:, first_parameter:]
    block = np.dot(right, transition.T)
    for i in range(d):
        for j in range(d):
            covariance[i, j] = 0.5 * (block[i, j] + block[j, i])
        for j in range(d, size):
            covariance[i, j] = moved[i, j]
            covariance[j, i] = moved[i, j]


@equation
def _let_unknown_heats_fade(covariance, elapsed):
    """Unknown heats decay with `UNKNOWN_HEAT_TIME` and are driven so that they keep their size, `UNKNOWN_HEAT_STD`."""
    size = covariance.shape[0]
    first = size - N_UNCERTAIN + UNKNOWN_HEAT_AT
    kept = np.exp(-elapsed / UNKNOWN_HEAT_TIME)
    for k in range(first, first + N_UNKNOWN_HEATS):
        for j in range(size):
            covariance[k, j] *= kept
        for j in range(size):
            covariance[j, k] *= kept
    for k in range(N_UNKNOWN_HEATS):
        covariance[first + k, first + k] += (1.0 - kept * kept) * UNKNOWN_HEAT_STD[k] ** 2


@equation
def _add_heat_noise(params, temperature, heat, unknown, square, capacity, valve_rate, elapsed, transition, covariance):
    """Add what heats of no state make: while telemetry is missing (``unknown``, W), per node, and as a share of its own heat."""
    slot, end = copper_loss(temperature, square, params[0])
    for i in range(N):
        own = _UNKNOWN_SHARE * (heat[i] + (slot if i == SLOT_WINDING else end if i == END_WINDING else 0.0))
        if i == VALVE_OIL:  # the opening pressure's tolerance decides over all of it; what the flow carries off within seconds adds up no
            own = heat[i] / math.sqrt(1.0 + _UNKNOWN_HEAT_TIME * valve_rate)  # longer
        power = unknown[i] * unknown[i] + _UNKNOWN_HEAT * _UNKNOWN_HEAT + own * own
        covariance[i, i] += 2.0 * _UNKNOWN_HEAT_TIME * elapsed * power / (capacity[i] * capacity[i]) * transition[i, i] ** 2


@equation
def _add_bilinear_noise(edge, capacity, bilinear, elapsed, transition, covariance):
    """Add what each connection's second-order term, (N_EDGES,), carries from one of its nodes to the other."""
    for k in range(N_EDGES):
        i, j = EDGE_I[k], EDGE_J[k]
        evens = edge[k] * (1.0 / capacity[i] + 1.0 / capacity[j])  # a difference that goes within seconds is not driven for minutes
        power = 2.0 * _BILINEAR_TIME / (1.0 + _BILINEAR_TIME * evens) * elapsed * bilinear[k]
        at_i, at_j = transition[i, i] / capacity[i], transition[j, j] / capacity[j]
        covariance[i, i] += power * at_i * at_i
        covariance[j, j] += power * at_j * at_j
        covariance[i, j] -= power * at_i * at_j
        covariance[j, i] -= power * at_i * at_j
