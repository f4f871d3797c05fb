"""Node: publishes the hydraulics' telemetry and the temperatures on the oil side."""

from __future__ import annotations

from ddh_twin_py.nodes import drive_telemetry
from ddh_twin_py.nodes.base.node_base import run
from ddh_twin_py.nodes.telemetry_publisher import TelemetryPublisher
from ddh_twin_py.telemetry.signals import HYDRAULIC_TOPIC, TEMPERATURE_PREFIX, TEMPERATURE_SENSORS

TOPICS = (
    HYDRAULIC_TOPIC,
    *(TEMPERATURE_PREFIX + sensor for sensor in TEMPERATURE_SENSORS if sensor not in drive_telemetry.SENSORS),
)


class PressureTelemetryNode(TelemetryPublisher):
    """Follows the start of the record that drive_telemetry tells."""

    def __init__(self) -> None:
        super().__init__("pressure_telemetry", TOPICS, leads=False)


def main(args: list[str] | None = None) -> int:
    return run(PressureTelemetryNode, args)
