"""The plant in time: fixed steps of 0.25 ms for drive, oil and piston, thermal steps of 10 ms.

Semi-implicit: the shaft's friction and the seal's bristles implicitly, velocity before pressure (symplectic), voids as volumes
that must fill before pressure rises again. The drive is a PI speed loop about a first-order reference, with current limit and
an integrator that holds while limited.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ddh_twin_py.plant import heat
from ddh_twin_py.plant.compiled import kernel
from ddh_twin_py.plant.laws import BRISTLE_DAMPING, BRISTLE_STIFFNESS, iron, leakage, pump_drag, shaft_sign, sliding, soft_positive
from ddh_twin_py.plant.oil import VAPOUR, softness, viscosity

STEP = 2.5e-4
"""s."""
THERMAL_STEPS = 40
"""Steps per thermal step."""
FAST = ("speed_command", "speed", "current", "voltage", "electrical_power", "pressure_piston_side", "pressure_rod_side",
        "rod_position", "rod_velocity", "slipped")
"""What is sampled: rad/s, rad/s, A, V, W, Pa, Pa, m, m/s, m (what a slipping encoder has lost)."""
LEDGER = ("electrical", "mechanical", "stored_oil", "given_heat", "lost_heat")
"""Energies over a run, J: from the drive, lifted and kinetic, in the springs of the oil, given to the nodes, lost to ambient."""
(OMEGA, REFERENCE, INTEGRAL, P_A, P_B, VOID_A, VOID_B, V, X, Z) = range(10)
STATES = 10
"""Length of the fast state: rad/s, rad/s, N*m, Pa, Pa, m3, m3, m/s, m, m (bristles)."""
_BANDWIDTH = 900.0  # rad/s of the speed loop about its reference
_DAMPING = 0.8
_INDUCTANCE = 8.0e-4  # H per phase
_STOP_STIFFNESS, _STOP_DAMPING = 4.0e7, 4.0e4  # N/m, N*s/m
_RPM = 30.0 / math.pi
_CALM = 4.0  # s over which a swaying load comes to rest
_FIRST_REST = 3.0  # s


class Warmth(NamedTuple):
    """What temperatures make of the laws, held for a thermal step.

    Attributes:
        leak_1, leak_2: m3/(s*Pa). drop_a, drop_b: Pa*s/m3. viscous_1, viscous_2: N*m*s. flux: of the magnets, over that at 23 degC.
        torque_constant: N*m/A. resistance: of a phase, ohm. teeth, yoke: iron losses, W. brake: N*m of a brake that drags.
        stuck: m3/(s*Pa) past a hot relief valve. starved: m3*s/rad2 that pump 1 misses of cold oil, over its displacement.
    """

    leak_1: float
    leak_2: float
    drop_a: float
    drop_b: float
    viscous_1: float
    viscous_2: float
    flux: float
    torque_constant: float
    resistance: float
    teeth: float
    yoke: float
    brake: float
    stuck: float
    starved: float


@kernel
def _warmed(p, e, t, oil, reference_viscosity, omega, air, now):
    """`Warmth` of a thermal step that begins at ``now``."""
    mu_1, mu_2 = viscosity(t[heat.P1_OIL], oil) / reference_viscosity, viscosity(t[heat.P2_OIL], oil) / reference_viscosity
    mu_a = viscosity(0.5 * (t[heat.A_NEAR] + t[heat.A_FAR]), oil) / reference_viscosity
    mu_b = viscosity(0.5 * (t[heat.B_NEAR] + t[heat.B_FAR]), oil) / reference_viscosity
    growth = 1.0 + e.clearance_growth * max(0.0, t[heat.P2_OIL] - t[heat.P2_CORE])
    worn = 1.0 + e.wear * now
    flux = math.exp(e.magnet_slope * (t[heat.ROTOR] - 296.15))
    alpha = p.motor_copper_temperature_coefficient
    share = p.motor_end_winding_copper_share
    resistance = p.motor_phase_resistance_20C * (
        1.0 + alpha * ((1.0 - share) * (t[heat.SLOT] - 293.15) + share * (t[heat.END] - 293.15)))
    teeth, yoke = iron(omega, p, e)
    return Warmth(
        p.pump_1_leakage * e.leakage_1 * worn / mu_1, p.pump_2_leakage * e.leakage_2 * growth / mu_2,
        p.line_a_pressure_drop_laminar * mu_a, p.line_b_pressure_drop_laminar * mu_b,
        p.pump_1_friction_viscous * mu_1, p.pump_2_friction_viscous * mu_2, flux, p.motor_torque_constant * flux, resistance, teeth, yoke,
        e.brake_drag * math.exp(-max(0.0, t[heat.FRONT] - air) / 10.0), e.hot_valve * max(0.0, t[heat.B_NEAR] - e.hot_valve_from),
        e.cold_suction * viscosity(t[heat.LOW], oil) / reference_viscosity,
    )


@kernel
def _asked(program, brake, start, replayed, ramp, lag, now, h, command, move, phase, phase_until, begun, v, x):
    """The command after a step, rad/s, and where in the program it is: in phase 0 it rests, in 1 it goes, in 2 it brakes."""
    if phase == 0 and now >= phase_until and move < program.shape[0]:
        phase, begun = 1, now
        if replayed:
            if np.isfinite(start[move]):
                x = start[move]
        else:
            start[move] = x
    if phase == 1:
        target = program[move, 0]
        command += min(max(target - command, -ramp * h), ramp * h)
        if replayed:
            arrived = now >= brake[move]
        elif math.isnan(program[move, 1]):
            arrived = now - begun >= 10.0
        else:
            way = abs(v) * (0.5 * abs(command) / ramp + lag)
            arrived = (program[move, 1] - x) * (1.0 if target > 0.0 else -1.0) <= way or now - begun > 60.0
        if arrived:
            phase = 2
            if not replayed:
                brake[move] = now
    elif phase == 2:
        command -= min(max(command, -ramp * h), ramp * h)
        if command == 0.0:
            phase, phase_until = 0, now + program[move, 2]
            move += 1
    return command, move, phase, phase_until, begun, x


class Flows(NamedTuple):
    """Of both pumps: port flows q, leakages out, m3/s; drops of both lines and port pressures, Pa; what suction misses, m3/s."""

    q1: float
    q2: float
    out_1: float
    out_2: float
    drop_1: float
    drop_2: float
    port_1: float
    port_2: float
    missed: float


@kernel
def _pumped(p, e, w, omega, pa, pb):
    """`Flows` at a speed, rad/s, and chamber pressures, Pa."""
    d1, d2 = p.pump_1_displacement / (2.0 * math.pi), p.pump_2_displacement / (2.0 * math.pi)
    leak_2 = w.leak_2 * (1.0 + e.one_way_leak * (0.5 + 0.5 * omega / math.sqrt(omega * omega + 25.0)))
    missed = e.starvation * omega * abs(omega) + w.starved * d1 * omega * abs(omega) * 0.01 if omega > 0.0 else 0.0
    q1 = d1 * omega - missed - leakage(pa, w.leak_1)
    q2 = -d2 * omega - leakage(pb, leak_2)
    drop_1 = (w.drop_a + e.rough_a * math.sqrt(q1 * q1 + 4e-10)) * q1
    drop_2 = (w.drop_b * (1.0 + (e.flap if q2 > 0.0 else 0.0)) + e.rough_b * math.sqrt(q2 * q2 + 4e-10)) * q2
    port_1, port_2 = pa + drop_1, pb + drop_2
    out_1, out_2 = leakage(port_1, w.leak_1), leakage(port_2, leak_2)
    return Flows(d1 * omega - missed - out_1, -d2 * omega - out_2, out_1, out_2, drop_1, drop_2, port_1, port_2, missed)


class Shaft(NamedTuple):
    """Speed after a step, rad/s; direction of friction, 1; dry torques of pumps, of what rubs in them, and of the bearings, N*m."""

    speed: float
    direction: float
    drag_1: float
    drag_2: float
    rub_1: float
    rub_2: float
    bearing: float


@kernel
def _turned(p, e, w, omega, torque, port_1, port_2, h):
    """The `Shaft` a step later, driven by a torque, N*m; its friction implicitly."""
    d1, d2 = p.pump_1_displacement / (2.0 * math.pi), p.pump_2_displacement / (2.0 * math.pi)
    direction, slope = shaft_sign(omega)
    drag_1 = pump_drag(port_1, omega, d1, p.pump_1_friction_pressure, p.pump_1_friction_constant, 0.0)
    drag_2 = pump_drag(port_2, omega, d2, p.pump_2_friction_pressure, p.pump_2_friction_constant, 0.0)
    mixed = 0.98 + 0.08 * math.exp(-abs(omega) / 20.0)
    rub_1, rub_2 = e.rubbing_1 * mixed, e.rubbing_2 * mixed
    bearing = p.motor_friction_coulomb + e.bearing_rubbing * (0.9 + 0.1 * mixed) + w.brake
    dry = drag_1 + drag_2 + rub_1 + rub_2 + bearing
    viscous = w.viscous_1 + w.viscous_2 + p.motor_friction_viscous
    load = d1 * port_1 - d2 * port_2
    new = (omega * p.motor_inertia / h + torque - load - dry * (direction - slope * omega)) / (
        p.motor_inertia / h + dry * slope + viscous)
    return Shaft(new, direction, drag_1, drag_2, rub_1, rub_2, bearing)


@kernel
def _past_valves_and_seals(p, e, w, pa, pb, x):
    """Flows through both check valves into their sides, through the relief valve, and past the piston, m3/s."""
    check_a = p.check_valve_conductance * soft_positive(-pa - p.check_valve_cracking_pressure, 600.0)
    check_b = p.check_valve_conductance * soft_positive(-pb - p.check_valve_cracking_pressure, 600.0)
    relief = p.relief_valve_slope * soft_positive(pb - p.relief_valve_opening_pressure, 2.0e4)
    relief += e.seat_leakage * pb * (1.05 - 0.1 * min(abs(pb), 2.0e7) / 1.6e7) + w.stuck * pb
    difference = pa - pb
    middle = 0.5 * p.cylinder_stroke
    from_middle = (x - middle) / (0.25 * middle)
    worn_open = e.cross_leakage + e.worn_middle * math.exp(-from_middle * from_middle)
    return check_a, check_b, relief, worn_open * difference * (1.04 - 0.08 * min(abs(difference), 1.2e7) / 1.0e7)


@kernel
def _seal(p, e, v, difference, x, z, h):
    """Force of the piston's seal, N, and its bristles after a step, m, implicitly."""
    stuck_slope = 1.0 + h * abs(v) * BRISTLE_STIFFNESS / sliding(v, difference, p, e, x)
    z_new = (z + h * v) / stuck_slope
    return BRISTLE_STIFFNESS * z_new + BRISTLE_DAMPING * (z_new - z) / h, z_new


@kernel
def _pulled(p, e, x, activity, now, late):
    """What pulls at the rod beside the weight of the declared load, N: its geometry, its sway, and what is picked up half way."""
    middle = 0.5 * p.cylinder_stroke
    boom = (x - middle) / middle
    pull = e.boom_slope * (x - middle) * (1.06 - 0.1 * boom * boom) + e.sway * activity * math.sin(e.sway_rate * now)
    return pull + (e.picked_up * p.load_gravity if late else 0.0)


@kernel
def _pushed(p, v, x, push, mass, h):
    """The rod's velocity after a step, m/s, with the end stops' force added to ``push``, N."""
    if x < 0.0:
        push += -_STOP_STIFFNESS * x - _STOP_DAMPING * v
    elif x > p.cylinder_stroke:
        push += -_STOP_STIFFNESS * (x - p.cylinder_stroke) - _STOP_DAMPING * v
    return (v + h / mass * push) / (1.0 + h / mass * p.cylinder_friction_viscous)


@kernel
def _filled(pressure, void, volume, soft):
    """Pressure, Pa, and void, m3, of a side that so much oil, m3, flows into; its spring in m3/Pa."""
    if void > 0.0:
        return pressure, max(0.0, void - volume)
    pressure += volume / soft
    if pressure < VAPOUR:
        return VAPOUR, (VAPOUR - pressure) * soft
    return pressure, void


@kernel
def _booked(p, m, w, f, s, rubbed, current, seal, v, check_a, check_b, relief, cross, pa, pb, difference, activity):
    """Add what a step loses and moves to the sums of a thermal step, in the order of `heat`."""
    m[heat.I2] += current * current
    m[heat.TEETH_W] += w.teeth
    m[heat.YOKE_W] += w.yoke
    m[heat.BEARING_W] += (s.bearing * abs(s.direction) + p.motor_friction_viscous * rubbed) * rubbed
    m[heat.DRAG_1] += (s.drag_1 * abs(s.direction) + w.viscous_1 * rubbed) * rubbed + f.missed * f.port_1
    m[heat.DRAG_2] += (s.drag_2 * abs(s.direction) + w.viscous_2 * rubbed) * rubbed
    m[heat.RUB_1] += s.rub_1 * rubbed
    m[heat.RUB_2] += s.rub_2 * rubbed
    m[heat.LEAK_W1] += f.out_1 * f.port_1
    m[heat.LEAK_W2] += f.out_2 * f.port_2
    m[heat.LINE_WA] += f.drop_1 * f.q1
    m[heat.LINE_WB] += f.drop_2 * f.q2
    m[heat.SEAL_W] += (seal + p.cylinder_friction_viscous * v) * v
    m[heat.CROSS_W] += cross * difference
    m[heat.RELIEF_W] += relief * pb
    m[heat.CHECK_W] += -check_a * pa - check_b * pb
    m[heat.VELOCITY] += v
    m[heat.CROSS] += cross
    m[heat.RELIEF] += relief
    m[heat.CHECK_A] += check_a
    m[heat.CHECK_B] += check_b
    m[heat.LEAK_1] += f.out_1
    m[heat.LEAK_2] += f.out_2
    m[heat.MOVING] += activity


@kernel
def run(params, condition, oil, reference_viscosity, state, t, program, brake, start, replayed, ramp, duration, ambient,
        instants, samples, temperatures, ledger):
    """Run one duty in place on state (STATES,) and t (heat.N,), K.

    Args:
        params: the sheet's record, (1,). condition: `condition.CONDITION_DTYPE`, (1,). oil: `oil.vogel`'s constants.
        reference_viscosity: Pa*s, to which the sheet's coefficients refer.
        program: moves, (k, 3): signed speed (rad/s), goal (m), dwell after it (s); a goal of NaN means that the
            third number is the time of motion. brake: s, when the command began to fall, (k,); start: m, where the rod
            was when a move began, (k,). Both are written, or followed where ``replayed``: same commands, rod put where it was.
        ramp: rad/s2. duration: s. ambient: K, once per second, linear between.
        instants: s, sorted, (m,). samples: out, (m, len(FAST)).
        temperatures: out, once per 0.1 s, (n, heat.N). ledger: out, (len(LEDGER),).
    """
    p, e = params[0], condition[0]
    area_a = 0.25 * math.pi * p.cylinder_bore**2
    area_b = area_a - 0.25 * math.pi * p.cylinder_rod**2
    mass = e.payload if e.payload > 0.0 else p.load_payload_mass
    weight = mass * p.load_gravity
    gain, integral_gain = 2.0 * _DAMPING * _BANDWIDTH * p.motor_inertia, _BANDWIDTH**2 * p.motor_inertia
    lag = p.motor_speed_loop_time_constant
    m, c, rate = np.zeros(heat.MEANS), np.empty(heat.N), np.empty(heat.N)
    omega, reference, integral = state[OMEGA], state[REFERENCE], state[INTEGRAL]
    pa, pb, void_a, void_b = state[P_A], state[P_B], state[VOID_A], state[VOID_B]
    v, x, z = state[V], state[X], state[Z]
    command, move, phase, phase_until = 0.0, 0, 0, _FIRST_REST
    current, activity, slipped, fan, power_mean = 0.0, 0.0, 0.0, 0.0, 0.0
    at, h = 0, STEP
    steps = int(round(duration / h))
    begun = 0.0
    potential_0 = weight * x + 0.5 * mass * v * v + 0.5 * p.motor_inertia * omega * omega
    work_electric, work_stored, given, lost = 0.0, 0.0, 0.0, 0.0
    for n in range(steps):
        now = n * h
        if n % THERMAL_STEPS == 0:
            tick = n // THERMAL_STEPS
            if n > 0:
                for i in range(heat.MEANS):
                    m[i] /= THERMAL_STEPS
                m[heat.POSITION] = x
                second = int(now)
                part = now - second
                air = ambient[second] + part * (ambient[min(second + 1, ambient.shape[0] - 1)] - ambient[second])
                if t[heat.FRONT] > e.thermostat_from:
                    fan = 1.0
                elif t[heat.FRONT] < e.thermostat_from - 1.5:
                    fan = 0.0
                now_given, now_lost = heat.heat_step(p, e, t, m, air, fan, e.draught if now > 0.5 * duration else 0.0,
                                                     THERMAL_STEPS * h, c, rate)
                given += now_given
                lost += now_lost
                for i in range(heat.MEANS):
                    m[i] = 0.0
            else:
                air = ambient[0]
            if tick % 10 == 0 and tick // 10 < temperatures.shape[0]:
                temperatures[tick // 10] = t
            w = _warmed(p, e, t, oil, reference_viscosity, omega, air, now)
            activity += ((1.0 if abs(omega) > 1.0 else 0.0) - activity) * THERMAL_STEPS * h / _CALM
        command, move, phase, phase_until, begun, x = _asked(program, brake, start, replayed, ramp, lag, now, h, command, move, phase,
                                                             phase_until, begun, v, x)
        wanted = command * (1.0 - e.sag * abs(power_mean) * 1e-3) + e.command_zero
        acceleration = (wanted - reference) / lag
        reference += h * acceleration
        error = reference - omega
        asked = p.motor_inertia * acceleration + gain * error + integral
        limit = p.motor_current_limit * w.torque_constant
        torque = min(max(asked, -limit), limit)
        if torque == asked:
            integral += integral_gain * error * h
        current = torque / w.torque_constant * (1.0 + e.saturation * abs(torque) / limit)
        f = _pumped(p, e, w, omega, pa, pb)
        s = _turned(p, e, w, omega, torque, f.port_1, f.port_2, h)
        mean_omega = 0.5 * (omega + s.speed)
        omega = s.speed
        rubbed = abs(mean_omega)
        check_a, check_b, relief, cross = _past_valves_and_seals(p, e, w, pa, pb, x)
        difference = pa - pb
        seal, z = _seal(p, e, v, difference, x, z, h)
        pull = weight + _pulled(p, e, x, activity, now, now > 0.5 * duration)
        v_old = v
        v = _pushed(p, v, x, pa * area_a - pb * area_b - pull - seal, mass, h)
        x += h * v
        slipped += e.slip * v * abs(v) * 10.0 * h
        within = min(max(x, 0.0), p.cylinder_stroke)
        volume_a = p.line_a_volume + p.cylinder_dead_volume_piston_side + area_a * within
        volume_b = p.line_b_volume + p.cylinder_dead_volume_rod_side + area_b * (p.cylinder_stroke - within)
        net_a = f.q1 + check_a - cross - area_a * v
        net_b = f.q2 + check_b - relief + cross + area_b * v
        soft_a = softness(pa, p.oil_bulk_modulus, p.oil_air_fraction) * volume_a
        soft_b = softness(pb, p.oil_bulk_modulus, p.oil_air_fraction) * volume_b
        soft_b += e.hose_swell * (1.1 - 0.2 * min(max(pb, 0.0), 1.6e7) / 1.6e7)
        work_stored += (pa * net_a + pb * net_b) * h
        pa, void_a = _filled(pa, void_a, net_a * h, soft_a)
        pb, void_b = _filled(pb, void_b, net_b * h, soft_b)
        _booked(p, m, w, f, s, rubbed, current, seal, v, check_a, check_b, relief, cross, pa, pb, difference, activity)
        copper = 3.0 * w.resistance * current * current
        power = torque * omega + copper + w.teeth + w.yoke + e.harmonic_power
        power_mean += (power - power_mean) * h / 0.05
        work_electric += (torque * mean_omega + copper + w.teeth + w.yoke + e.harmonic_power) * h
        end = now + h
        while at < instants.shape[0] and instants[at] <= end:
            back = end - instants[at]
            resistive = p.motor_voltage_constant * w.flux * omega * _RPM + 1.7320508 * w.resistance * current
            inductive = 1.7320508 * p.motor_pole_pairs * omega * _INDUCTANCE * current
            row = samples[at]
            row[0] = command
            row[1] = omega - back / h * 2.0 * (omega - mean_omega)
            row[2] = current
            row[3] = math.sqrt(resistive * resistive + inductive * inductive)
            row[4] = power
            row[5] = pa - back * net_a / soft_a if void_a == 0.0 else pa
            row[6] = pb - back * net_b / soft_b if void_b == 0.0 else pb
            row[7] = x - back * v
            row[8] = v - back / h * (v - v_old)
            row[9] = slipped
            at += 1
    state[OMEGA], state[REFERENCE], state[INTEGRAL] = omega, reference, integral
    state[P_A], state[P_B], state[VOID_A], state[VOID_B] = pa, pb, void_a, void_b
    state[V], state[X], state[Z] = v, x, z
    ledger[0] = work_electric
    ledger[1] = weight * x + 0.5 * mass * v * v + 0.5 * p.motor_inertia * omega * omega - potential_0
    ledger[2] = work_stored
    ledger[3] = given
    ledger[4] = lost
