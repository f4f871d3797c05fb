"""Node: the motor's thermal network, driven by current and speed."""

from __future__ import annotations

import numpy as np

from ddh_msgs.msg import MotorThermalState
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.node_base import run
from ddh_twin_py.nodes.feeds.intervals_feed import Batch
from ddh_twin_py.nodes.messages.conversion import motor_layout, motor_values
from ddh_twin_py.nodes.model_node import ModelNode
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC
from ddh_twin_py.twin.machine_thermal import MachineThermal

OUTPUT_TOPIC = "motor/thermal_state"


class MachineThermalNode(ModelNode):
    """`drive/telemetry` and ambient to `motor/thermal_state`.

    Of `hydraulics/telemetry` it takes the stamps alone: where clocks part it believes the one that `hydraulic_model` does.
    """

    def __init__(self) -> None:
        super().__init__("machine_thermal", topics=[DRIVE_TOPIC, HYDRAULIC_TOPIC], awaited=[DRIVE_TOPIC, HYDRAULIC_TOPIC])
        self._layout = motor_layout()
        self._state = self.create_publisher(MotorThermalState, OUTPUT_TOPIC, qos.OUTPUT)
        self.begin(required=[DRIVE_TOPIC])

    def make_model(self, temperature: np.ndarray, payload_mass: float | None) -> MachineThermal:
        return MachineThermal(self.rig, temperature, self.interval)

    def model_inputs(self, batch: Batch, air: np.ndarray) -> tuple:
        return batch.measured, air

    def driven(self, batch: Batch) -> np.ndarray:
        return MachineThermal.driven(batch.measured)

    def run_model(self, model: MachineThermal, batch: Batch, air: np.ndarray) -> np.ndarray:
        result = model.advance(*self.model_inputs(batch, air))
        for message in self._layout.compose(batch.end_ns, motor_values(result, self.interval)):
            self._state.publish(message)
        return result.known


def main(args: list[str] | None = None) -> int:
    return run(MachineThermalNode, args)
