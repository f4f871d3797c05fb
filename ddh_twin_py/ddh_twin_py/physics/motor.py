"""The servo motor: losses, voltage, power (paper, equations 1 to 3)."""

from __future__ import annotations

import math

from ddh_twin_py.physics.compiled import equation
from ddh_twin_py.physics.oil import ZERO_CELSIUS

RAD_PER_S_OF_RPM = math.pi / 30.0
EXCESS_SPEED = 500.0 * RAD_PER_S_OF_RPM
"""rad/s, where the ratio of the excess iron loss is stated."""
LEAST_FLUX = 0.2
"""Share of the magnets' flux at 23 degC that is always left: a slope holds for some ten kelvin, and without flux there is no motor."""
CUT_BACK_FROM, CUT_OFF_AT = ZERO_CELSIUS + 250.0, ZERO_CELSIUS + 300.0
"""K; far above any insulation class: a stalled drive trips at the latest here, and the model stays finite."""


@equation
def resistance_factor(temperature, p):
    """rho(T)/rho(20 degC) of copper (paper, eq. 1); temperature in K."""
    return 1.0 + p.motor_copper_temperature_coefficient * (temperature - ZERO_CELSIUS - 20.0)


@equation
def phase_resistance(slot_temperature, end_temperature, p):
    """Resistance of one phase, ohm, its end-winding share at the end winding's temperature; temperatures in K (paper, eq. 1)."""
    share = p.motor_end_winding_copper_share
    return p.motor_phase_resistance_20C * (
        (1.0 - share) * resistance_factor(slot_temperature, p) + share * resistance_factor(end_temperature, p)
    )


@equation
def available_current(slot_temperature, end_temperature, p):
    """Current that the drive still gives, A rms: all of its limit up to `CUT_BACK_FROM`, none beyond `CUT_OFF_AT`, linear in between.

    Temperatures of slot and end winding in K, the hotter one counts.
    """
    hottest = max(slot_temperature, end_temperature)
    share = (CUT_OFF_AT - hottest) / (CUT_OFF_AT - CUT_BACK_FROM)
    return p.motor_current_limit * min(max(share, 0.0), 1.0)


@equation
def torque_constant(rotor_temperature, p):
    """Torque per current, N*m/A rms, with magnets at ``rotor_temperature`` in K: K_t (1 + s (T - 23 degC))."""
    return p.motor_torque_constant * magnet_factor(rotor_temperature, p)


@equation
def magnet_factor(rotor_temperature, p):
    """Flux of the magnets over that at 23 degC, 1 + s (T - 23 degC), T in K, but `LEAST_FLUX`; torque and voltage constant follow it."""
    return max(LEAST_FLUX, 1.0 + p.motor_torque_constant_slope * (rotor_temperature - ZERO_CELSIUS - 23.0))


@equation
def iron_coefficients(p):
    """What speed does not change of the iron loss (paper, eq. 3): k_h f^alpha B^beta + k_e (f B)^2 per kg.

    Beyond it an excess, (r - 1) P(f_r) (f/f_r)^n at the frequency f_r of 500 rpm, shared out like
    the rest; r is 1 unless a rig file says otherwise.

    Returns (hysteresis of teeth, of yoke, W/Hz^alpha; eddy of teeth, of yoke, W/Hz^2; excess of
    teeth, of yoke, W/Hz^n).
    """
    teeth, yoke = p.motor_iron_tooth_flux_density, p.motor_iron_yoke_flux_density
    hysteresis, eddy = p.motor_iron_hysteresis_coefficient, p.motor_iron_eddy_coefficient
    hysteresis_teeth = p.motor_iron_tooth_mass * hysteresis * teeth**p.motor_iron_beta
    hysteresis_yoke = p.motor_iron_yoke_mass * hysteresis * yoke**p.motor_iron_beta
    eddy_teeth = p.motor_iron_tooth_mass * eddy * teeth * teeth
    eddy_yoke = p.motor_iron_yoke_mass * eddy * yoke * yoke
    rated = p.motor_pole_pairs * EXCESS_SPEED / (2.0 * math.pi)
    more = (p.motor_iron_loss_ratio - 1.0) / rated**p.motor_iron_excess_exponent
    power, square = rated**p.motor_iron_alpha, rated * rated
    return (
        hysteresis_teeth, hysteresis_yoke, eddy_teeth, eddy_yoke,
        more * (hysteresis_teeth * power + eddy_teeth * square), more * (hysteresis_yoke * power + eddy_yoke * square),
    )


@equation
def iron_losses(speed, iron, p):
    """Iron loss of teeth and of yoke, W (paper, eq. 3); ``iron`` from `iron_coefficients`, f = pole pairs w/2pi, ``speed`` w in rad/s."""
    frequency = p.motor_pole_pairs * abs(speed) / (2.0 * math.pi)
    if frequency <= 0.0:
        return 0.0, 0.0
    power = frequency if p.motor_iron_alpha == 1.0 else frequency**p.motor_iron_alpha
    square = frequency * frequency
    teeth, yoke = iron[0] * power + iron[2] * square, iron[1] * power + iron[3] * square
    if iron[4] != 0.0 or iron[5] != 0.0:
        excess = frequency**p.motor_iron_excess_exponent
        teeth += iron[4] * excess
        yoke += iron[5] * excess
    return teeth, yoke


@equation
def friction_loss(speed, p):
    """Loss of bearings and seals of the motor, W: |w| (T_c + b |w|), ``speed`` w in rad/s."""
    return abs(speed) * (p.motor_friction_coulomb + p.motor_friction_viscous * abs(speed))


@equation
def line_voltage(speed, current, resistance, magnets, p):
    """Line-to-line voltage, V rms: sqrt((K_v n + sqrt(3) R i)^2 + (sqrt(3) p w L i)^2), current in phase with the back-EMF.

    ``speed`` w in rad/s, n the same in 1/min, ``current`` i in A rms, ``resistance`` R of a phase in ohm, ``magnets`` from
    `magnet_factor`, which K_v follows; p pole pairs, L inductance of a phase, H.
    """
    active = magnets * p.motor_voltage_constant * speed / RAD_PER_S_OF_RPM + math.sqrt(3.0) * resistance * current
    reactive = math.sqrt(3.0) * p.motor_pole_pairs * speed * p.motor_phase_inductance * current
    return math.sqrt(active * active + reactive * reactive)
