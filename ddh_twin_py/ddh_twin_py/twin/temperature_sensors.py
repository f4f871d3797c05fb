"""What each temperature sensor reads of the thermal network, before its lag and its errors; its numbers are frozen into kernels."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.thermal_network import NODES, TANK, TANK_TOP

NODE_OF_SENSOR = {
    "motor_winding": "end_winding",
    "motor_housing": "housing",
    "pump_1_case": "pump_1_case",
    "pump_2_case": "pump_2_case",
    "tank_oil": "tank_oil",
    "tank_wall": "tank_wall",
    "cylinder_barrel": "cylinder_barrel",
    "line_a": "line_a_wall",
    "line_b": "line_b_wall",
}
"""Sensor (topic temperature/<sensor>) to thermal node; ``ambient`` is an input and no node. ``tank_oil`` reads the mean of both layers."""

SENSORS = tuple(NODE_OF_SENSOR)
INNER_SENSORS = ("motor_winding", "tank_oil")
"""Sensors that do not lie on a surface."""
NODE_INDEX = {sensor: NODES.index(node) for sensor, node in NODE_OF_SENSOR.items()}


def sensed(temperature: np.ndarray, sensor: str, top_share: float) -> np.ndarray:
    """What a sensor meets, K, (...): its node, or the mean of the tank's layers, (1 - s) T_low + s T_top.

    Args:
        temperature: of all nodes, K, (..., N). sensor: of `SENSORS`. top_share: s, ``tank.top_share`` of the rig.

    Raises:
        KeyError: a sensor that the network does not have.
    """
    node = temperature[..., NODE_INDEX[sensor]]
    if NODE_INDEX[sensor] == TANK:
        node = (1.0 - top_share) * node + top_share * temperature[..., TANK_TOP]
    return node


def all_sensed(temperature: np.ndarray, top_share: float) -> np.ndarray:
    """`sensed` of all `SENSORS`, K, (..., m)."""
    return np.stack([sensed(temperature, sensor, top_share) for sensor in SENSORS], axis=-1)
