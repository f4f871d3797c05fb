"""Pump/motors: flow at the port and torque at the shaft."""

from __future__ import annotations

import math

from ddh_twin_py.physics.compiled import equation

SIGN_WIDTH = 0.2
"""rad/s over which a friction torque changes its sign; the drive holds the shaft at rest."""
FILLS_AT = 1.0
"""rad/s below which a slow pump fills whatever the oil's viscosity is."""


@equation
def port_flow(displacement_per_rad, leakage, line_resistance, line_quadratic, speed, chamber_pressure):
    """Flow from the pump's port to the line, m3/s, with leakage at the port's own pressure.

    Q = d w - L p_port and p_port = p + R Q + S Q|Q|, solved for Q. ``displacement_per_rad`` is signed, m3/rad;
    ``leakage`` (m3/(s*Pa)), ``line_resistance`` (Pa*s/m3) at the oil's temperature,
    ``line_quadratic`` in Pa*s2/m6, ``speed`` in rad/s, ``chamber_pressure`` in Pa gauge.
    """
    share = 1.0 / (1.0 + leakage * line_resistance)
    flow = (displacement_per_rad * speed - leakage * chamber_pressure) * share
    rough = leakage * line_quadratic * share
    return 2.0 * flow / (1.0 + math.sqrt(1.0 + 4.0 * rough * abs(flow))) if rough > 0.0 else flow


@equation
def filled_share(turning, by_speed, by_viscosity, viscosity):
    """Share of the swept volume that a pump draws from the tank: 1 - s w - v mu/mu_0, not below 0; 1 where it does not draw.

    ``turning`` w in rad/s, positive where the pump draws; ``by_speed`` s, share lost per rad/s; ``by_viscosity`` v, share lost at the
    reference viscosity; ``viscosity`` mu/mu_0. A suction that cannot follow loses oil with speed, a cold one with viscosity
    (Ivantysyn & Ivantysynova, Hydrostatic Pumps and Motors, 2001, on filling losses).
    """
    if turning <= 0.0:
        return 1.0
    return max(0.0, 1.0 - by_speed * turning - by_viscosity * viscosity * turning / (turning + FILLS_AT))


@equation
def port_flow_slope(leakage, line_resistance):
    """dQ/dp of `port_flow` without the quadratic drop, m3/(s*Pa): -L/(1 + L R), L in m3/(s*Pa), R in Pa*s/m3."""
    return -leakage / (1.0 + leakage * line_resistance)


@equation
def smooth_sign(speed):
    """sign(w), continuous through zero: tanh(w/`SIGN_WIDTH`), ``speed`` w in rad/s."""
    ratio = speed / SIGN_WIDTH
    if abs(ratio) > 20.0:  # tanh is 1 to the last bit
        return math.copysign(1.0, ratio)
    if abs(ratio) < 1e-4:  # its series to the last bit
        return ratio * (1.0 - ratio * ratio * (1.0 / 3.0))
    return math.tanh(ratio)


@equation
def friction_magnitude(friction_pressure, friction_constant, displacement_per_rad, port_pressure):
    """Coulomb part of the loss torque, N*m: c |d p| + T_0.

    ``friction_pressure`` c, 1; ``friction_constant`` T_0, N*m; ``displacement_per_rad`` d, m3/rad; ``port_pressure`` p, Pa gauge.
    """
    return friction_pressure * abs(displacement_per_rad * port_pressure) + friction_constant
