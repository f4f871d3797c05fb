"""What the model says as messages that every tool of ROS 2 knows: motion, pressures, temperatures."""

from __future__ import annotations

import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState, Temperature
from std_msgs.msg import Header

from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.messages.conversion import to_celsius
from ddh_twin_py.nodes.messages.wire import Layout
from ddh_twin_py.physics.thermal_network import NODES

ATMOSPHERE = 101325.0
"""Pa; `sensor_msgs/FluidPressure` is absolute, all other pressures of the twin are gauge."""
JOINTS = ("motor", "rod")
SIDES = ("piston_side", "rod_side")


class StandardMessages:
    """Publishers of one mode of the model: `<mode>/joint_states`, `<mode>/pressure_<side>`, `<mode>/temperature/<location>`.

    Args:
        mode: `soft_sensor` or `free_run`. temperatures: whether they are published; one message each for every batch of intervals.
    """

    def __init__(self, node: Node, mode: str, temperatures: bool) -> None:
        nothing = [0.0] * len(JOINTS)
        motion = JointState(name=list(JOINTS), position=list(nothing), velocity=list(nothing), effort=list(nothing))
        self._motion = node.create_publisher(JointState, f"{mode}/joint_states", qos.OUTPUT), Layout(motion)
        self._pressures = [
            (node.create_publisher(FluidPressure, f"{mode}/pressure_{side}", qos.OUTPUT), _framed(FluidPressure, side), f"pressure_{side}")
            for side in SIDES
        ]
        self._temperatures = [
            (node.create_publisher(Temperature, f"{mode}/temperature/{location}", qos.OUTPUT), _framed(Temperature, location))
            for location in (NODES if temperatures else ())
        ]

    def send(self, stamps_ns: np.ndarray, points: np.ndarray, temperature: np.ndarray) -> None:
        """Publish n intervals.

        The motor's angle is known to nobody: NaN. Effort is air-gap torque, N*m, and the force of the oil on the piston, N.

        Args:
            stamps_ns: int64, (n,). points: operating points, (n,). temperature: K, (n, N).
        """
        if not len(stamps_ns):
            return
        publisher, layout = self._motion
        unknown = np.full(len(points), np.nan)
        for message in layout.compose(stamps_ns, {
            "position": np.column_stack([unknown, points["rod_position"]]),
            "velocity": np.column_stack([points["speed"], points["rod_velocity"]]),
            "effort": np.column_stack([points["torque"], points["cylinder_force"]]),
        }):  # fmt: skip
            publisher.publish(message)
        for publisher, layout, field in self._pressures:
            for message in layout.compose(stamps_ns, {"fluid_pressure": points[field] + ATMOSPHERE}):
                publisher.publish(message)
        for (publisher, layout), kelvin in zip(self._temperatures, temperature[-1], strict=False):
            for message in layout.compose(stamps_ns[-1:], {"temperature": to_celsius(kelvin)}):
                publisher.publish(message)


def _framed(message_type: type, frame: str) -> Layout:
    return Layout(message_type(header=Header(frame_id=frame)))
