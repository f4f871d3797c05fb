"""Heat from surfaces to air: natural convection, radiation, air gap, end space; and the air itself.

Published correlations with the range in which they were measured; temperatures in K, heights and
gaps in m, coefficients in W/(m2*K). `in_range` says of a set of numbers whether they were inside.
"""

from __future__ import annotations

from dataclasses import dataclass

from ddh_twin_py.physics.thermal_network import STEFAN_BOLTZMANN

GRAVITY = 9.81
"""m/s2"""
PRESSURE, GAS_CONSTANT, AIR_HEAT = 101325.0, 287.05, 1006.0
"""Pa, J/(kg*K), J/(kg*K) of dry air."""
RAYLEIGH_LIMIT = 1e12
"""Churchill and Chu for the horizontal cylinder: 1e-5 < Ra < 1e12."""
TAYLOR_LIMIT = 1e7
"""Becker and Kaye: Ta up to 1e7."""


@dataclass(frozen=True)
class Air:
    """Dry air at 1 atm: conductivity W/(m*K), kinematic viscosity m2/s, density kg/m3, Prandtl number."""

    conductivity: float
    kinematic_viscosity: float
    density: float
    prandtl: float


def air(temperature: float) -> Air:
    """Air at a temperature, K.

    mu = 1.458e-6 T^1.5/(T + 110.4) (Sutherland), k = 2.64638e-3 T^1.5/(T + 245.4 10^(-12/T)), rho = p/(R T);
    U.S. Standard Atmosphere 1976. 170 to 600 K.
    """
    viscosity = 1.458e-6 * temperature**1.5 / (temperature + 110.4)
    conductivity = 2.64638e-3 * temperature**1.5 / (temperature + 245.4 * 10.0 ** (-12.0 / temperature))
    density = PRESSURE / (GAS_CONSTANT * temperature)
    return Air(conductivity, viscosity / density, density, viscosity * AIR_HEAT / conductivity)


def rayleigh(surface: float, ambient: float, diameter: float) -> float:
    """Ra = g beta |dT| D^3 Pr / nu^2, air at the film temperature, beta = 1/T_film; ``surface``, ``ambient`` in K, ``diameter`` D in m."""
    film = 0.5 * (surface + ambient)
    gas = air(film)
    return GRAVITY / film * abs(surface - ambient) * diameter**3 * gas.prandtl / gas.kinematic_viscosity**2


def natural_convection(surface: float, ambient: float, diameter: float) -> float:
    """Mean coefficient of a horizontal cylinder in still air, W/(m2*K).

    Nu = (0.60 + 0.387 Ra^(1/6) / (1 + (0.559/Pr)^(9/16))^(8/27))^2, 1e-5 < Ra < 1e12;
    Churchill and Chu, Int. J. Heat Mass Transfer 18 (1975) 1049. ``surface`` and ``ambient`` in K, ``diameter`` in m.
    """
    gas = air(0.5 * (surface + ambient))
    number = max(rayleigh(surface, ambient, diameter), 1e-5)
    slope = 0.387 * number ** (1.0 / 6.0) / (1.0 + (0.559 / gas.prandtl) ** (9.0 / 16.0)) ** (8.0 / 27.0)
    return (0.60 + slope) ** 2 * gas.conductivity / diameter


def radiation(surface: float, ambient: float, emissivity: float) -> float:
    """Coefficient of radiation to large surroundings: eps sigma (T^2 + T_a^2)(T + T_a), W/(m2*K); T in K, emissivity 1."""
    return emissivity * STEFAN_BOLTZMANN * (surface**2 + ambient**2) * (surface + ambient)


def taylor_number(speed: float, radius: float, gap: float, temperature: float) -> float:
    """Ta = w^2 r g^3 / nu^2, r mean radius of the gap, m, g gap, m, w speed, rad/s, nu at K (Howey, Childs, Holmes 2012, paper's /31/)."""
    return speed**2 * radius * gap**3 / air(temperature).kinematic_viscosity ** 2


def air_gap_nusselt(taylor: float) -> float:
    """Nusselt number of an air gap between smooth cylinders, from surface to surface, on twice the gap.

    2 (conduction) where the flow is laminar; 0.128 Ta^0.367 from 1700; 0.409 Ta^0.241 from 1e4 to 1e7.
    Becker and Kaye, J. Heat Transfer 84 (1962) 97, as reviewed by Howey et al., IEEE Trans. Ind. Electron. 59 (2012)
    1367. The larger of neighbouring laws counts, so that the value has no step down.
    """
    if taylor < 1700.0:
        return 2.0
    return max(2.0, 0.128 * taylor**0.367) if taylor < 1e4 else 0.409 * taylor**0.241


def air_gap(speed: float, radius: float, gap: float, temperature: float, emissivity: float) -> float:
    """Coefficient of an air gap from rotor to stator, W/(m2*K): Nu k/(2 g), and radiation between grey walls, 4 sigma T^3/(2/eps - 1).

    ``speed`` in rad/s, mean ``radius`` and ``gap`` g in m, ``temperature`` of the air in K, ``emissivity`` eps of both walls.
    """
    flow = air_gap_nusselt(taylor_number(speed, radius, gap, temperature)) * air(temperature).conductivity / (2.0 * gap)
    if emissivity <= 0.0:
        return flow
    return flow + 4.0 * STEFAN_BOLTZMANN * temperature**3 / (2.0 / emissivity - 1.0)


def end_space(rim_speed: float, still: float, factor: float, exponent: float) -> float:
    """Coefficient of surfaces in the end space, W/(m2*K): still + factor v^exponent, v the rotor's rim speed, m/s.

    Form of the published end-space correlations (compared in Boglietti and Cavagnino, IEEE Trans. Ind. Appl. 43
    (2007) 1214), measured up to about 15 m/s; radiation is in them.
    """
    return still + factor * abs(rim_speed) ** exponent


def in_range(rayleigh_number: float, taylor: float, rim_speed: float) -> list[str]:
    """What lies outside of where the correlations were measured; empty where all lies inside. Numbers, and rim_speed in m/s."""
    said = []
    if not 1e-5 < rayleigh_number < RAYLEIGH_LIMIT:
        said.append(f"Rayleigh number {rayleigh_number:.2g}, Churchill and Chu hold from 1e-5 to 1e12")
    if taylor > TAYLOR_LIMIT:
        said.append(f"Taylor number {taylor:.2g}, Becker and Kaye measured up to 1e7")
    if abs(rim_speed) > 15.0:
        said.append(f"rim speed {rim_speed:.3g} m/s, end-space correlations were measured up to 15 m/s")
    return said
