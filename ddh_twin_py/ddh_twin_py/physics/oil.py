"""Oil: viscosity, density and stiffness."""

from __future__ import annotations

import math

from ddh_twin_py.physics.compiled import equation

ATMOSPHERE = 101325.0
"""Pa, absolute."""
VAPOUR_PRESSURE = -0.96e5
"""Pa gauge, below which a void grows instead of the pressure falling."""
POLYTROPIC_EXPONENT = 1.4
"""Entrained air is compressed isentropically."""
ZERO_CELSIUS = 273.15
STATED_FROM, STATED_TO = ZERO_CELSIUS - 20.0, ZERO_CELSIUS + 100.0
"""K, range of the Walther law."""
_LN10 = math.log(10.0)
_NEARBY = 0.01  # of the absolute pressure
_AIR_1 = -1.0 - 1.0 / POLYTROPIC_EXPONENT  # d ln(1/K)/d ln(p) of air, and the further terms of its binomial series
_AIR_2 = _AIR_1 * (_AIR_1 - 1.0) / 2.0
_AIR_3 = _AIR_2 * (_AIR_1 - 2.0) / 3.0
_AIR_4 = _AIR_3 * (_AIR_1 - 3.0) / 4.0


@equation
def density(temperature, p):
    """Density, kg/m3: rho = rho_15 (1 - alpha (T - 15 degC)); temperature in K."""
    return p.oil_density_15C * (1.0 - p.oil_thermal_expansion * (temperature - ZERO_CELSIUS - 15.0))


@equation
def dynamic_viscosity(temperature, p):
    """Dynamic viscosity mu = nu rho, Pa*s, by Walther (ASTM D341): log10 log10(nu/cSt + 0.7) = A - B log10(T/K).

    ``temperature`` in K. Stated for `STATED_FROM` to `STATED_TO`; outside it is extrapolated.
    """
    exponent = p.oil_walther_a - p.oil_walther_b * math.log(temperature) / _LN10
    kinematic = math.exp(_LN10 * math.exp(_LN10 * exponent)) - 0.7
    return kinematic * 1e-6 * density(temperature, p)


@equation
def viscosity_ratio(temperature, p):
    """mu(T)/mu_0, T in K, where mu_0 is the viscosity at which the coefficients are stated, see `rig.own_oil`."""
    return dynamic_viscosity(temperature, p) / p.oil_reference_viscosity


@equation
def pressure_factor(pressure, p):
    """Viscosity under pressure over that at none (Barus), exp(a max(p, 0)); pressure p in Pa gauge."""
    a = p.oil_viscosity_pressure_coefficient
    return 1.0 if a == 0.0 else math.exp(a * max(pressure, 0.0))


@equation
def compressibility(pressure, p):
    """1/bulk modulus, 1/Pa: liquid in series with entrained air, compressed isentropically.

    1/K = 1/K_liquid + (phi/(n p_abs)) (p_0/p_abs)^(1/n), phi the air fraction at p_0. ``pressure``
    in Pa gauge, taken not below the vapour pressure.
    """
    ratio = ATMOSPHERE / (max(pressure, VAPOUR_PRESSURE) + ATMOSPHERE)
    air = p.oil_air_fraction * (ratio * math.exp(math.log(ratio) * (1.0 / POLYTROPIC_EXPONENT)))
    return 1.0 / p.oil_bulk_modulus + air * (1.0 / (POLYTROPIC_EXPONENT * ATMOSPHERE))


@equation
def compressibility_nearby(known, there, pressure, p):
    """`compressibility` at a pressure, 1/Pa, from the one that is ``known`` (1/Pa) at a pressure ``there`` (both Pa gauge).

    The series of its air up to the fourth order where the two are within `_NEARBY` of each other, good to 1e-9 of it.
    """
    step = (max(pressure, VAPOUR_PRESSURE) - max(there, VAPOUR_PRESSURE)) / (max(there, VAPOUR_PRESSURE) + ATMOSPHERE)
    if abs(step) > _NEARBY:
        return compressibility(pressure, p)
    stiff = 1.0 / p.oil_bulk_modulus
    return stiff + (known - stiff) * (1.0 + step * (_AIR_1 + step * (_AIR_2 + step * (_AIR_3 + step * _AIR_4))))


@equation
def volumetric_heat_capacity(p):
    """rho*c_p at 23 degC, J/(m3*K), one number for the whole circuit so that enthalpy is conserved."""
    return density(ZERO_CELSIUS + 23.0, p) * p.oil_specific_heat
