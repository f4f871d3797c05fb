"""Units that logs come in, and how they become the project's own."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ddh_twin_py.names import no_such

_TURN = 2.0 * math.pi
_UNITS: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "rad/s": {"rad/s": (1.0, 0.0), "rpm": (_TURN / 60.0, 0.0), "1/min": (_TURN / 60.0, 0.0), "1/s": (_TURN, 0.0),
              "deg/s": (_TURN / 360.0, 0.0)},
    "N*m": {"N*m": (1.0, 0.0), "Nm": (1.0, 0.0), "N*cm": (1e-2, 0.0), "N*mm": (1e-3, 0.0), "kN*m": (1e3, 0.0),
            "lbf*ft": (1.3558179483314004, 0.0)},
    "A": {"A": (1.0, 0.0), "mA": (1e-3, 0.0)},
    "V": {"V": (1.0, 0.0), "mV": (1e-3, 0.0), "kV": (1e3, 0.0)},
    "W": {"W": (1.0, 0.0), "kW": (1e3, 0.0), "mW": (1e-3, 0.0), "hp": (745.6998715822702, 0.0)},
    "Pa": {"Pa": (1.0, 0.0), "kPa": (1e3, 0.0), "MPa": (1e6, 0.0), "mbar": (1e2, 0.0), "bar": (1e5, 0.0),
           "bar_absolute": (1e5, -101325.0), "Pa_absolute": (1.0, -101325.0), "psi": (6894.757293168361, 0.0)},
    "m": {"m": (1.0, 0.0), "cm": (1e-2, 0.0), "mm": (1e-3, 0.0), "um": (1e-6, 0.0), "in": (0.0254, 0.0)},
    "m/s": {"m/s": (1.0, 0.0), "cm/s": (1e-2, 0.0), "mm/s": (1e-3, 0.0), "mm/min": (1e-3 / 60.0, 0.0), "m/min": (1.0 / 60.0, 0.0)},
    "K": {"K": (1.0, 0.0), "degC": (1.0, 273.15), "degF": (5.0 / 9.0, 459.67 * 5.0 / 9.0)},
}
"""Unit inside the project to the units that are taken for it: value inside = factor * value + offset. Pressures are gauge."""

TIME_UNITS = {"ns": 1, "us": 10**3, "ms": 10**6, "s": 10**9, "min": 60 * 10**9, "h": 3600 * 10**9}
"""ns of a unit of time."""


def units_for(inside: str) -> tuple[str, ...]:
    """Units that are taken for a quantity whose unit inside the project is that."""
    return tuple(_UNITS[inside])


def to_inside(values: np.ndarray, unit: str, inside: str) -> np.ndarray:
    """Values in `unit` as the project has them.

    Raises KeyError, which names the nearest unit and all that are taken, for one that is none of them.
    """
    taken = _UNITS[inside]
    if unit not in taken:
        raise KeyError(no_such("unit", unit, list(taken)))
    factor, offset = taken[unit]
    return values * factor + offset


