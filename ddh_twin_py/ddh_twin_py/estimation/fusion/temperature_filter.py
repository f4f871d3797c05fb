"""Extended Kalman filter on the thermal network: compiled prediction of the mean, and update.

State: temperatures of the N nodes and, per sensor, the lagged reading (dynamic); per sensor a
constant offset, and the uncertain parameters of `uncertain_parameters` (static, but for the unknown
heats, which decay with their time constant and are driven by white noise). The mean moves
with the network at every interval; the covariance moves once per epoch with the network's
Jacobian (`covariance_prediction`). Readings are compared with the mean at their own interval and
applied at the end of the epoch.

Schmidt 1966 for the static part; Verhaegen, Van Dooren 1986 for the symmetric update.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fusion.deviating_network import scaled_capacity, scaled_heat, scaled_network
from ddh_twin_py.estimation.fusion.uncertain_parameters import (
    AMBIENT_AT,
    LAG_AT,
    N_UNCERTAIN,
    N_UNKNOWN_HEATS,
    UNKNOWN_HEAT_AT,
    UNKNOWN_HEAT_TIME,
)
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.physics.thermal_network import N, N_EDGES, N_SURFACES, N_WALLS, TANK, TANK_TOP, network_step

GATE = 5.0
"""A reading further off than this many standard deviations is not used."""
LATE_GATE = 3.0
"""The same of a sensor that speaks late, once its place is known: it is as likely wrong as what is known, from here on."""
PATIENCE = 10
"""After so many refused readings in a row the sensor's offset is taken as unknown again."""
NEVER_READ = -1
"""Count of refused readings of a sensor that is not believed yet: its readings pass no gate."""
AGREEING = 5.0
"""K within which readings of a sensor say the same; one that is not known to within as much is believed once they do."""
_UNSURE = 10.0  # K, standard deviation of a reading of a sensor that is not believed yet


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
def update(dynamic, offset, deviation, covariance, sensor, measured, innovation, noise, doubted, late, refused, before, accepted, spread,
           gains):
    """Apply readings one after the other, in place.

    The first reading of a sensor may be any, and moves what it tells of; it counts with 10 K until one of the next two says the same. So
    does one that is not known to within `AGREEING`, as after a rest. One that speaks late, where that is known to within as much, is put to
    `LATE_GATE` until it is believed. One that is doubted is not used.

    Args:
        sensor: index of the sensor of each reading, (r,).
        measured: K, (r,).
        innovation: K, reading minus expected reading at the reading's own time, (r,); changed
            to what was left when it was applied.
        noise: K, standard deviation of each reading, (r,).
        doubted: whether all other sensors contradict each reading, (r,).
        late: whether each sensor spoke late and is not believed yet, (m,), changed.
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
        known = late[k] and covariance[reading, reading] <= AGREEING * AGREEING
        agrees = abs(measured[r] - before[k, 0]) <= AGREEING or abs(measured[r] - before[k, 1]) <= AGREEING
        unsure = new and not agrees
        before[k, 1] = before[k, 0]
        before[k, 0] = measured[r]
        own = max(noise[r], _UNSURE) if unsure else noise[r]
        variance = gain[reading] + gain[zero] + own * own
        left = innovation[r] - moved[reading] - moved[zero]
        innovation[r] = left
        spread[r] = np.sqrt(variance)
        gate, certain = LATE_GATE if late[k] else GATE, gain[reading] + gain[zero] + noise[r] * noise[r]
        accepted[r] = not doubted[r] and (new and not known or left * left <= gate * gate * certain)
        if doubted[r]:
            continue
        if not accepted[r]:
            refused[k] = max(refused[k], 0) + 1
            if refused[k] % PATIENCE == 0:
                covariance[zero, zero] += left * left
            continue
        if not unsure:
            refused[k] = 0
            late[k] = False
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


