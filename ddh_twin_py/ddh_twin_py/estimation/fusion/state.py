"""What the temperature filter knows, and what it knows before anything was read."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.estimation.fusion.temperature_filter import NEVER_READ
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.physics.thermal_network import HYDRAULIC_NODES, MOTOR_NODES, N, NODES

# K, what may be unknown of the temperatures before any reading: each row is one common cause
# (a warm unit, a warm motor, a hot winding, warm oil, warm pumps) and how far it takes each node
_CAUSES = (
    dict.fromkeys(NODES, 8.0),
    dict.fromkeys(MOTOR_NODES, 6.0),
    {"slot_winding": 25.0, "end_winding": 25.0, "teeth": 10.0, "yoke": 6.0, "rotor": 6.0, "housing": 3.0},
    dict.fromkeys(HYDRAULIC_NODES, 6.0),
    {"pump_1_case": 5.0, "pump_2_case": 5.0, "pump_1_oil": 5.0, "pump_2_oil": 5.0},
)
_OWN = 2.0  # K, what is each node's own


@dataclass
class FusionState:
    """All that the filter knows, as arrays; what a state file holds."""

    dynamic: np.ndarray
    offset: np.ndarray
    deviation: np.ndarray
    covariance: np.ndarray
    ambient: float
    usual_heat: np.ndarray
    ambient_known: bool = False
    refused: np.ndarray = field(default_factory=lambda: np.full(len(SENSORS), NEVER_READ, dtype=np.int64))


def start_covariance() -> np.ndarray:
    """Covariance of the node temperatures before anything is known, K^2, (N, N)."""
    covariance = np.diag(np.full(N, _OWN**2))
    for cause in _CAUSES:
        reach = np.array([cause.get(node, 0.0) for node in NODES])
        covariance += np.outer(reach, reach)
    return covariance
