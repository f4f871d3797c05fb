"""The plant's oil: Vogel viscosity and a bulk modulus that pressure raises, with air that dissolves.

mu = a exp(b/(T - c)) (Vogel 1921), tied to the sheet's Walther oil at three temperatures.
Liquid: K = K_0 + 5 (p - 80 bar) (tangent, mineral oil); air: polytropic with exponent 1.35, of which pressure dissolves a part.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.plant.compiled import kernel

ATMOSPHERE = 101325.0
"""Pa."""
VAPOUR = -0.96e5
"""Pa gauge."""
_TIED = (283.15, 305.15, 333.15)  # K
_EXPONENT = 1.35
_RISE = 5.0
_MIDDLE = 8.0e6  # Pa
_DISSOLVING = 8.0e7  # Pa


def walther(temperature: float, a: float, b: float, density_15: float, expansion: float) -> float:
    """Dynamic viscosity of the sheet's oil, Pa*s, at K (ASTM D341)."""
    kinematic = 10.0 ** 10.0 ** (a - b * math.log10(temperature)) - 0.7
    return kinematic * 1e-6 * density_15 * (1.0 - expansion * (temperature - 288.15))


def vogel(a: float, b: float, density_15: float, expansion: float) -> np.ndarray:
    """Vogel's constants (ln Pa*s, K, K) of an oil that the sheet gives by Walther's, shape (3,)."""
    t = np.array(_TIED)
    y = np.log([walther(x, a, b, density_15, expansion) for x in t])
    # ln mu = A + B/(T - C) through three points
    low, high = 100.0, 250.0

    def gap(c: float) -> float:
        u = 1.0 / (t - c)
        return (y[0] - y[1]) / (y[1] - y[2]) - (u[0] - u[1]) / (u[1] - u[2])

    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gap(low) * gap(middle) > 0.0 else (low, middle)
    c = 0.5 * (low + high)
    slope = (y[0] - y[2]) / (1.0 / (t[0] - c) - 1.0 / (t[2] - c))
    return np.array([y[0] - slope / (t[0] - c), slope, c])


@kernel
def viscosity(temperature, constants):
    """Pa*s at K, by the constants of `vogel`."""
    return math.exp(constants[0] + constants[1] / (temperature - constants[2]))


@kernel
def softness(pressure, bulk_modulus, air_fraction):
    """1/K of liquid and air together, 1/Pa, at Pa gauge."""
    absolute = max(pressure, VAPOUR) + ATMOSPHERE
    free = air_fraction * _DISSOLVING / (_DISSOLVING + absolute)
    air = free / (_EXPONENT * absolute) * math.exp(math.log(ATMOSPHERE / absolute) / _EXPONENT)
    return 1.0 / (bulk_modulus + _RISE * (pressure - _MIDDLE)) + air
