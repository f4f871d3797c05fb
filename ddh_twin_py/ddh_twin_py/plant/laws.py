"""Friction, leakage, valves and losses of the plant, each by another formula than the twin's."""

from __future__ import annotations

import math

from ddh_twin_py.plant.compiled import kernel

BRISTLE_STIFFNESS = 6.0e7
"""N/m of the piston seal before it slides (LuGre, Canudas de Wit et al. 1995)."""
BRISTLE_DAMPING = 3.0e4
"""N*s/m."""
_TURNING = 0.2  # rad/s over which shaft friction turns
_LEAK_BEND = 0.0015  # rise of the leakage coefficient per 80 bar
_EDDY_SHARE = 0.12  # of the iron loss at 500 rpm
F500 = 25.0
"""Hz of the stator at 500 rpm with three pole pairs."""


@kernel
def soft_positive(u, width):
    """max(0, u) with a round corner, in the unit of u."""
    return 0.5 * (u + math.sqrt(u * u + width * width))


@kernel
def sliding(velocity, difference, p, e, position):
    """Steady dry friction of the piston, N: a rational Stribeck curve; what a worn or bent part adds."""
    ratio = velocity / p.cylinder_stribeck_velocity
    hump = 1.0 / (1.0 + ratio * ratio)
    dry = p.cylinder_friction_coulomb + p.cylinder_friction_pressure * math.sqrt(difference * difference + 1e8)
    bent = position / p.cylinder_stroke
    back = 0.5 * (1.0 - velocity / math.sqrt(velocity * velocity + 1e-6))
    added = e.seal_rubbing * (1.0 + 0.25 * hump) + e.bent_rod * bent * bent + e.rubs_back * back
    return dry * (1.0 + (p.cylinder_stribeck_ratio - 1.0) * hump) + added


@kernel
def shaft_sign(speed):
    """Direction of shaft friction and its slope, 1 and s/rad."""
    root = math.sqrt(speed * speed + _TURNING * _TURNING)
    return speed / root, _TURNING * _TURNING / (root * root * root)


@kernel
def leakage(pressure, coefficient):
    """m3/s past a pump's gaps, which open a little under pressure."""
    return coefficient * pressure * (1.0 + _LEAK_BEND * (abs(pressure) / 8.0e6 - 1.0))


@kernel
def pump_drag(pressure, speed, displacement, friction_pressure, friction_constant, rubbing):
    """Dry loss torque of a pump, N*m: with a mixed-friction rise at low speed."""
    mixed = math.exp(-abs(speed) / 20.0)
    return (friction_pressure * displacement * math.sqrt(pressure * pressure + 1e8) * (1.0 + 0.006 * (mixed - 0.1))
            + friction_constant * (1.0 + 0.10 * mixed) + rubbing * (0.98 + 0.08 * mixed))


@kernel
def iron(speed, p, e):
    """Iron loss of teeth and of yoke, W: hysteresis and eddy loss apart, equal to the sheet's at 500 rpm."""
    f = p.motor_pole_pairs * abs(speed) / (2.0 * math.pi)
    base = p.motor_iron_hysteresis_coefficient * f * (1.0 - _EDDY_SHARE + _EDDY_SHARE * f / F500)
    relative = f / F500
    more = (e.iron_ratio - 1.0) * p.motor_iron_hysteresis_coefficient * F500 * (
        0.5 * relative * relative + 0.5 * relative * math.sqrt(relative))
    teeth = p.motor_iron_tooth_mass * p.motor_iron_tooth_flux_density**p.motor_iron_beta
    yoke = p.motor_iron_yoke_mass * p.motor_iron_yoke_flux_density**p.motor_iron_beta
    return teeth * (base + more), yoke * (base + more)
