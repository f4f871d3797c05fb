"""Thermal side of the plant: 29 nodes, explicit steps of 10 ms, Churchill-Chu convection.

Two housing halves, pump cases in skin and core, lines in two cells, barrel in three sections, a tank in three layers,
the machine's frame. Oil carries its enthalpy with the mean flow of a step, upwind.
"""

from __future__ import annotations

import math

from ddh_twin_py.plant.compiled import kernel

NODES = (
    "slot", "end_winding", "teeth", "yoke", "rotor", "housing_front", "housing_rear",
    "pump_1_oil", "pump_1_core", "pump_1_skin", "pump_2_oil", "pump_2_core", "pump_2_skin",
    "line_a_near", "line_a_far", "line_b_near", "line_b_far", "line_a_wall", "line_b_wall",
    "chamber_a", "chamber_b", "barrel_a", "barrel_middle", "barrel_b",
    "tank_top", "tank_middle", "tank_low", "tank_wall", "frame",
)
"""Order of the plant's temperatures."""
N = len(NODES)
(SLOT, END, TEETH, YOKE, ROTOR, FRONT, REAR, P1_OIL, P1_CORE, P1_SKIN, P2_OIL, P2_CORE, P2_SKIN, A_NEAR, A_FAR, B_NEAR, B_FAR,
 A_WALL, B_WALL, CH_A, CH_B, BAR_A, BAR_M, BAR_B, TOP, MIDDLE, LOW, TANK_WALL, FRAME) = range(N)

READS = {
    "motor_winding": {"end_winding": 1.0}, "motor_housing": {"housing_front": 0.5, "housing_rear": 0.5},
    "pump_1_case": {"pump_1_skin": 1.0}, "pump_2_case": {"pump_2_skin": 1.0},
    "tank_oil": {"tank_top": 1 / 3, "tank_middle": 1 / 3, "tank_low": 1 / 3}, "tank_wall": {"tank_wall": 1.0},
    "cylinder_barrel": {"barrel_a": 0.25, "barrel_middle": 0.5, "barrel_b": 0.25},
    "line_a": {"line_a_wall": 1.0}, "line_b": {"line_b_wall": 1.0},
}
"""Temperature sensor to the nodes that it touches, with weights."""

_HOUSING_LINK, _SKIN_LINK, _BARREL_LINK, _LAYER_LINK = 60.0, 400.0, 60.0, 4000.0  # W/K
_FRAME_CAPACITY, _FRAME_LOSS = 6.0e4, 12.0  # J/K, W/K
_TYPICAL = 8.0  # K, rise at which the convection is the sheet's
_RAYLEIGH = 1.1e6  # at that rise
_SIGMA = 5.670374419e-8

(I2, TEETH_W, YOKE_W, BEARING_W, DRAG_1, DRAG_2, LEAK_W1, LEAK_W2, LINE_WA, LINE_WB, SEAL_W, CROSS_W, RELIEF_W, CHECK_W,
 VELOCITY, CROSS, RELIEF, CHECK_A, CHECK_B, LEAK_1, LEAK_2, RUB_1, RUB_2, MOVING, POSITION) = range(25)
"""Means over a thermal step: A2, W, m/s, m3/s, and the share of it in motion."""
MEANS = 25


@kernel
def natural(rise, coefficient):
    """Convection, W/m2: h of Churchill and Chu (horizontal cylinder, 1975), scaled to the sheet's C at a typical rise."""
    size = abs(rise)
    typical = 0.60 + 0.3206 * _RAYLEIGH ** (1.0 / 6.0)
    shape = (0.60 + 0.3206 * (_RAYLEIGH * size / _TYPICAL) ** (1.0 / 6.0)) / typical
    return coefficient * math.sqrt(math.sqrt(_TYPICAL)) * shape * shape * rise


@kernel
def _surface(t, node, air, area, convection, emissivity, wind, rate):
    lost = area * (natural(t[node] - air, convection) * wind + emissivity * _SIGMA * (t[node] ** 4 - air**4))
    rate[node] -= lost
    return lost


@kernel
def _link(t, a, b, conductance, rate):
    q = conductance * (t[a] - t[b])
    rate[a] -= q
    rate[b] += q


@kernel
def _carry(t, source, target, flow, rate):
    """Enthalpy carried by a flow (W/K, signed from source to target) into whichever node it enters."""
    if flow > 0.0:
        rate[target] += flow * (t[source] - t[target])
    else:
        rate[source] -= flow * (t[target] - t[source])


@kernel
def capacities(p, e, position, c):
    """Fill heat capacities, J/K, shape (N,)."""
    rho_c = p.oil_density_15C * (1.0 - 8.0 * p.oil_thermal_expansion) * p.oil_specific_heat
    area_a = 0.25 * math.pi * p.cylinder_bore**2
    area_b = area_a - 0.25 * math.pi * p.cylinder_rod**2
    c[SLOT], c[END] = p.motor_slot_winding_capacity, p.motor_end_winding_capacity
    c[TEETH], c[YOKE], c[ROTOR] = p.motor_teeth_capacity, p.motor_yoke_capacity, p.motor_rotor_capacity
    c[FRONT], c[REAR] = 0.55 * p.motor_housing_capacity, 0.45 * p.motor_housing_capacity
    c[P1_OIL], c[P1_CORE], c[P1_SKIN] = rho_c * p.pump_1_oil_volume, 0.5 * p.pump_1_case_capacity, 0.5 * p.pump_1_case_capacity
    c[P2_OIL], c[P2_CORE], c[P2_SKIN] = rho_c * p.pump_2_oil_volume, 0.5 * p.pump_2_case_capacity, 0.5 * p.pump_2_case_capacity
    c[A_NEAR] = c[A_FAR] = 0.5 * rho_c * p.line_a_volume
    c[B_NEAR] = c[B_FAR] = 0.5 * rho_c * p.line_b_volume
    c[A_WALL], c[B_WALL] = p.line_a_wall_capacity, p.line_b_wall_capacity
    x = min(max(position, 0.0), p.cylinder_stroke)
    c[CH_A] = rho_c * (p.cylinder_dead_volume_piston_side + area_a * x)
    c[CH_B] = rho_c * (p.cylinder_dead_volume_rod_side + area_b * (p.cylinder_stroke - x))
    c[BAR_A] = c[BAR_B] = 0.25 * p.cylinder_barrel_capacity
    c[BAR_M] = 0.5 * p.cylinder_barrel_capacity
    oil = rho_c * (p.tank_oil_volume * e.fill_ratio - (area_a - area_b) * x)
    c[TOP] = c[MIDDLE] = c[LOW] = oil / 3.0
    c[TANK_WALL], c[FRAME] = p.tank_wall_capacity, _FRAME_CAPACITY
    return rho_c


@kernel
def heat_step(p, e, t, m, ambient, fan_on, draught, step, c, rate):
    """Advance temperatures t (N,), K, by ``step`` s with the means m of that step (MEANS,).

    Args:
        p, e: sheet and condition. ambient: K, as its sensor reads it. fan_on: of a thermostat, 0 or 1.
        draught: share by which all surfaces cool better.
        c, rate: scratch, (N,).

    Returns:
        heat given to the oil and solids, heat lost to ambient, J, over the step.
    """
    rho_c = capacities(p, e, m[POSITION], c)
    air = ambient + e.enclosure
    for i in range(N):
        rate[i] = 0.0
    alpha = p.motor_copper_temperature_coefficient
    total = 3.0 * p.motor_phase_resistance_20C * m[I2]
    share = p.motor_end_winding_copper_share
    rate[SLOT] += (1.0 - share) * total * (1.0 + alpha * (t[SLOT] - 293.15))
    rate[END] += share * total * (1.0 + alpha * (t[END] - 293.15))
    rate[TEETH] += m[TEETH_W] + 0.5 * e.harmonic_power
    rate[YOKE] += m[YOKE_W] + 0.4 * e.harmonic_power
    rate[ROTOR] += 0.5 * m[BEARING_W] + 0.1 * e.harmonic_power
    rate[FRONT] += 0.275 * m[BEARING_W]
    rate[REAR] += 0.225 * m[BEARING_W]
    s1, s2 = p.pump_1_friction_share_to_case, p.pump_2_friction_share_to_case
    rate[P1_CORE] += s1 * m[DRAG_1] + m[RUB_1]
    rate[P1_OIL] += (1.0 - s1) * m[DRAG_1] + m[LEAK_W1]
    rate[P2_CORE] += s2 * m[DRAG_2] + m[RUB_2]
    rate[P2_OIL] += (1.0 - s2) * m[DRAG_2] + m[LEAK_W2]
    rate[A_NEAR] += 0.5 * m[LINE_WA]
    rate[A_FAR] += 0.5 * m[LINE_WA]
    rate[B_NEAR] += 0.5 * m[LINE_WB]
    rate[B_FAR] += 0.5 * m[LINE_WB]
    rate[CH_A] += 0.25 * m[SEAL_W] + 0.5 * m[CROSS_W]
    rate[CH_B] += 0.25 * m[SEAL_W] + 0.5 * m[CROSS_W]
    rate[BAR_A] += 0.125 * m[SEAL_W]
    rate[BAR_M] += 0.25 * m[SEAL_W]
    rate[BAR_B] += 0.125 * m[SEAL_W]
    rate[TOP] += m[RELIEF_W]
    rate[LOW] += m[CHECK_W]
    rate[A_WALL] += e.hose_heater
    sunlit = p.motor_housing_area + p.tank_area + p.cylinder_barrel_area
    sun = e.sun / sunlit
    rate[FRONT] += 0.55 * sun * p.motor_housing_area
    rate[REAR] += 0.45 * sun * p.motor_housing_area
    rate[TANK_WALL] += sun * p.tank_area
    rate[BAR_A] += 0.25 * sun * p.cylinder_barrel_area
    rate[BAR_M] += 0.5 * sun * p.cylinder_barrel_area
    rate[BAR_B] += 0.25 * sun * p.cylinder_barrel_area
    given = 0.0
    for i in range(N):
        given += rate[i]

    _link(t, SLOT, END, p.motor_slot_to_end_winding, rate)
    _link(t, SLOT, TEETH, p.motor_slot_to_teeth, rate)
    _link(t, END, REAR, p.motor_end_winding_to_housing, rate)
    _link(t, TEETH, YOKE, p.motor_teeth_to_yoke, rate)
    _link(t, TEETH, ROTOR, p.motor_teeth_to_rotor, rate)
    _link(t, YOKE, FRONT, 0.55 * p.motor_yoke_to_housing / e.interface_ratio, rate)
    _link(t, YOKE, REAR, 0.45 * p.motor_yoke_to_housing / e.interface_ratio, rate)
    _link(t, ROTOR, FRONT, p.motor_rotor_to_housing, rate)
    _link(t, FRONT, REAR, _HOUSING_LINK, rate)
    _link(t, FRONT, P1_SKIN, 0.5 * e.flange, rate)
    _link(t, FRONT, P1_CORE, 0.5 * e.flange, rate)
    _link(t, P1_OIL, P1_CORE, p.pump_1_oil_to_case, rate)
    _link(t, P2_OIL, P2_CORE, p.pump_2_oil_to_case, rate)
    _link(t, P1_CORE, P1_SKIN, _SKIN_LINK, rate)
    _link(t, P2_CORE, P2_SKIN, _SKIN_LINK, rate)
    _link(t, P1_CORE, P2_CORE, p.pump_case_link, rate)
    _link(t, A_NEAR, A_WALL, 0.5 * p.line_a_oil_to_wall, rate)
    _link(t, A_FAR, A_WALL, 0.5 * p.line_a_oil_to_wall, rate)
    _link(t, B_NEAR, B_WALL, 0.5 * p.line_b_oil_to_wall, rate)
    _link(t, B_FAR, B_WALL, 0.5 * p.line_b_oil_to_wall, rate)
    to_a, to_b = p.cylinder_oil_to_barrel_piston_side, p.cylinder_oil_to_barrel_rod_side
    _link(t, CH_A, BAR_A, 0.4 * to_a, rate)
    _link(t, CH_A, BAR_M, 0.6 * to_a, rate)
    _link(t, CH_B, BAR_B, 0.4 * to_b, rate)
    _link(t, CH_B, BAR_M, 0.6 * to_b, rate)
    _link(t, BAR_A, BAR_M, _BARREL_LINK, rate)
    _link(t, BAR_M, BAR_B, _BARREL_LINK, rate)
    wet = p.tank_oil_to_wall / 3.0 * (1.0 - e.foam * m[MOVING])
    _link(t, TOP, TANK_WALL, wet, rate)
    _link(t, MIDDLE, TANK_WALL, wet, rate)
    _link(t, LOW, TANK_WALL, wet, rate)
    _link(t, TOP, MIDDLE, _LAYER_LINK, rate)
    _link(t, MIDDLE, LOW, _LAYER_LINK, rate)
    _link(t, TANK_WALL, FRAME, e.mount, rate)

    area_a = 0.25 * math.pi * p.cylinder_bore**2
    area_b = area_a - 0.25 * math.pi * p.cylinder_rod**2
    into_a, into_b = area_a * m[VELOCITY], -area_b * m[VELOCITY]  # what the chambers take in
    from_a, from_b = into_a + m[CROSS] - m[CHECK_A], into_b - m[CROSS] - m[CHECK_B] + m[RELIEF]  # from the pumps
    _carry(t, A_FAR, CH_A, rho_c * (into_a + m[CROSS]), rate)
    _carry(t, A_NEAR, A_FAR, rho_c * (into_a + m[CROSS]), rate)
    _carry(t, LOW, A_NEAR, rho_c * m[CHECK_A], rate)
    _carry(t, P1_OIL, A_NEAR, rho_c * from_a, rate)
    _carry(t, B_FAR, CH_B, rho_c * (into_b - m[CROSS]), rate)
    _carry(t, B_NEAR, B_FAR, rho_c * (into_b - m[CROSS]), rate)
    _carry(t, LOW, B_NEAR, rho_c * m[CHECK_B], rate)
    _carry(t, P2_OIL, B_NEAR, rho_c * from_b, rate)
    _carry(t, B_NEAR, TOP, rho_c * m[RELIEF], rate)
    _carry(t, CH_A, CH_B, rho_c * m[CROSS], rate)
    leak_1, leak_2 = max(m[LEAK_1], 0.0), max(m[LEAK_2], 0.0)
    drawn = m[CHECK_A] + m[CHECK_B]
    returned = leak_1 + leak_2 + m[RELIEF]
    _carry(t, P1_OIL, TOP, rho_c * leak_1, rate)
    _carry(t, P2_OIL, TOP, rho_c * leak_2, rate)
    for pump, flow in ((P1_OIL, from_a + leak_1), (P2_OIL, from_b + leak_2)):
        if flow > 0.0:
            _carry(t, LOW, pump, rho_c * flow, rate)
            drawn += flow
        else:
            _carry(t, pump, TOP, -rho_c * flow, rate)
            returned -= flow
    third = (returned - drawn) / 3.0
    _carry(t, TOP, MIDDLE, rho_c * (returned - third), rate)
    _carry(t, MIDDLE, LOW, rho_c * (drawn + third), rate)

    gust = 1.0 + draught
    fan = e.motor_wind * (1.0 + e.thermostat_fan * fan_on) * gust
    lost = _surface(t, FRONT, air, 0.55 * p.motor_housing_area, p.motor_housing_convection, p.motor_housing_emissivity, fan, rate)
    lost += _surface(t, REAR, air, 0.45 * p.motor_housing_area, p.motor_housing_convection, p.motor_housing_emissivity, fan, rate)
    lost += _surface(t, P1_SKIN, air, p.pump_1_case_area, p.pump_1_convection, p.pump_1_emissivity, e.pump_wind * gust, rate)
    lost += _surface(t, P2_SKIN, air, p.pump_2_case_area, p.pump_2_convection, p.pump_2_emissivity, e.pump_wind * gust, rate)
    wind = e.barrel_wind * gust
    for node, part in ((BAR_A, 0.25), (BAR_M, 0.5), (BAR_B, 0.25)):
        lost += _surface(t, node, air, part * p.cylinder_barrel_area, p.cylinder_convection, p.cylinder_emissivity, wind, rate)
    lost += _surface(t, TANK_WALL, air, p.tank_area, p.tank_convection, p.tank_emissivity, e.tank_wind * gust, rate)
    for node, conductance in ((A_WALL, p.line_a_wall_to_ambient), (B_WALL, p.line_b_wall_to_ambient), (FRAME, _FRAME_LOSS)):
        q = conductance * (t[node] - air)
        rate[node] -= q
        lost += q
    cooled = e.cooler * max(0.0, t[LOW] - air - e.cooler_above)
    rate[LOW] -= cooled
    lost += cooled
    for i in range(N):
        t[i] += step * rate[i] / c[i]
    return given * step, lost * step
