"""Temperature sensors by name and node; what is frozen into kernels comes from `twin.temperature_sensors`."""

from __future__ import annotations

from ddh_twin_py.twin.temperature_sensors import NODE_INDEX, NODE_OF_SENSOR, SENSORS

__all__ = ["NODE_INDEX", "NODE_OF_SENSOR", "SENSORS", "SENSOR_OF_NODE"]

SENSOR_OF_NODE = {node: sensor for sensor, node in NODE_OF_SENSOR.items()}
