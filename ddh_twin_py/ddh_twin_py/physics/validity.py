"""Whether temperatures lie where the model's oil laws are stated."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.oil import STATED_FROM, STATED_TO, ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import NODES

OIL_NODES = np.array([i for i, node in enumerate(NODES) if "oil" in node.split("_")])
"""Indices of the oil volumes in `thermal_network.NODES`."""


def outside_stated(temperatures: np.ndarray) -> str:
    """What is extrapolated at these temperatures, '' where nothing is.

    Args:
        temperatures: K, (..., N).

    Returns:
        one sentence with the node and the temperature that is furthest outside the stated range of the viscosity law.
    """
    oil = np.asarray(temperatures).reshape(-1, len(NODES))[:, OIL_NODES]
    if oil.size == 0:
        return ""
    beyond = np.maximum(oil - STATED_TO, STATED_FROM - oil)
    row, column = np.unravel_index(np.argmax(np.where(np.isfinite(beyond), beyond, -np.inf)), beyond.shape)
    if not beyond[row, column] > 0.0:
        return ""
    return (
        f"{NODES[OIL_NODES[column]]} is at {oil[row, column] - ZERO_CELSIUS:.1f} degC; the oil's viscosity is stated for "
        f"{STATED_FROM - ZERO_CELSIUS:g} to {STATED_TO - ZERO_CELSIUS:g} degC and extrapolated there"
    )
