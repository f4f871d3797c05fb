"""Which thermal node each temperature sensor reads; its numbers are frozen into kernels."""

from __future__ import annotations

from ddh_twin_py.physics.thermal_network import NODES

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
"""Sensor (topic temperature/<sensor>) to thermal node; ``ambient`` is an input and no node."""

SENSORS = tuple(NODE_OF_SENSOR)
NODE_INDEX = {sensor: NODES.index(node) for sensor, node in NODE_OF_SENSOR.items()}
SENSOR_OF_NODE = {node: sensor for sensor, node in NODE_OF_SENSOR.items()}
