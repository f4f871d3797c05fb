"""The asymmetric cylinder: areas, volumes, seal friction, end stops."""

from __future__ import annotations

import math

from ddh_twin_py.physics.compiled import equation

END_STOP_STIFFNESS = 5.0e7
"""N/m of the stops at 0 and at full stroke, or as far past them as a run is let (``cylinder.run_past_*``)."""


@equation
def piston_area(p):
    """A_A = pi bore^2/4, m2."""
    return 0.25 * math.pi * p.cylinder_bore * p.cylinder_bore


@equation
def rod_travel(p):
    """Rod velocity per shaft speed where nothing leaks, D_1/(2 pi)/A_A, m/rad."""
    return p.pump_1_displacement / (2.0 * math.pi) / piston_area(p)


@equation
def rod_side_area(p):
    """A_B = A_A - pi rod^2/4, m2."""
    return 0.25 * math.pi * (p.cylinder_bore * p.cylinder_bore - p.cylinder_rod * p.cylinder_rod)


@equation
def chamber_volume_piston_side(position, p):
    """Oil in the piston-side chamber, m3: V_dead + A_A x; position x in m, within the stroke."""
    return p.cylinder_dead_volume_piston_side + piston_area(p) * position


@equation
def chamber_volume_rod_side(position, p):
    """Oil in the rod-side chamber, m3: V_dead + A_B (stroke - x); position x in m, within the stroke."""
    return p.cylinder_dead_volume_rod_side + rod_side_area(p) * (p.cylinder_stroke - position)


@equation
def lifted_mass(p):
    """What the rod lifts, kg: what is declared, times the ratio to it."""
    return p.load_payload_mass * p.load_payload_ratio


@equation
def load_force(position, p):
    """Force of the load against extension, N: m g + s (x - stroke/2); position x in m."""
    return lifted_mass(p) * p.load_gravity + p.load_force_slope * (position - 0.5 * p.cylinder_stroke)


@equation
def holding_pressure(position, pressure_b, p):
    """Pressure of the piston side, Pa, that holds the load at rest without friction, at position x in m and p_B in Pa."""
    return (load_force(position, p) + pressure_b * rod_side_area(p)) / piston_area(p)


@equation
def coulomb_friction(velocity, pressure_difference, p):
    """Magnitude of dry friction, N: (F_c + k |p_A - p_B|) (1 + (r_s - 1) exp(-(v/v_s)^2)).

    ``velocity`` v in m/s, ``pressure_difference`` p_A - p_B in Pa; Stribeck's rise r_s at rest falls off over v_s.
    """
    ratio = velocity / p.cylinder_stribeck_velocity
    stribeck = 1.0
    square = ratio * ratio
    if square < 1e-16:  # the exponential is 1 to the last bit
        stribeck = p.cylinder_stribeck_ratio
    elif square < 42.25:  # beyond it the exponential is below the last bit
        stribeck += (p.cylinder_stribeck_ratio - 1.0) * math.exp(-square)
    return (p.cylinder_friction_coulomb + p.cylinder_friction_pressure * abs(pressure_difference)) * stribeck
