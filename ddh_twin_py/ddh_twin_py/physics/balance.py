"""What the operating point costs: powers, losses, heat per thermal node, oil flows.

One function for every mode. The free run calls it with its own pressures and speeds, the soft
sensor with the measured ones; the heat and the flows go to the same thermal network.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.physics import hydraulics, motor
from ddh_twin_py.physics.compiled import equation
from ddh_twin_py.physics.cylinder import coulomb_friction, load_force, piston_area, rod_side_area
from ddh_twin_py.physics.thermal_network import (
    BARREL,
    CHAMBER_A,
    CHAMBER_B,
    HOUSING,
    LINE_A,
    LINE_A_WALL,
    LINE_B,
    LINE_B_WALL,
    N,
    N_FLOWS,
    PUMP_1_CASE,
    PUMP_1_OIL,
    PUMP_2_CASE,
    PUMP_2_OIL,
    ROTOR,
    TANK,
    TANK_WALL,
    TEETH,
    VALVE_OIL,
    YOKE,
)

OPERATING_FIELDS = (
    "speed", "speed_absolute", "current", "mean_square_current", "torque", "voltage", "electrical_power",
    "pressure_piston_side", "pressure_rod_side", "pump_1_port_pressure", "pump_2_port_pressure",
    "rod_position", "rod_velocity", "cylinder_force", "friction_force",
    "pump_1_flow", "pump_2_flow", "pump_1_leakage", "pump_2_leakage", "relief_flow", "check_a_flow", "check_b_flow",
    "pump_1_torque", "pump_2_torque", "shaft_power", "hydraulic_power", "mechanical_power", "compression_power",
    "loss_copper", "loss_iron", "loss_motor_friction", "loss_pump_1", "loss_pump_2", "loss_line_a", "loss_line_b",
    "loss_cylinder", "loss_relief_valve", "loss_check_valve",
)
"""Scalars of an operating point, means over an interval, SI (rad/s, A, N*m, V, W, Pa, m, m/s, N, m3/s)."""

OPERATING_DTYPE = np.dtype(
    [(name, np.float64) for name in OPERATING_FIELDS] + [("heat", np.float64, (N,)), ("flow", np.float64, (N_FLOWS,))]
)
"""An operating point: `OPERATING_FIELDS`, heat into each thermal node (W, copper loss left out) and
oil flows (m3/s, see `thermal_network.FLOWS`)."""

SCALAR_DTYPE = np.dtype([(name, np.float64) for name in OPERATING_FIELDS])
"""An operating point without heat and flow: what is kept of a long run."""


def scalars(points: np.ndarray) -> np.ndarray:
    """The `OPERATING_FIELDS` of operating points (n,), as `SCALAR_DTYPE` (n,)."""
    columns = points.view(np.float64).reshape(points.size, -1)[:, : len(OPERATING_FIELDS)]
    return np.ascontiguousarray(columns).view(SCALAR_DTYPE)[:, 0]


@equation
def clear(point):
    """Set an operating point to zero, ready for `add_point`."""
    point.speed = 0.0
    point.speed_absolute = 0.0
    point.current = 0.0
    point.mean_square_current = 0.0
    point.torque = 0.0
    point.voltage = 0.0
    point.electrical_power = 0.0
    point.pressure_piston_side = 0.0
    point.pressure_rod_side = 0.0
    point.pump_1_port_pressure = 0.0
    point.pump_2_port_pressure = 0.0
    point.rod_position = 0.0
    point.rod_velocity = 0.0
    point.cylinder_force = 0.0
    point.friction_force = 0.0
    point.pump_1_flow = 0.0
    point.pump_2_flow = 0.0
    point.pump_1_leakage = 0.0
    point.pump_2_leakage = 0.0
    point.relief_flow = 0.0
    point.check_a_flow = 0.0
    point.check_b_flow = 0.0
    point.pump_1_torque = 0.0
    point.pump_2_torque = 0.0
    point.shaft_power = 0.0
    point.hydraulic_power = 0.0
    point.mechanical_power = 0.0
    point.compression_power = 0.0
    point.loss_copper = 0.0
    point.loss_iron = 0.0
    point.loss_motor_friction = 0.0
    point.loss_pump_1 = 0.0
    point.loss_pump_2 = 0.0
    point.loss_line_a = 0.0
    point.loss_line_b = 0.0
    point.loss_cylinder = 0.0
    point.loss_relief_valve = 0.0
    point.loss_check_valve = 0.0
    point.heat[:] = 0.0
    point.flow[:] = 0.0


@equation
def add_motor(point, weight, speed, current, copper_resistance, magnets, iron, p):
    """Add the motor at an operating point: losses, voltage and power, P_el = K_t i w + P_cu + P_fe + what is reported of P_pwm.

    ``weight`` of the instant in the mean, 1; ``speed`` in rad/s, ``current`` in A rms, ``copper_resistance`` in ohm per phase,
    ``magnets`` from `motor.magnet_factor`, ``iron`` from `motor.iron_coefficients`. The drive's torque is its current by
    the sheet's constant; friction heats rotor and housing alike, switching loss teeth and yoke alike.
    """
    copper = 3.0 * copper_resistance * current * current
    teeth, yoke = motor.iron_losses(speed, iron, p)
    friction = motor.friction_loss(speed, p)
    switching = p.motor_pwm_loss
    point.speed += weight * speed
    point.speed_absolute += weight * abs(speed)
    point.current += weight * current
    point.mean_square_current += weight * current * current
    point.torque += weight * p.motor_torque_constant * current
    point.voltage += weight * motor.line_voltage(speed, current, copper_resistance, magnets, p)
    point.electrical_power += weight * (
        magnets * p.motor_torque_constant * current * speed + copper + teeth + yoke + p.motor_pwm_loss_reported * switching
    )
    point.loss_copper += weight * copper
    point.loss_iron += weight * (teeth + yoke + switching)
    point.loss_motor_friction += weight * friction
    point.heat[TEETH] += weight * (teeth + 0.5 * switching)
    point.heat[YOKE] += weight * (yoke + 0.5 * switching)
    point.heat[ROTOR] += weight * 0.5 * friction
    point.heat[HOUSING] += weight * 0.5 * friction


@equation
def motor_current(speed, acceleration, pump_torque, torque_constant, p):
    """Current that the motion takes, A rms: (J dw/dt + T_1 + T_2 + T_motor friction)/K_t.

    ``speed`` in rad/s, ``acceleration`` in rad/s2, ``pump_torque`` (T_1 + T_2) in N*m, ``torque_constant`` in N*m/A.
    """
    torque = p.motor_inertia * acceleration + pump_torque + hydraulics.motor_friction_torque(speed, p)
    return torque / torque_constant


@equation
def add_further_heat(point, p):
    """Add to an operating point what the sun gives to motor housing, tank wall and barrel by their areas, and learned heats, W."""
    if p.surroundings_solar_load != 0.0:
        total = p.motor_housing_area + p.tank_area + p.cylinder_barrel_area
        point.heat[HOUSING] += p.surroundings_solar_load * p.motor_housing_area / total
        point.heat[TANK_WALL] += p.surroundings_solar_load * p.tank_area / total
        point.heat[BARREL] += p.surroundings_solar_load * p.cylinder_barrel_area / total
    speed = point.speed_absolute
    point.heat[HOUSING] += p.learned_motor_heat + p.learned_motor_heat_by_speed * speed
    point.heat[PUMP_1_CASE] += p.learned_pump_1_heat + p.learned_pump_1_heat_by_speed * speed
    point.heat[PUMP_2_CASE] += p.learned_pump_2_heat + p.learned_pump_2_heat_by_speed * speed
    point.heat[LINE_A_WALL] += p.learned_line_a_heat + p.learned_line_a_heat_by_speed * speed
    point.heat[LINE_B_WALL] += p.learned_line_b_heat + p.learned_line_b_heat_by_speed * speed
    point.heat[BARREL] += p.learned_cylinder_heat + p.learned_cylinder_heat_by_speed * speed
    point.heat[TANK] += p.learned_tank_heat + p.learned_tank_heat_by_speed * speed


@equation
def add_hydraulics(point, weight, speed, pressure_a, pressure_b, velocity, position, check_a, check_b, relief, c, p):
    """Add pumps, lines, cylinder and valves at an operating point.

    Advection follows the piston: what the cylinder takes in comes through the line from pump
    and check valve, so that the volume of oil is kept exactly; compression does not advect.
    Losses and flows as equations: docs/physics.md, heat and oil flows.

    Args:
        weight: of the instant in the mean, 1. speed: rad/s. pressure_a, pressure_b: Pa gauge, not below the vapour pressure.
        velocity: m/s. position: m. check_a, check_b, relief: flows of the valves, m3/s. c: from `hydraulics.coefficients`.
    Returns:
        torque of both pumps, N*m.
    """
    flow_1, flow_2, port_1, port_2 = hydraulics.pump_flows(speed, pressure_a, pressure_b, c, p)
    torque_1, torque_2, lost_1, lost_2 = hydraulics.pump_torques(speed, port_1, port_2, c, p)
    leak_1, leak_2 = c[0] * port_1, c[1] * port_2
    area_a, area_b = piston_area(p), rod_side_area(p)

    heat_1, heat_2 = lost_1 * speed, lost_2 * speed
    added_1 = p.pump_1_friction_added * abs(speed)
    added_2 = p.pump_2_friction_added * abs(speed)
    empty_1 = hydraulics.displacement_1(p) - hydraulics.delivered_1(speed, c, p)
    empty_2 = hydraulics.displacement_2(p) - hydraulics.delivered_2(speed, c, p)
    leak_heat_1 = leak_1 * port_1 + empty_1 * speed * port_1
    leak_heat_2 = leak_2 * port_2 + empty_2 * speed * port_2
    share_1, share_2 = p.pump_1_friction_share_to_case, p.pump_2_friction_share_to_case
    line_a, line_b = (port_1 - pressure_a) * flow_1, (port_2 - pressure_b) * flow_2
    cross = p.cylinder_cross_leakage * (pressure_a - pressure_b)
    cross_heat = cross * (pressure_a - pressure_b)
    dry = coulomb_friction(velocity, pressure_a - pressure_b, p)
    rubbing = min(1.0, abs(velocity) / max(p.cylinder_creep_velocity, 1.0e-12)) * dry
    seal = rubbing * abs(velocity) + p.cylinder_friction_viscous * velocity * velocity
    relief_heat = relief * pressure_b
    check_heat = -check_a * pressure_a - check_b * pressure_b

    point.heat[PUMP_1_CASE] += weight * (share_1 * heat_1 + added_1)
    point.heat[PUMP_1_OIL] += weight * ((1.0 - share_1) * heat_1 + leak_heat_1)
    point.heat[PUMP_2_CASE] += weight * (share_2 * heat_2 + added_2)
    point.heat[PUMP_2_OIL] += weight * ((1.0 - share_2) * heat_2 + leak_heat_2)
    point.heat[LINE_A] += weight * line_a
    point.heat[LINE_B] += weight * line_b
    to_barrel = p.cylinder_friction_share_to_barrel * seal
    to_chamber = 0.5 * (seal - to_barrel + cross_heat)
    point.heat[BARREL] += weight * to_barrel
    point.heat[CHAMBER_A] += weight * to_chamber
    point.heat[CHAMBER_B] += weight * to_chamber
    point.heat[VALVE_OIL] += weight * relief_heat
    point.heat[TANK] += weight * check_heat

    chamber_a, chamber_b = area_a * velocity + cross, -area_b * velocity - cross
    port_a, port_b = chamber_a - check_a, chamber_b - check_b + relief
    low = 1.0 - p.tank_suction_from_top
    drawn_1 = _add_side(point.flow, 0, weight, port_a, leak_1, chamber_a, check_a, low)
    drawn_2 = _add_side(point.flow, 7, weight, port_b, leak_2, chamber_b, check_b, low)
    point.flow[14] += weight * relief
    point.flow[15] += weight * relief
    point.flow[16] += weight * max(cross, 0.0)
    point.flow[17] += weight * max(-cross, 0.0)
    point.flow[18] += weight * (low * (drawn_1 + drawn_2) + check_a + check_b)
    point.flow[19] += weight * (1.0 - low) * drawn_1
    point.flow[20] += weight * (1.0 - low) * drawn_2

    point.pressure_piston_side += weight * pressure_a
    point.pressure_rod_side += weight * pressure_b
    point.pump_1_port_pressure += weight * port_1
    point.pump_2_port_pressure += weight * port_2
    point.rod_position += weight * position
    point.rod_velocity += weight * velocity
    force = pressure_a * area_a - pressure_b * area_b
    point.cylinder_force += weight * force
    point.friction_force += weight * _friction_force(velocity, dry, force - load_force(position, p), p)
    point.pump_1_flow += weight * flow_1
    point.pump_2_flow += weight * flow_2
    point.pump_1_leakage += weight * leak_1
    point.pump_2_leakage += weight * leak_2
    point.relief_flow += weight * relief
    point.check_a_flow += weight * check_a
    point.check_b_flow += weight * check_b
    point.pump_1_torque += weight * torque_1
    point.pump_2_torque += weight * torque_2
    point.shaft_power += weight * (torque_1 + torque_2) * speed
    point.hydraulic_power += weight * (port_1 * flow_1 + port_2 * flow_2)
    point.mechanical_power += weight * force * velocity
    point.compression_power += weight * (
        pressure_a * (flow_1 + check_a - chamber_a) + pressure_b * (flow_2 + check_b - relief - chamber_b)
    )
    point.loss_pump_1 += weight * (heat_1 + added_1 + leak_heat_1)
    point.loss_pump_2 += weight * (heat_2 + added_2 + leak_heat_2)
    point.loss_line_a += weight * line_a
    point.loss_line_b += weight * line_b
    point.loss_cylinder += weight * (seal + cross_heat)
    point.loss_relief_valve += weight * relief_heat
    point.loss_check_valve += weight * check_heat
    return torque_1 + torque_2


@equation
def _friction_force(velocity, dry, drive, p):
    """Friction of the piston, N: against its motion or creep, or at rest against the force (N) that would drive it."""
    if abs(velocity) < p.cylinder_creep_velocity:
        return (dry / p.cylinder_creep_velocity + p.cylinder_friction_viscous) * velocity
    if velocity != 0.0:
        return math.copysign(dry, velocity) + p.cylinder_friction_viscous * velocity
    return min(max(drive, -dry), dry)


@equation
def _add_side(flow, first, weight, port, leak, chamber, check, low):
    """Add the flows of one side: tank, pump, line, chamber, each in its own direction, m3/s.

    ``low`` is the share of the suction from the tank's lower layer.

    Returns:
        what the pump draws from the tank, m3/s.
    """
    leak = max(leak, 0.0)
    displaced = port + leak
    drawn = max(displaced, 0.0)
    flow[first] += weight * low * drawn
    flow[first + 1] += weight * (leak + max(-displaced, 0.0))
    flow[first + 2] += weight * max(port, 0.0)
    flow[first + 3] += weight * max(-port, 0.0)
    flow[first + 4] += weight * max(chamber, 0.0)
    flow[first + 5] += weight * max(-chamber, 0.0)
    flow[first + 6] += weight * check
    return drawn
