"""Hydraulics and drive: one step of pressures, piston and shaft, and what it costs in heat.

States of one side: pressure, continued below the vapour pressure as a void that must fill
before pressure rises again. Steps are SDIRK2 (Alexander 1977; gamma = 1 - 1/sqrt(2), second
order, L-stable), so that the oil springs of the light load are resolved or damped and never
blow up. Dry friction of the piston grows over a small creep velocity and is set-valued at rest
where that is 0: each implicit stage is solved for the velocity exactly, as the piecewise linear
equation that it is, so that the piston truly sticks or creeps. A stage is linear about where the
rates of the stage before lead; only where it comes out elsewhere is it solved once more. The servo drive follows its
command as a first-order lag with all the torque that this takes, up to the current limit;
beyond it the shaft goes where that torque lets it.
"""

from __future__ import annotations

import math

from ddh_twin_py.physics import pump
from ddh_twin_py.physics.compiled import equation
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
from ddh_twin_py.physics.oil import ATMOSPHERE, VAPOUR_PRESSURE, compressibility, compressibility_nearby, pressure_factor, viscosity_ratio
from ddh_twin_py.physics.thermal_network import LINE_A, LINE_B, PUMP_1_OIL, PUMP_2_OIL
from ddh_twin_py.physics.valves import check_flow, relief_flow, relief_flow_slope

HYDRAULIC_STATES = ("speed_reference", "speed", "pressure_piston_side", "pressure_rod_side", "rod_velocity", "rod_position", "unbent",
                    "command_slope", "warming_pump_1_oil", "warming_pump_2_oil", "warming_line_a_oil", "warming_line_b_oil",
                    "pressure_piston_side_rate", "pressure_rod_side_rate", "rod_acceleration")
"""Order of the hydraulic state: rad/s, rad/s, Pa, Pa, m/s, m, s since the command last bent, rad/s2 of the command at the end
of the interval before, K/s of the oil whose viscosity counts, over that interval, and Pa/s, Pa/s, m/s2 at the end of the step before."""
SPEED_REFERENCE, SPEED, PRESSURE_A, PRESSURE_B, VELOCITY, POSITION, UNBENT, COMMAND_SLOPE = range(8)
WARMING = 8
"""First of the states of warming, in the order of `VISCOUS_NODES`."""
RATES = 12
"""First of the rates of both pressures and the velocity."""
VISCOUS_NODES = (PUMP_1_OIL, PUMP_2_OIL, LINE_A, LINE_B)
"""Nodes whose oil leaks, rubs and flows through the lines."""

_GAMMA = 1.0 - 1.0 / math.sqrt(2.0)
_EXPECTED_PRESSURE, _EXPECTED_VELOCITY = 1.0e-3, 1.0e-5
"""Of the absolute pressure, and m/s: from where a stage was expected; what a second sweep then moves is their square's order."""


@equation
def coefficients(temperature, pressure_a, pressure_b, p):
    """What the oil's temperature and pressure make of leakage, line drop and viscous friction.

    L mu_0/mu, R mu/mu_0 and b mu/mu_0 with mu(T, p); pump 1 and line A at ``pressure_a``, pump 2 and line B at ``pressure_b``.

    Returns (leakage 1, leakage 2, m3/(s*Pa); line resistance A, B, Pa*s/m3; viscous friction 1, 2, N*m*s; mu/mu_0 of pump 1, 2), for
    temperatures (N) in K and pressures in Pa gauge.
    """
    under_a, under_b = pressure_factor(pressure_a, p), pressure_factor(pressure_b, p)
    ratio_1 = viscosity_ratio(temperature[PUMP_1_OIL], p) * under_a
    ratio_2 = viscosity_ratio(temperature[PUMP_2_OIL], p) * under_b
    ratio_a = viscosity_ratio(temperature[LINE_A], p) * under_a
    ratio_b = viscosity_ratio(temperature[LINE_B], p) * under_b
    return (
        p.pump_1_leakage / ratio_1, p.pump_2_leakage / ratio_2,
        p.line_a_pressure_drop_laminar * ratio_a, p.line_b_pressure_drop_laminar * ratio_b,
        p.pump_1_friction_viscous * ratio_1, p.pump_2_friction_viscous * ratio_2,
        ratio_1, ratio_2,
    )


@equation
def displacement_1(p):
    """m3/rad of pump 1; positive speed delivers to the piston side."""
    return p.pump_1_displacement / (2.0 * math.pi)


@equation
def displacement_2(p):
    """m3/rad of pump 2; positive speed takes oil from the rod side."""
    return -p.pump_2_displacement / (2.0 * math.pi)


@equation
def delivered_1(speed, c, p):
    """m3/rad that pump 1 moves at ``speed``, rad/s: less than `displacement_1` where its suction does not fill it while it draws."""
    if p.pump_1_unfilled_by_speed == 0.0 and p.pump_1_unfilled_by_viscosity == 0.0:
        return displacement_1(p)
    return displacement_1(p) * pump.filled_share(speed, p.pump_1_unfilled_by_speed, p.pump_1_unfilled_by_viscosity, c[6])


@equation
def delivered_2(speed, c, p):
    """m3/rad that pump 2 moves at ``speed``, rad/s: less than `displacement_2` where its suction does not fill it while it draws."""
    if p.pump_2_unfilled_by_speed == 0.0 and p.pump_2_unfilled_by_viscosity == 0.0:
        return displacement_2(p)
    return displacement_2(p) * pump.filled_share(-speed, p.pump_2_unfilled_by_speed, p.pump_2_unfilled_by_viscosity, c[7])


@equation
def pump_flows(speed, pressure_a, pressure_b, c, p):
    """Port flows of both pumps, m3/s, and their port pressures p + R Q + S Q|Q|, Pa.

    ``speed`` in rad/s, pressures of the chambers in Pa gauge, ``c`` from `coefficients`; see `pump.port_flow`.
    """
    rough_a, rough_b = p.line_a_pressure_drop_quadratic, p.line_b_pressure_drop_quadratic
    flow_1 = pump.port_flow(delivered_1(speed, c, p), c[0], c[2], rough_a, speed, pressure_a)
    flow_2 = pump.port_flow(delivered_2(speed, c, p), c[1], c[3], rough_b, speed, pressure_b)
    port_1 = pressure_a + (c[2] + rough_a * abs(flow_1)) * flow_1
    port_2 = pressure_b + (c[3] + rough_b * abs(flow_2)) * flow_2
    return flow_1, flow_2, port_1, port_2


@equation
def pump_torques(speed, port_1, port_2, c, p):
    """Torque that the shaft must give to each pump, N*m, and the part of it that is lost.

    T = d p + sgn(w) (c |d p| + T_0 + T_added) + b w, ``speed`` w in rad/s, ``port_1`` and ``port_2`` p in Pa gauge.
    The loss T_added that a rig file adds is in the torques and not in the lost parts.
    """
    direction = pump.smooth_sign(speed)
    d1, d2 = displacement_1(p), displacement_2(p)
    lost_1 = direction * pump.friction_magnitude(p.pump_1_friction_pressure, p.pump_1_friction_constant, d1, port_1) + c[4] * speed
    lost_2 = direction * pump.friction_magnitude(p.pump_2_friction_pressure, p.pump_2_friction_constant, d2, port_2) + c[5] * speed
    return (d1 * port_1 + lost_1 + direction * p.pump_1_friction_added, d2 * port_2 + lost_2 + direction * p.pump_2_friction_added,
            lost_1, lost_2)


@equation
def motor_friction_torque(speed, p):
    """Friction torque of the motor's bearings and seals, N*m: sgn(w) (T_c + b |w|); ``speed`` w in rad/s."""
    return pump.smooth_sign(speed) * (p.motor_friction_coulomb + p.motor_friction_viscous * abs(speed))


@equation
def _sweep(base_a, base_b, base_v, base_x, step, speed, y_a, y_b, v, soft_a, soft_b, c, p):
    """One Newton sweep of y = base + step f(y) about (y_a, y_b, v), where 1/bulk modulus is soft_a, soft_b.

    Pressures are eliminated, what is left is one piecewise linear equation in the velocity.
    A void is counted with the volume at mid-stroke, so that its volume is kept whatever the stroke.
    """
    area_a, area_b = piston_area(p), rod_side_area(p)
    x = base_x + step * v
    within = min(max(x, 0.0), p.cylinder_stroke)
    middle = 0.5 * p.cylinder_stroke
    pressure_a, pressure_b = max(y_a, VAPOUR_PRESSURE), max(y_b, VAPOUR_PRESSURE)

    cross = p.cylinder_cross_leakage
    through = cross * (pressure_a - pressure_b)
    q_a = pump.port_flow(delivered_1(speed, c, p), c[0], c[2], p.line_a_pressure_drop_quadratic, speed, pressure_a)
    q_a += check_flow(pressure_a, p) - through
    slope_a = pump.port_flow_slope(c[0], c[2]) - cross
    if -pressure_a > p.check_valve_cracking_pressure:
        slope_a -= p.check_valve_conductance
    q_b = pump.port_flow(delivered_2(speed, c, p), c[1], c[3], p.line_b_pressure_drop_quadratic, speed, pressure_b)
    q_b += check_flow(pressure_b, p) - relief_flow(pressure_b, p) + through
    slope_b = pump.port_flow_slope(c[1], c[3]) - cross - relief_flow_slope(pressure_b, p)
    if -pressure_b > p.check_valve_cracking_pressure:
        slope_b -= p.check_valve_conductance
    full_a, full_b = y_a > VAPOUR_PRESSURE, y_b > VAPOUR_PRESSURE
    if not full_a:
        slope_a = 0.0
    if not full_b:
        slope_b = 0.0
    gain_a = step / (soft_a * (p.line_a_volume + chamber_volume_piston_side(within if full_a else middle, p)))
    gain_b = step / (soft_b * (p.line_b_volume + chamber_volume_rod_side(within if full_b else middle, p)) + p.line_b_compliance)
    share_a = 1.0 / (1.0 - gain_a * slope_a)
    share_b = 1.0 / (1.0 - gain_b * slope_b)
    rest_a = (base_a + gain_a * (q_a - slope_a * y_a)) * share_a  # pressure at zero velocity
    rest_b = (base_b + gain_b * (q_b - slope_b * y_b)) * share_b
    fall_a = gain_a * share_a * area_a  # pressure lost per velocity
    rise_b = gain_b * share_b * area_b

    inertia = lifted_mass(p) / step
    force = inertia * base_v - load_force(base_x, p)
    resistance = inertia + p.cylinder_friction_viscous + p.load_force_slope * step
    if full_a:
        force += rest_a * area_a
        resistance += fall_a * area_a
    else:
        force += pressure_a * area_a
    if full_b:
        force -= rest_b * area_b
        resistance += rise_b * area_b
    else:
        force -= pressure_b * area_b
    if x < -p.cylinder_run_past_retracted:
        force -= END_STOP_STIFFNESS * (base_x + p.cylinder_run_past_retracted)
        resistance += END_STOP_STIFFNESS * step
    elif x > p.cylinder_stroke + p.cylinder_run_past_extended:
        force -= END_STOP_STIFFNESS * (base_x - p.cylinder_stroke - p.cylinder_run_past_extended)
        resistance += END_STOP_STIFFNESS * step
    dry = coulomb_friction(v, pressure_a - pressure_b, p)
    creep = p.cylinder_creep_velocity
    breakaway = dry + resistance * creep
    if force > breakaway:
        v = (force - dry) / resistance
    elif force < -breakaway:
        v = (force + dry) / resistance
    elif creep > 0.0:
        v = force / (resistance + dry / creep)
    else:
        v = 0.0
    return rest_a - fall_a * v, rest_b + rise_b * v, v


@equation
def _shaft_step(speed, speed_reference, pressure_a, pressure_b, step, torque_limit, c, p):
    """Speed after a step, rad/s: the reference, or what the current limit allows of it; and the torque of that limit, N*m, else 0."""
    _, _, port_1, port_2 = pump_flows(speed, pressure_a, pressure_b, c, p)
    wanted_1, wanted_2, _, _ = pump_torques(speed_reference, port_1, port_2, c, p)
    friction = motor_friction_torque(speed_reference, p)
    needed = p.motor_inertia * (speed_reference - speed) / step + wanted_1 + wanted_2 + friction
    if abs(needed) <= torque_limit:
        return speed_reference, 0.0
    driving = torque_limit if needed > 0.0 else -torque_limit
    d1, d2 = displacement_1(p), displacement_2(p)
    dry = (
        pump.friction_magnitude(p.pump_1_friction_pressure, p.pump_1_friction_constant, d1, port_1)
        + pump.friction_magnitude(p.pump_2_friction_pressure, p.pump_2_friction_constant, d2, port_2)
        + p.motor_friction_coulomb + p.pump_1_friction_added + p.pump_2_friction_added
    )
    viscous = c[4] + c[5] + p.motor_friction_viscous
    torque = p.motor_inertia * speed / step + driving - d1 * port_1 - d2 * port_2
    resistance = p.motor_inertia / step + viscous
    if torque > dry:
        return (torque - dry) / resistance, driving
    if torque < -dry:
        return (torque + dry) / resistance, driving
    return 0.0, driving


@equation
def follow_decays(step, p):
    """How much of a lag is left at the first stage and at the end of a step of the drive's first-order answer."""
    lag = p.motor_speed_loop_time_constant
    return math.exp(-_GAMMA * step / lag), math.exp(-step / lag)


@equation
def softness(state, p):
    """1/bulk modulus of both sides at the state's pressures, 1/Pa, and these, Pa gauge."""
    a, b = state[PRESSURE_A], state[PRESSURE_B]
    return compressibility(a, p), compressibility(b, p), a, b


@equation
def _as_expected(a, b, v, a_new, b_new, v_new, p):
    """Whether pressures (Pa gauge) and velocity (m/s) came out so near to where a sweep was linear that another would not move them."""
    crack = -p.check_valve_cracking_pressure
    return (
        abs(a_new - a) <= _EXPECTED_PRESSURE * (a + ATMOSPHERE) and abs(b_new - b) <= _EXPECTED_PRESSURE * (b + ATMOSPHERE)
        and abs(v_new - v) <= _EXPECTED_VELOCITY
        and (a_new > crack) == (a > crack) and (b_new > crack) == (b > crack)
        and (b_new > p.relief_valve_opening_pressure) == (b > p.relief_valve_opening_pressure)
    )  # fmt: skip


@equation
def _stage(base_a, base_b, base_v, base_x, step, speed, rate_a, rate_b, rate_v, soft, c, p):
    """Solve an implicit stage y = base + step f(y): pressures, velocity, and 1/bulk modulus near there with the pressures it is of.

    The first sweep is about where the rates (Pa/s, Pa/s, m/s2) lead; a second follows where that was not `_as_expected`.
    """
    a, b, v = base_a + step * rate_a, base_b + step * rate_b, base_v + step * rate_v
    soft_a, soft_b = compressibility_nearby(soft[0], soft[2], a, p), compressibility_nearby(soft[1], soft[3], b, p)
    a_new, b_new, v_new = _sweep(base_a, base_b, base_v, base_x, step, speed, a, b, v, soft_a, soft_b, c, p)
    if not _as_expected(a, b, v, a_new, b_new, v_new, p):
        a, b, v = a_new, b_new, v_new
        soft_a, soft_b = compressibility(a, p), compressibility(b, p)
        a_new, b_new, v_new = _sweep(base_a, base_b, base_v, base_x, step, speed, a, b, v, soft_a, soft_b, c, p)
    return a_new, b_new, v_new, (soft_a, soft_b, a, b)


@equation
def hydraulic_step(state, command, command_slope, step, decay_early, decay_late, torque_limit, soft, c, p):
    """Advance the hydraulic state in place by ``step`` seconds; the command is command + command_slope t, rad/s.

    ``decay_early`` and ``decay_late`` are those of `follow_decays` for this step;
    ``torque_limit`` in N*m; ``soft``: 1/bulk modulus of both sides, 1/Pa, and the pressures it is of, Pa gauge, from the step
    before or from `softness`.

    Returns:
        speed, acceleration, p_A, p_B, velocity, position at the end of the step, `soft` for the next, and the drive's torque, N*m,
        where the current limit holds, else 0.
    """
    lag = p.motor_speed_loop_time_constant
    reference = state[SPEED_REFERENCE]
    start = state[SPEED]
    followed = reference == start
    early_time, late_time = _GAMMA * step, step
    early = command + command_slope * (early_time - lag) + (reference - command + command_slope * lag) * decay_early
    late = command + command_slope * (late_time - lag) + (reference - command + command_slope * lag) * decay_late
    pressure_a, pressure_b = max(state[PRESSURE_A], VAPOUR_PRESSURE), max(state[PRESSURE_B], VAPOUR_PRESSURE)
    speed_late, limit_torque = _shaft_step(start, late, pressure_a, pressure_b, step, torque_limit, c, p)
    if limit_torque != 0.0 or not followed:
        acceleration_late = (speed_late - start) / step
        speed_early = start + _GAMMA * (speed_late - start)
    else:
        speed_early = early
        acceleration_late = (command + command_slope * late_time - late) / lag

    a0, b0, v0, x0 = state[PRESSURE_A], state[PRESSURE_B], state[VELOCITY], state[POSITION]
    sub = _GAMMA * step
    a1, b1, v1, soft = _stage(a0, b0, v0, x0, sub, speed_early, state[RATES], state[RATES + 1], state[RATES + 2], soft, c, p)
    ratio, per_second = (1.0 - _GAMMA) / _GAMMA, 1.0 / sub
    base_a, base_b, base_v, base_x = a0 + ratio * (a1 - a0), b0 + ratio * (b1 - b0), v0 + ratio * (v1 - v0), x0 + ratio * sub * v1
    a2, b2, v2, soft = _stage(base_a, base_b, base_v, base_x, sub, speed_late, (a1 - a0) * per_second, (b1 - b0) * per_second,
                              (v1 - v0) * per_second, soft, c, p)
    x2 = base_x + sub * v2
    state[SPEED_REFERENCE] = late
    state[SPEED] = speed_late
    state[PRESSURE_A], state[PRESSURE_B], state[VELOCITY], state[POSITION] = a2, b2, v2, x2
    state[RATES], state[RATES + 1], state[RATES + 2] = (a2 - base_a) * per_second, (b2 - base_b) * per_second, (v2 - base_v) * per_second
    return speed_late, acceleration_late, max(a2, VAPOUR_PRESSURE), max(b2, VAPOUR_PRESSURE), v2, x2, soft, limit_torque
