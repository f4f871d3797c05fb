"""The hydraulic state of a rod at rest, where free runs begin."""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.physics.cylinder import holding_pressure
from ddh_twin_py.physics.free_run import settle


def first_finite(values: np.ndarray, default: float) -> float:
    """The first finite one of values (n,), where a run begins, else the default."""
    finite = values[np.isfinite(values)]
    return float(finite[0]) if finite.size else default


def rest_at(parameters: np.ndarray, state: np.ndarray, position: float, piston_side: float = math.nan, rod_side: float = math.nan) -> None:
    """Set the hydraulic state to rest at a position and at pressures.

    What a reading lies beyond a stop is its noise: a run that began there would be pressed with several times its load, and cavitate.

    Args:
        parameters: (1,). state: `HYDRAULIC_STATES`, in place. position: m, taken no further than the stops. piston_side,
            rod_side: Pa gauge; where they are not known (not finite) the one that holds the load, and 0.
    """
    p = parameters[0]
    position = min(max(position, 0.0), float(p["cylinder_stroke"]))
    rod_side = rod_side if math.isfinite(rod_side) else 0.0
    settle(parameters, state, position, piston_side if math.isfinite(piston_side) else holding_pressure(position, rod_side, p), rod_side)
