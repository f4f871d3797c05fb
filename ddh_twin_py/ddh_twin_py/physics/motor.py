"""The servo motor: losses, voltage, power (paper, equations 1 to 3)."""

from __future__ import annotations

import math

from ddh_twin_py.physics.compiled import inlined
from ddh_twin_py.physics.oil import ZERO_CELSIUS

RAD_PER_S_OF_RPM = math.pi / 30.0
CUT_BACK_FROM, CUT_OFF_AT = ZERO_CELSIUS + 250.0, ZERO_CELSIUS + 300.0
"""K; far above any insulation class: a stalled drive trips at the latest here, and the model stays finite."""


@inlined
def resistance_factor(temperature, p):
    """rho(T)/rho(20 degC) of copper (paper, eq. 1); temperature in K."""
    return 1.0 + p.motor_copper_temperature_coefficient * (temperature - ZERO_CELSIUS - 20.0)


@inlined
def phase_resistance(slot_temperature, end_temperature, p):
    """Resistance of one phase, ohm, its end-winding share at the end winding's temperature."""
    share = p.motor_end_winding_copper_share
    return p.motor_phase_resistance_20C * (
        (1.0 - share) * resistance_factor(slot_temperature, p) + share * resistance_factor(end_temperature, p)
    )


@inlined
def available_current(slot_temperature, end_temperature, p):
    """Current that the drive still gives, A: all of its limit up to `CUT_BACK_FROM`, none beyond `CUT_OFF_AT`."""
    hottest = max(slot_temperature, end_temperature)
    share = (CUT_OFF_AT - hottest) / (CUT_OFF_AT - CUT_BACK_FROM)
    return p.motor_current_limit * min(max(share, 0.0), 1.0)


@inlined
def iron_coefficients(p):
    """What speed does not change of the iron loss (paper, eq. 3): k_h f^alpha B^beta + k_e (f B)^2 per kg.

    Returns (hysteresis of teeth, of yoke, W/Hz^alpha; eddy of teeth, of yoke, W/Hz^2).
    """
    teeth, yoke = p.motor_iron_tooth_flux_density, p.motor_iron_yoke_flux_density
    hysteresis, eddy = p.motor_iron_hysteresis_coefficient, p.motor_iron_eddy_coefficient
    return (
        p.motor_iron_tooth_mass * hysteresis * teeth**p.motor_iron_beta,
        p.motor_iron_yoke_mass * hysteresis * yoke**p.motor_iron_beta,
        p.motor_iron_tooth_mass * eddy * teeth * teeth,
        p.motor_iron_yoke_mass * eddy * yoke * yoke,
    )


@inlined
def iron_losses(speed, iron, p):
    """Iron loss of teeth and of yoke, W (paper, eq. 3); ``iron`` from `iron_coefficients`, f = pole pairs w/2pi."""
    frequency = p.motor_pole_pairs * abs(speed) / (2.0 * math.pi)
    if frequency <= 0.0:
        return 0.0, 0.0
    power = frequency if p.motor_iron_alpha == 1.0 else frequency**p.motor_iron_alpha
    square = frequency * frequency
    return iron[0] * power + iron[2] * square, iron[1] * power + iron[3] * square


@inlined
def friction_loss(speed, p):
    """Loss of bearings and seals of the motor, W: |w| (c + b |w|)."""
    return abs(speed) * (p.motor_friction_coulomb + p.motor_friction_viscous * abs(speed))


@inlined
def line_voltage(speed, current, resistance, p):
    """Line-to-line voltage, V rms: |K_v n + sqrt(3) R i|; the inductive part is not in the sheet."""
    return abs(p.motor_voltage_constant * speed / RAD_PER_S_OF_RPM + math.sqrt(3.0) * resistance * current)
