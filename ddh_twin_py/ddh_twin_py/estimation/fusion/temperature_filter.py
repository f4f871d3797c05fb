"""Extended Kalman filter on the thermal network: compiled prediction and update.

State: temperatures of the N nodes and, per sensor, the lagged reading (dynamic); per sensor a
constant offset, and the uncertain parameters of `uncertain_parameters` (static, but for the unknown
heats, which decay with their time constant and are driven by white noise). The mean moves
with the network at every interval; the covariance moves once per epoch with the network's
Jacobian, P_dd <- [Phi Psi] P [Phi Psi]^T + Q, where Phi = (I - h A)^-1 and Psi = Phi h B. Readings are
compared with the mean at their own interval and applied at the end of the epoch.

Schmidt 1966 for the static part; Verhaegen, Van Dooren 1986 for the symmetric update.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.estimation.fusion.uncertain_parameters import (
    AMBIENT_AT,
    CAPACITY_AT,
    CAPACITY_NODES,
    EDGE_AT,
    END_SHARE_AT,
    LAG_AT,
    N_PUMP_LOSS,
    N_SPLIT,
    N_UNCERTAIN,
    N_UNKNOWN_HEATS,
    PUMP_LOSS_AT,
    SPLIT_AT,
    SPLIT_SHARE,
    SPLIT_SOURCE,
    SURFACE_AT,
    TANK_CAPACITY,
    UNKNOWN_HEAT_AT,
    UNKNOWN_HEAT_SHARE,
    UNKNOWN_HEAT_STD,
    UNKNOWN_HEAT_TIME,
    WALL_AT,
)
from ddh_twin_py.physics.compiled import inlined, kernel
from ddh_twin_py.physics.oil import viscosity_ratio
from ddh_twin_py.physics.thermal_network import (
    BARREL,
    CHAMBER_A,
    CHAMBER_B,
    EDGES,
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
    SURFACES,
    TANK,
    TANK_TOP,
    TEETH,
    VALVE_OIL,
    WALLS,
    YOKE,
    capacities,
    conductances,
    copper_loss,
    factorise,
    network_jacobian,
    network_rates,
    network_step,
    solve,
    surface_loss,
)

GATE = 5.0
"""A reading further off than this many standard deviations is not used."""
PATIENCE = 10
"""After so many refused readings in a row the sensor's offset is taken as unknown again."""
NEVER_READ = -1
"""Count of refused readings of a sensor that is not believed yet: its readings pass no gate."""
AGREEING = 5.0
"""K within which readings of a sensor say the same; one that is not known to within as much is believed once they do."""
_UNSURE = 10.0  # K, standard deviation of a reading of a sensor that is not believed yet
_UNKNOWN_HEAT_TIME = 60.0  # s, correlation time of what is not a state: heat while telemetry is missing, errors of the node's own heat
_UNKNOWN_HEAT = 0.3  # W per node, standard deviation
_UNKNOWN_SHARE = 0.005  # of the node's own heat
_LAG_SHARE = 0.5  # of the whole second-order term of an uncertain lag: readings do not rise for ever
_BILINEAR_TIME = 15.0  # s, how long the product of an uncertain conductance and an uncertain difference keeps its size
_MIXING = 0.001  # K per square root of s, oil of the small volumes: means over a stroke are not the strokes
_OFFSET_DRIFT = 1.0e-4  # K per square root of s

_EDGE_I = np.array([edge[1] for edge in EDGES])
_EDGE_J = np.array([edge[2] for edge in EDGES])
_SURFACE_NODE = np.array([surface[3] for surface in SURFACES])
_WALL_NODE = np.array([wall[1] for wall in WALLS])
_HEAT_NODES = (
    np.array([SLOT_WINDING, END_WINDING]), np.array([TEETH, YOKE]), np.array([ROTOR]),
    np.array([BARREL, CHAMBER_A, CHAMBER_B]), np.array([LINE_A]), np.array([LINE_B]),
)
_PUMP_CASE, _PUMP_OIL = np.array([PUMP_1_CASE, PUMP_2_CASE]), np.array([PUMP_1_OIL, PUMP_2_OIL])
_SMALL_OIL = np.array([CHAMBER_A, CHAMBER_B, LINE_A, LINE_B, PUMP_1_OIL, PUMP_2_OIL])
_GROUP_OF_NODE = np.full(N, -1)
for _group, _nodes in enumerate(_HEAT_NODES):
    _GROUP_OF_NODE[_nodes] = _group
_CAPACITY_OF_NODE = np.full(N, -1)
_CAPACITY_OF_NODE[CAPACITY_NODES] = np.arange(len(CAPACITY_NODES))


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


@inlined
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


@inlined
def _pump_parts(k, temperature, heat, flow, p):
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
        group = _GROUP_OF_NODE[i]
        out[i] = heat[i] * (1.0 + deviation[group]) if group >= 0 else heat[i]
    out[HOUSING] = heat[HOUSING] * (1.0 + deviation[2])
    for k in range(N_SPLIT):
        change = deviation[SPLIT_AT + k] * heat[SPLIT_SOURCE[k]]
        for i in range(N):
            out[i] += SPLIT_SHARE[k, i] * change
    for k in range(2):
        share, at = _case_share(k, p), PUMP_LOSS_AT + k * N_PUMP_LOSS
        with_pressure, with_speed, leakage = _pump_parts(k, temperature, heat, flow, p)
        friction = deviation[at] * with_pressure + deviation[at + 1] * with_speed
        out[_PUMP_CASE[k]] += share * friction
        out[_PUMP_OIL[k]] += (1.0 - share) * friction + deviation[at + 2] * leakage
    slot, end = copper_loss(temperature, square * (1.0 + deviation[0]), p)
    out[END_WINDING] += deviation[END_SHARE_AT] * end
    out[SLOT_WINDING] -= deviation[END_SHARE_AT] * slot * _of_the_rest(p)
    for k in range(N_UNKNOWN_HEATS):
        for i in range(N):
            out[i] += UNKNOWN_HEAT_SHARE[k, i] * deviation[UNKNOWN_HEAT_AT + k]


@inlined
def _case_share(k, p):
    """Share of the friction of pump k (0, 1) that heats its case."""
    return p.pump_1_friction_share_to_case if k == 0 else p.pump_2_friction_share_to_case


@inlined
def _of_the_rest(p):
    """The end winding's share of the copper loss over the slot's."""
    return p.motor_end_winding_copper_share / max(1.0 - p.motor_end_winding_copper_share, 1.0e-9)


@kernel
def predict_mean(params, dynamic, deviation, sensor_node, lag, heat, square, flow, position, ambient, interval, work):
    """Move temperatures and lagged readings (N + m) and the unknown heats in ``deviation`` over one interval, in place."""
    edge, wall, surface = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3))
    capacity, scaled = np.empty(N), np.empty(N)
    scaled_network(params, deviation, edge, wall, surface)
    scaled_capacity(params, deviation, position, capacity)
    temperature = dynamic[:N]
    scaled_heat(params, deviation, temperature, heat, square, flow, scaled)
    before = temperature.copy()
    network_step(
        params, edge, wall, surface, capacity, temperature, ambient + deviation[AMBIENT_AT], scaled,
        square * (1.0 + deviation[0]), flow, interval, work,
    )
    for k in range(sensor_node.shape[0]):
        decay = np.exp(-interval / (lag[k] * (1.0 + deviation[LAG_AT + k])))
        node, beside, share = sensor_node[k], sensor_node[k], 0.0
        if node == TANK:  # this sensor reads the mean of both layers
            beside, share = TANK_TOP, params[0].tank_top_share
        middle = 0.5 * ((1.0 - share) * (before[node] + temperature[node]) + share * (before[beside] + temperature[beside]))
        dynamic[N + k] = middle + (dynamic[N + k] - middle) * decay
    kept = np.exp(-interval / UNKNOWN_HEAT_TIME)
    for k in range(N_UNKNOWN_HEATS):
        deviation[UNKNOWN_HEAT_AT + k] *= kept


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
    m = sensor_node.shape[0]
    d = N + m
    first_parameter = d + m
    size = covariance.shape[0]
    p = params[0]
    edge, wall, surface = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3))
    capacity, scaled, rate = np.empty(N), np.empty(N), np.empty(N)
    scaled_network(params, deviation, edge, wall, surface)
    scaled_capacity(params, deviation, position, capacity)
    temperature = dynamic[:N]
    scaled_heat(params, deviation, temperature, heat, square, flow, scaled)
    air = ambient + deviation[AMBIENT_AT]
    scaled_square = square * (1.0 + deviation[0])
    jacobian = np.empty((N, N))
    network_jacobian(params, edge, wall, surface, capacity, temperature, air, scaled_square, flow, jacobian)
    network_rates(params, edge, wall, surface, capacity, temperature, air, scaled, scaled_square, flow, rate)

    gain = np.zeros((N, N_UNCERTAIN))  # derivative of the rate by the parameters
    slot, end = copper_loss(temperature, square, p)
    gain[SLOT_WINDING, 0] += slot / capacity[SLOT_WINDING]
    gain[END_WINDING, 0] += end / capacity[END_WINDING]
    for i in range(N):
        group = _GROUP_OF_NODE[i]
        if group >= 0:
            gain[i, group] += heat[i] / capacity[i]
    gain[HOUSING, 2] += heat[HOUSING] / capacity[HOUSING]
    for k in range(N_SPLIT):
        for i in range(N):
            gain[i, SPLIT_AT + k] += SPLIT_SHARE[k, i] * heat[SPLIT_SOURCE[k]] / capacity[i]
    for k in range(2):
        share, at = _case_share(k, p), PUMP_LOSS_AT + k * N_PUMP_LOSS
        case, oil = _PUMP_CASE[k], _PUMP_OIL[k]
        with_pressure, with_speed, leakage = _pump_parts(k, temperature, heat, flow, p)
        gain[case, at] += share * with_pressure / capacity[case]
        gain[oil, at] += (1.0 - share) * with_pressure / capacity[oil]
        gain[case, at + 1] += share * with_speed / capacity[case]
        gain[oil, at + 1] += (1.0 - share) * with_speed / capacity[oil]
        gain[oil, at + 2] += leakage / capacity[oil]
    for k in range(N_EDGES):
        i, j = _EDGE_I[k], _EDGE_J[k]
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
    gain[SLOT_WINDING, END_SHARE_AT] -= slot * _of_the_rest(p) / capacity[SLOT_WINDING]

    # second-order terms: what a conductance and a temperature difference, both uncertain, make together
    bilinear = np.empty(N_EDGES)
    for k in range(N_EDGES):
        i, j, at = _EDGE_I[k], _EDGE_J[k], first_parameter + EDGE_AT + k
        difference = covariance[i, i] + covariance[j, j] - 2.0 * covariance[i, j]
        nominal = edge[k] / (1.0 + deviation[EDGE_AT + k])
        bilinear[k] = nominal * nominal * covariance[at, at] * max(difference, 0.0)
    lagging = np.empty(m)
    for k in range(m):
        i, j, at = sensor_node[k], N + k, first_parameter + LAG_AT + k
        lagging[k] = covariance[at, at] * max(covariance[i, i] + covariance[j, j] - 2.0 * covariance[i, j], 0.0)

    valve_rate = -jacobian[VALVE_OIL, VALVE_OIL]  # 1/s
    # transition of the dynamic part, implicit so that fast oil volumes settle and never ring
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
    for k in range(m):
        share = 1.0 + deviation[LAG_AT + k]
        decay = 1.0 / (1.0 + elapsed / (lag[k] * share))
        node, beside, top = sensor_node[k], sensor_node[k], 0.0
        if node == TANK:
            beside, top = TANK_TOP, p.tank_top_share
        transition[N + k, N + k] = decay
        for j in range(N):
            transition[N + k, j] = (1.0 - decay) * ((1.0 - top) * transition[node, j] + top * transition[beside, j])
        for j in range(N_UNCERTAIN):
            transition[N + k, d + j] = (1.0 - decay) * ((1.0 - top) * transition[node, d + j] + top * transition[beside, d + j])
        reads = (1.0 - top) * temperature[node] + top * temperature[beside]
        transition[N + k, d + LAG_AT + k] -= (1.0 - decay) * (reads - dynamic[N + k]) / share

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
    kept = np.exp(-elapsed / UNKNOWN_HEAT_TIME)
    for k in range(first_parameter + UNKNOWN_HEAT_AT, first_parameter + UNKNOWN_HEAT_AT + N_UNKNOWN_HEATS):
        for j in range(size):
            covariance[k, j] *= kept
        for j in range(size):
            covariance[j, k] *= kept
    for k in range(N_UNKNOWN_HEATS):
        at = first_parameter + UNKNOWN_HEAT_AT + k
        covariance[at, at] += (1.0 - kept * kept) * UNKNOWN_HEAT_STD[k] ** 2
    for i in range(N):
        own = _UNKNOWN_SHARE * (heat[i] + (slot if i == SLOT_WINDING else end if i == END_WINDING else 0.0))
        if i == VALVE_OIL:  # the opening pressure's tolerance decides over all of it; what the flow carries off within seconds adds up no
            own = heat[i] / math.sqrt(1.0 + _UNKNOWN_HEAT_TIME * valve_rate)  # longer
        power = unknown[i] * unknown[i] + _UNKNOWN_HEAT * _UNKNOWN_HEAT + own * own
        covariance[i, i] += 2.0 * _UNKNOWN_HEAT_TIME * elapsed * power / (capacity[i] * capacity[i]) * transition[i, i] ** 2
    for k in range(_SMALL_OIL.shape[0]):
        covariance[_SMALL_OIL[k], _SMALL_OIL[k]] += _MIXING * _MIXING * elapsed
    for k in range(N_EDGES):
        i, j = _EDGE_I[k], _EDGE_J[k]
        evens = edge[k] * (1.0 / capacity[i] + 1.0 / capacity[j])  # a difference that goes within seconds is not driven for minutes
        power = 2.0 * _BILINEAR_TIME / (1.0 + _BILINEAR_TIME * evens) * elapsed * bilinear[k]
        at_i, at_j = transition[i, i] / capacity[i], transition[j, j] / capacity[j]
        covariance[i, i] += power * at_i * at_i
        covariance[j, j] += power * at_j * at_j
        covariance[i, j] -= power * at_i * at_j
        covariance[j, i] -= power * at_i * at_j
    for k in range(m):
        covariance[N + k, N + k] += _LAG_SHARE * elapsed / (lag[k] * (1.0 + deviation[LAG_AT + k])) * lagging[k]
        covariance[d + k, d + k] += _OFFSET_DRIFT * _OFFSET_DRIFT * elapsed


@kernel
def update(dynamic, offset, deviation, covariance, sensor, measured, innovation, noise, doubted, refused, before, accepted, spread, gains):
    """Apply readings one after the other, in place.

    The first reading of a sensor may be any, and moves what it tells of; it counts with 10 K until one of the next two says the same. So
    does one that is not known to within `AGREEING`, as after a rest. One that is doubted is not used.

    Args:
        sensor: index of the sensor of each reading, (r,).
        measured: K, (r,).
        innovation: K, reading minus expected reading at the reading's own time, (r,); changed
            to what was left when it was applied.
        noise: K, standard deviation of each reading, (r,).
        doubted: whether all other sensors contradict each reading, (r,).
        refused: readings refused in a row, per sensor, `NEVER_READ` of one that is not believed yet, (m,).
        before: K, last two readings of each sensor, NaN before the first, (m, 2).
        accepted: out, whether each reading was used, (r,). spread: out, K, its expected deviation.
        gains: out, covariance of the state with each reading when it was applied, (r, size of the covariance).
    """
    m = offset.shape[0]
    d = dynamic.shape[0]
    size = covariance.shape[0]
    moved = np.zeros(size)  # what the readings before this one changed in the state
    for r in range(sensor.shape[0]):
        k = sensor[r]
        reading, zero = N + k, d + k
        gain = gains[r]
        for i in range(size):
            gain[i] = covariance[i, reading] + covariance[i, zero]
        new = refused[k] == NEVER_READ or gain[reading] + gain[zero] > AGREEING * AGREEING
        agrees = abs(measured[r] - before[k, 0]) <= AGREEING or abs(measured[r] - before[k, 1]) <= AGREEING
        unsure = new and not agrees
        before[k, 1] = before[k, 0]
        before[k, 0] = measured[r]
        own = max(noise[r], _UNSURE) if unsure else noise[r]
        variance = gain[reading] + gain[zero] + own * own
        left = innovation[r] - moved[reading] - moved[zero]
        innovation[r] = left
        spread[r] = np.sqrt(variance)
        accepted[r] = not doubted[r] and (new or left * left <= GATE * GATE * variance)
        if doubted[r]:
            continue
        if not accepted[r]:
            refused[k] += 1
            if refused[k] % PATIENCE == 0:
                covariance[zero, zero] += left * left
            continue
        if not unsure:
            refused[k] = 0
        for i in range(size):
            moved[i] += gain[i] / variance * left
        for i in range(size):
            factor = gain[i] / variance
            row = covariance[i]
            for j in range(size):
                row[j] -= factor * gain[j]
    for i in range(size):
        for j in range(i):
            mean = 0.5 * (covariance[i, j] + covariance[j, i])
            covariance[i, j] = mean
            covariance[j, i] = mean
    for i in range(d):
        dynamic[i] += moved[i]
    for k in range(m):
        offset[k] += moved[d + k]
    for j in range(N_UNCERTAIN):
        deviation[j] += moved[d + m + j]
        if j != AMBIENT_AT and j < UNKNOWN_HEAT_AT:
            deviation[j] = min(max(deviation[j], -0.9), 3.0)


@kernel
def advance_mean(params, dynamic, deviation, sensor_node, lag, heat, square, flow, position, ambient, interval, temperatures, readings):
    """Move the mean over consecutive intervals; fill temperatures (n, N) and lagged readings (n, m)."""
    work = np.empty((N + 3, N))
    for k in range(heat.shape[0]):
        predict_mean(params, dynamic, deviation, sensor_node, lag, heat[k], square[k], flow[k], position[k], ambient[k], interval, work)
        temperatures[k] = dynamic[:N]
        readings[k] = dynamic[N:]


