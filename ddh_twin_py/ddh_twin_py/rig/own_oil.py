"""The viscosity at which a rig's leakage, friction and line drop are stated: that of its own oil at 23 degC.

A rig's oil deviates from the sheet's within its tolerance, and the coefficients of that rig were found with that oil. So
where a rig is drawn or fitted, `oil.reference_viscosity` follows its oil; where another oil is filled in later it stays.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

AT = 296.15
"""K, at which the sheet states its coefficients."""
REFERENCE = "oil.reference_viscosity"
_OIL = ("walther_a", "walther_b", "density_15C", "thermal_expansion")


def viscosity_at_reference(walther_a: float, walther_b: float, density_15C: float, thermal_expansion: float) -> float:
    """Dynamic viscosity at 23 degC, Pa*s: Walther (ASTM D341) and density, kg/m3 and 1/K."""
    exponent = walther_a - walther_b * math.log10(AT)
    kinematic = (10.0 ** min(10.0 ** min(exponent, 3.0), 300.0) - 0.7) * 1e-6  # an oil that no rig file may have is no overflow
    return kinematic * density_15C * (1.0 - thermal_expansion * 8.0)


def of_own_oil(quantities: Mapping, before: Mapping) -> dict:
    """Quantities (`sheet.Quantity` by path) whose reference viscosity moved as their oil moved from that of ``before``."""
    oils = [tuple(q[f"oil.{name}"].value for name in _OIL) for q in (quantities, before)]
    ratio = 1.0 if oils[0] == oils[1] else viscosity_at_reference(*oils[0]) / viscosity_at_reference(*oils[1])
    own = before[REFERENCE]
    return {**quantities, REFERENCE: replace(own, value=own.value * ratio, source="of this rig's oil") if ratio != 1.0 else own}


def refer_to_own_oil(record: np.ndarray, before: np.ndarray) -> None:
    """The same for records of parameters (1,), in place."""
    oils = [tuple(float(r[f"oil_{name}"][0]) for name in _OIL) for r in (record, before)]
    if oils[0] != oils[1]:
        ratio = viscosity_at_reference(*oils[0]) / viscosity_at_reference(*oils[1])
        record["oil_reference_viscosity"] = before["oil_reference_viscosity"] * ratio
