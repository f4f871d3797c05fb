"""Which speed the drive can hold with the oil as cold as it is: current limit and suction.

The model's own equations at rest of pressures and motion: at a shaft speed w find p_B, and with it
v from the rod side's flow balance and p_A from the piston side's, such that the forces on the
piston balance (every d/dt of `physics.hydraulics` zero). Cold oil hardly leaks, so that p_A hangs
on p_B by up to 10^6 Pa per Pa: roots are sought to the last digits.
"""

from __future__ import annotations

from ddh_twin_py.physics.compiled import inlined, kernel
from ddh_twin_py.physics.cylinder import coulomb_friction, load_force, piston_area, rod_side_area
from ddh_twin_py.physics.hydraulics import coefficients, motor_friction_torque, pump_flows, pump_torques
from ddh_twin_py.physics.motor import available_current, magnet_factor
from ddh_twin_py.physics.oil import VAPOUR_PRESSURE
from ddh_twin_py.physics.thermal_network import END_WINDING, ROTOR, SLOT_WINDING
from ddh_twin_py.physics.valves import check_flow, relief_flow

CURRENT_SHARE = 0.95
"""Of the current limit that the controller uses, so that changes of load still find some."""
SUCTION_MARGIN = 1.0e4
"""Pa above the vapour pressure that the controller keeps in ports and chambers."""
STEADY = ("pressure_piston_side", "pressure_rod_side", "rod_velocity", "pump_1_port_pressure", "pump_2_port_pressure", "torque")
"""What `steady_operation` gives: Pa, Pa, m/s, Pa, Pa, N*m at the shaft."""
NOTHING, BY_CURRENT, BY_SUCTION = 0, 1, 2
LIMITS = ("nothing", "current", "suction")
"""What a speed is limited by."""

_LOWEST, _HIGHEST, _TRIES = -1.0e7, 2.0e8, 200  # Pa


@inlined
def _next_guess(low, f_low, high, f_high, k):
    """Where to look for the root at try ``k``: by secant, every third time by bisection."""
    return 0.5 * (low + high) if k % 3 == 2 else (low * f_high - high * f_low) / (f_high - f_low)


@inlined
def _narrowed(middle, f, low, f_low, high, f_high, side):
    """The bracket with ``middle`` as its new end; the end that stays a second time counts half (Illinois)."""
    if f > 0.0:
        return middle, f, high, 0.5 * f_high if side == 1 else f_high, 1
    return low, 0.5 * f_low if side == -1 else f_low, middle, f, -1


@inlined
def _piston_side(speed, pressure_b, velocity, c, p):
    """p_A at which the piston side's flows balance, Pa: Q_1 + Q_check,A - Q_cross = A_A v, by secant and bisection."""
    low, high = _LOWEST, _HIGHEST
    f_low, f_high = _piston_flow(speed, low, pressure_b, velocity, c, p), _piston_flow(speed, high, pressure_b, velocity, c, p)
    side = 0
    for k in range(_TRIES):
        middle = _next_guess(low, f_low, high, f_high, k)
        f = _piston_flow(speed, middle, pressure_b, velocity, c, p)
        if abs(f) < 1e-18 or high - low < 1e-4:
            return middle
        low, f_low, high, f_high, side = _narrowed(middle, f, low, f_low, high, f_high, side)
    return 0.5 * (low + high)


@inlined
def _piston_flow(speed, pressure_a, pressure_b, velocity, c, p):
    """m3/s into the piston side beyond what its motion takes."""
    flow_1, _, _, _ = pump_flows(speed, pressure_a, pressure_b, c, p)
    return flow_1 + check_flow(pressure_a, p) - p.cylinder_cross_leakage * (pressure_a - pressure_b) - piston_area(p) * velocity


@inlined
def _force(speed, pressure_b, pressure_a_before, position, c, p):
    """Force on the piston, N, at a rod-side pressure, with v and p_A from the flows; returns force, p_A, v."""
    _, flow_2, _, _ = pump_flows(speed, pressure_a_before, pressure_b, c, p)
    cross = p.cylinder_cross_leakage * (pressure_a_before - pressure_b)
    velocity = -(flow_2 + check_flow(pressure_b, p) - relief_flow(pressure_b, p) + cross) / rod_side_area(p)
    pressure_a = _piston_side(speed, pressure_b, velocity, c, p)
    dry = coulomb_friction(velocity, pressure_a - pressure_b, p)
    if speed < 0.0:
        dry = -dry
    force = (
        pressure_a * piston_area(p) - pressure_b * rod_side_area(p) - load_force(position, p) - dry
        - p.cylinder_friction_viscous * velocity
    )
    return force, pressure_a, velocity


@kernel
def steady_operation(params, temperature, speed, position, out):
    """What a shaft speed (rad/s) settles to at oil temperatures (N, K); ``out`` (6) is `STEADY`.

    ``position`` in m tells the load force. A pressure below vapour pressure means that the speed
    cannot be held. Viscosity under pressure and cross leakage are taken at the pressures of the
    pass before, four passes.
    """
    p = params[0]
    pressure_a, pressure_b = 0.0, 0.0
    passes = 4 if p.oil_viscosity_pressure_coefficient != 0.0 or p.cylinder_cross_leakage != 0.0 else 1
    velocity = 0.0
    c = coefficients(temperature, pressure_a, pressure_b, p)
    for _ in range(passes):
        c = coefficients(temperature, max(pressure_a, 0.0), max(pressure_b, 0.0), p)
        known_a = pressure_a
        low, high = _LOWEST, _HIGHEST
        f_low, _, _ = _force(speed, low, known_a, position, c, p)
        f_high, _, _ = _force(speed, high, known_a, position, c, p)
        side = 0
        for k in range(_TRIES):
            pressure_b = _next_guess(low, f_low, high, f_high, k)
            f, pressure_a, velocity = _force(speed, pressure_b, known_a, position, c, p)
            if abs(f) < 1e-2 or high - low < 1e-10:
                break
            low, f_low, high, f_high, side = _narrowed(pressure_b, f, low, f_low, high, f_high, side)
    _, _, port_1, port_2 = pump_flows(speed, pressure_a, pressure_b, c, p)
    torque_1, torque_2, _, _ = pump_torques(speed, port_1, port_2, c, p)
    out[0], out[1], out[2], out[3], out[4] = pressure_a, pressure_b, velocity, port_1, port_2
    out[5] = torque_1 + torque_2 + motor_friction_torque(speed, p)


@kernel
def highest_speed(params, temperature, sign, top, ramp, out):
    """Highest shaft speed in one direction (sign 1 raises, -1 lowers) that can be held, rad/s, at most ``top``.

    Held is a speed whose current with the ramp's (rad/s2) is within `CURRENT_SHARE` of the limit
    and which leaves every port and chamber `SUCTION_MARGIN` above the vapour pressure. Found by
    bisection to 0.1 %; 0 where not even 0.1 % of ``top`` can be held.

    Returns:
        the speed, not negative, and what forbids more: index in `LIMITS`.
    """
    p = params[0]
    position = p.cylinder_stroke if sign > 0.0 else 0.0
    limit = (
        CURRENT_SHARE * available_current(temperature[SLOT_WINDING], temperature[END_WINDING], p)
        * p.motor_torque_constant * magnet_factor(temperature[ROTOR], p)
    )
    low, high, reason = 0.0, top, NOTHING
    for k in range(12):
        speed = top if k == 0 else 0.5 * (low + high)
        steady_operation(params, temperature, sign * speed, position, out)
        torque = abs(out[5]) + p.motor_inertia * ramp
        least = min(min(out[0], out[1]), min(out[3], out[4]))
        forbidden = NOTHING
        if torque > limit:
            forbidden = BY_CURRENT
        elif least < VAPOUR_PRESSURE + SUCTION_MARGIN:
            forbidden = BY_SUCTION
        if forbidden == NOTHING:
            if k == 0:
                return speed, NOTHING
            low = speed
        else:
            high, reason = speed, forbidden
    return low, reason


@kernel
def steady_operations(params, temperature, speeds, position, out):
    """`steady_operation` at each of ``speeds``, rad/s, (n,), into ``out`` (n, 6)."""
    for k in range(speeds.shape[0]):
        steady_operation(params, temperature, speeds[k], position, out[k])
