"""Node: publishes the drive's telemetry, the motor's and ambient temperatures, and which rig it is."""

from __future__ import annotations

from ddh_twin_py.nodes.base.node_base import run
from ddh_twin_py.nodes.telemetry_publisher import TelemetryPublisher
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, TEMPERATURE_PREFIX

SENSORS = ("ambient", "motor_winding", "motor_housing")
TOPICS = (DRIVE_TOPIC, *(TEMPERATURE_PREFIX + sensor for sensor in SENSORS))


class DriveTelemetryNode(TelemetryPublisher):
    """Leads: chooses the start of the record."""

    def __init__(self) -> None:
        super().__init__("drive_telemetry", TOPICS, leads=True)


def main(args: list[str] | None = None) -> int:
    return run(DriveTelemetryNode, args)
