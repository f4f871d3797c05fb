"""Free run: the whole unit from speed command, payload and ambient, at a fixed step."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.balance import add_further_heat, add_hydraulics, add_motor, clear, motor_current
from ddh_twin_py.physics.compiled import equation, kernel
from ddh_twin_py.physics.hydraulics import (
    COMMAND_SLOPE,
    HYDRAULIC_STATES,
    POSITION,
    PRESSURE_A,
    PRESSURE_B,
    SPEED,
    SPEED_REFERENCE,
    UNBENT,
    VELOCITY,
    VISCOUS_NODES,
    WARMING,
    coefficients,
    follow_decays,
    hydraulic_step,
    softness,
)
from ddh_twin_py.physics.motor import available_current, iron_coefficients, magnet_factor
from ddh_twin_py.physics.oil import VAPOUR_PRESSURE
from ddh_twin_py.physics.thermal_network import (
    END_WINDING,
    N,
    N_EDGES,
    N_FLOWS,
    N_SURFACES,
    N_WALLS,
    ROTOR,
    SLOT_WINDING,
    capacities,
    conductances,
    network_step_between,
    winding_resistance,
)
from ddh_twin_py.physics.valves import check_flow, relief_flow

HYDRAULIC_STEP = 1.0e-3
"""s, default step of pressures, piston and shaft where the oil springs may ring; the thermal network moves once per interval."""
COMMAND_PARTS = 5
"""Parts of an interval at whose edges the speed command is given."""
BEND = 20.0
"""rad/s2, change of the command's slope that makes the oil springs ring; what a clock's jitter bends a ramp by is less."""
DAMPED_AFTER, DAMPED_FACTOR = 0.15, 2.5
CALM_AFTER, CALM_FACTOR, CALM_STEP = 0.3, 12.0, 0.0125
STILL_AFTER, STILL_FACTOR, STILL_STEP = 1.0, 50.0, 0.05
"""s since the command last bent, how many times longer a step then is, and the longest, s: in a ramp, and twice for a constant command.
The choice hangs on the command, so that a fit sees a smooth function, but for a shaft that the current limit holds back, which takes
none of them, and a piston that could meet an end stop within the interval, which takes none of the latter two: their error would leave
a void in the oil."""


@equation
def _add(point, weight, speed, acceleration, limit_torque, pressure_a, pressure_b, velocity, position, resistance, magnets, iron, c, p):
    """Add one instant to the operating point; with half weights at both ends the mean is the trapezoidal rule's.

    Where the current limit holds, the drive gives ``limit_torque`` (N*m, else 0), also to a shaft that stalls.

    Returns:
        the current of that instant, A.
    """
    pump_torque = add_hydraulics(
        point, weight, speed, pressure_a, pressure_b, velocity, position,
        check_flow(pressure_a, p), check_flow(pressure_b, p), relief_flow(pressure_b, p), c, p,
    )
    torque_constant = magnets * p.motor_torque_constant
    if limit_torque != 0.0:
        current = limit_torque / torque_constant
    else:
        current = motor_current(speed, acceleration, pump_torque, torque_constant, p)
    add_motor(point, weight, speed, current, resistance, magnets, iron, p)
    return current


@equation
def _clear_of_stops(position, way, p):
    """Whether a piston at ``position`` that may go twice ``way`` (both m) stays off the end stops."""
    reach = 2.0 * abs(way)
    return position > reach - p.cylinder_run_past_retracted and position < p.cylinder_stroke + p.cylinder_run_past_extended - reach


@equation
def _longer(interval, factor, step, longest):
    """Steps that an interval is divided into (interval and steps in s) where they may be ``factor`` times longer, up to ``longest``."""
    return max(1, int(round(interval / min(factor * step, max(step, longest)))))


@equation
def _take(point, factor, heat, flow, anew):
    """Add an operating point's heat and flows times a factor to what was gathered, or begin ``anew``."""
    for i in range(N):
        heat[i] = (0.0 if anew else heat[i]) + factor * point.heat[i]
    for i in range(N_FLOWS):
        flow[i] = (0.0 if anew else flow[i]) + factor * point.flow[i]


@equation
def _take_command(state, command, first, interval):
    """Note how the command of an interval, rad/s, its parts from ``first`` on, bends, in `UNBENT` and `COMMAND_SLOPE` of the state.

    Returns:
        whether it is constant, and the time up to the middle of the interval since it last bent or the current limit held, s.
    """
    steady, bent = True, False
    for j in range(COMMAND_PARTS):
        slope = (command[first + j + 1] - command[first + j]) * COMMAND_PARTS / interval
        steady = steady and slope == 0.0
        bent = bent or abs(slope - state[COMMAND_SLOPE]) > BEND
        state[COMMAND_SLOPE] = slope
    since = state[UNBENT] + 0.5 * interval
    if bent or state[SPEED] != state[SPEED_REFERENCE]:
        since = 0.0
    state[UNBENT] = 0.0 if bent else state[UNBENT] + interval
    return steady, since


@equation
def _swing(point, heat, flow, heat_early, heat_late, flow_early, flow_late):
    """Heat (N, W) and flows (N_FLOWS, m3/s) at the begin and the end of an interval, from their means and half of what they change by.

    Flows change by one share of that, so that what flows in flows out and none is below zero.
    """
    for i in range(N):
        heat_early[i], heat_late[i] = point.heat[i] - heat[i], point.heat[i] + heat[i]
    most = 1.0
    for i in range(N_FLOWS):
        if abs(flow[i]) * most > point.flow[i]:
            most = point.flow[i] / abs(flow[i])
    for i in range(N_FLOWS):
        flow_early[i], flow_late[i] = point.flow[i] - most * flow[i], point.flow[i] + most * flow[i]


@equation
def _look(instants, at, end, step, earlier, later, samples):
    """Fill `samples` at the instants up to ``end`` of a step (s), linear between its ends, from number ``at`` on; the next number."""
    while at < instants.shape[0] and instants[at] <= end:
        part = 1.0 - (end - instants[at]) / step
        for i in range(6):
            samples[at, i] = earlier[i] + part * (later[i] - earlier[i])
        at += 1
    return at


@equation
def _taken(command, p):
    """The speed that the drive takes a command for, rad/s."""
    return p.motor_speed_loop_gain * command + p.motor_speed_loop_zero


@kernel
def free_run(params, state, temperature, command, ambient, interval, step, measured_position, points, temperatures):
    """Run over consecutive intervals, in place on state (`HYDRAULIC_STATES`) and temperature (N, K).

    Arguments (command in rad/s, ambient in K, interval and step in s, measured_position in m, points and temperatures as
    outputs), what it returns and raises: `free_run_sampled`.
    """
    nowhen, nothing = np.empty(0), np.empty((0, len(SAMPLED)))
    return free_run_sampled(params, state, temperature, command, ambient, interval, step, measured_position, points,
                            temperatures, nowhen, nothing)


SAMPLED = ("speed", "current", "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity")
"""What `free_run_sampled` gives at instants: rad/s, A, Pa, Pa, m, m/s."""


@kernel
def free_run_sampled(params, state, temperature, command, ambient, interval, step, measured_position, points, temperatures,
                     instants, samples):
    """Run over consecutive intervals, in place on state (`HYDRAULIC_STATES`) and temperature (N, K), and look at single instants.

    Args:
        params: parameters, shape (1,).
        command: speed command at the edges of the `COMMAND_PARTS` parts of each interval, rad/s,
            shape (n COMMAND_PARTS + 1,); linear in between.
        ambient: K, per interval, shape (n,).
        interval: s. step: s, wanted hydraulic step; a whole number of them fills an interval.
        measured_position: m, per interval; where finite, the rod is put there before the
            interval (the free run at a standstill); NaN leaves it.
        points: out, operating points, shape (n,), see `balance.OPERATING_DTYPE`.
        temperatures: out, at the end of each interval, K, shape (n, N).
        instants: s since the start of the run, sorted, shape (m,).
        samples: out, values at the instants, linear between steps, shape (m, 6), see `SAMPLED`;
            instants after the end are left alone.
    Returns:
        heat lost to ambient, J.
    Raises:
        ValueError: an array of the wrong length.
    """
    if state.shape[0] != len(HYDRAULIC_STATES) or temperature.shape[0] != N:
        raise ValueError("state or temperature has the wrong length")  # a kernel would write past its end
    n = points.shape[0]
    if command.shape[0] < n * COMMAND_PARTS + 1 or min(ambient.shape[0], measured_position.shape[0], temperatures.shape[0]) < n:
        raise ValueError("command, ambient, measured_position or temperatures are shorter than the run")  # a kernel would read past them
    p = params[0]
    edge, wall, surface = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3))
    capacity, work = np.empty(N), np.empty((N + 3, N))
    early, late, flow_early, flow_late = np.empty(N), np.empty(N), np.empty(N_FLOWS), np.empty(N_FLOWS)
    swing_heat, swing_flow = np.empty(N), np.empty(N_FLOWS)  # half of what they change by over an interval; small volumes feel it
    middle = temperature.copy()
    conductances(params, edge, wall, surface)
    fine = max(1, int(round(interval / (COMMAND_PARTS * step))))
    damped = _longer(interval / COMMAND_PARTS, DAMPED_FACTOR, step, interval)
    calm, still = _longer(interval, CALM_FACTOR, step, CALM_STEP), _longer(interval, STILL_FACTOR, step, STILL_STEP)
    iron = iron_coefficients(p)
    lost = 0.0
    at = 0
    for k in range(n):
        if np.isfinite(measured_position[k]):
            state[POSITION] = measured_position[k]
        before = state[POSITION]
        point = points[k]
        clear(point)
        for i in range(len(VISCOUS_NODES)):  # the middle of the interval, as it went on before
            node = VISCOUS_NODES[i]
            middle[node] = temperature[node] + 0.5 * interval * state[WARMING + i]
        c = coefficients(middle, state[PRESSURE_A], state[PRESSURE_B], p)
        magnets = magnet_factor(temperature[ROTOR], p)
        resistance = winding_resistance(temperature, p)
        torque_limit = available_current(temperature[SLOT_WINDING], temperature[END_WINDING], p) * magnets * p.motor_torque_constant
        first = k * COMMAND_PARTS
        steady, since = _take_command(state, command, first, interval)
        parts, count = COMMAND_PARTS, damped if since > DAMPED_AFTER else fine
        settled = steady and since > CALM_AFTER and _clear_of_stops(state[POSITION], state[VELOCITY] * interval, p)
        if settled:
            parts, count = 1, still if since > STILL_AFTER else calm
        span = interval / parts
        h = span / count
        decay_early, decay_late = follow_decays(h, p)
        share = 1.0 / (parts * count)
        soft = softness(state, p)
        acceleration, limited = 0.0, 0.0
        if state[SPEED] == state[SPEED_REFERENCE]:
            acceleration = (_taken(command[first], p) - state[SPEED_REFERENCE]) / p.motor_speed_loop_time_constant
        else:  # the limit held in the step before
            limited = torque_limit if state[SPEED_REFERENCE] > state[SPEED] else -torque_limit
        current = _add(point, 0.5 * share, state[SPEED], acceleration, limited, max(state[PRESSURE_A], VAPOUR_PRESSURE),
                       max(state[PRESSURE_B], VAPOUR_PRESSURE), state[VELOCITY], state[POSITION], resistance, magnets, iron, c, p)
        _take(point, -1.0 / share, swing_heat, swing_flow, True)
        for j in range(parts):
            start = _taken(command[first + j], p)
            slope = 0.0 if settled else (_taken(command[first + j + 1], p) - start) / span
            for m in range(count):
                earlier = (state[SPEED], current, max(state[PRESSURE_A], VAPOUR_PRESSURE), max(state[PRESSURE_B], VAPOUR_PRESSURE),
                           state[POSITION], state[VELOCITY])
                speed, acceleration, pressure_a, pressure_b, velocity, position, soft, limited = hydraulic_step(
                    state, start + slope * (m * h), slope, h, decay_early, decay_late, torque_limit, soft, c, p)
                last = j == parts - 1 and m == count - 1
                if last:
                    _take(point, -1.0 / share, swing_heat, swing_flow, False)
                current = _add(point, 0.5 * share if last else share, speed, acceleration, limited, pressure_a, pressure_b,
                               velocity, position, resistance, magnets, iron, c, p)
                end = k * interval + j * span + (m + 1) * h
                later = (speed, current, pressure_a, pressure_b, position, velocity)
                at = _look(instants, at, end, h, earlier, later, samples)
        _take(point, 1.0 / share, swing_heat, swing_flow, False)
        add_further_heat(point, p)
        for i in range(len(VISCOUS_NODES)):
            state[WARMING + i] = -temperature[VISCOUS_NODES[i]] / interval
        capacities(params, 0.5 * (before + state[POSITION]), capacity)
        _swing(point, swing_heat, swing_flow, early, late, flow_early, flow_late)
        lost += network_step_between(
            params, edge, wall, surface, capacity, temperature, ambient[k] + p.surroundings_enclosure_rise, early, late,
            point.mean_square_current, flow_early, flow_late, interval, work,
        )
        for i in range(len(VISCOUS_NODES)):
            state[WARMING + i] += temperature[VISCOUS_NODES[i]] / interval
        temperatures[k] = temperature
    return lost


@kernel
def settle(params, state, position, pressure_a, pressure_b):
    """Set the hydraulic state (`HYDRAULIC_STATES`) to rest at ``pressure_a``, ``pressure_b`` (Pa gauge) and ``position`` (m).

    Raises:
        ValueError: a state of the wrong length.
    """
    if state.shape[0] != len(HYDRAULIC_STATES):
        raise ValueError("state has the wrong length")
    state[:] = 0.0
    state[PRESSURE_A] = pressure_a
    state[PRESSURE_B] = pressure_b
    state[POSITION] = position
