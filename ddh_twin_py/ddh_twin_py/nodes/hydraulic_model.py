"""Node: pressures, flows, torque and losses from telemetry, and the free run from the command alone."""

from __future__ import annotations

import numpy as np

from ddh_msgs.msg import HydraulicState, ResidualArray
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.node_base import run
from ddh_twin_py.nodes.base.parameters import Parameter
from ddh_twin_py.nodes.feeds.intervals_feed import Batch
from ddh_twin_py.nodes.messages.conversion import (
    FREE_RUN,
    SOFT_SENSOR,
    hydraulic_layout,
    hydraulic_residual_layout,
    hydraulic_residuals,
    hydraulic_values,
)
from ddh_twin_py.nodes.messages.standard_messages import StandardMessages
from ddh_twin_py.nodes.model_node import FUSED_TOPIC, ModelNode
from ddh_twin_py.nodes.tasks.contradiction_watch import ContradictionWatch
from ddh_twin_py.nodes.tasks.health import Report
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC
from ddh_twin_py.telemetry.ticks import Tick
from ddh_twin_py.twin.hydraulic_model import HydraulicModel

FRESH = 5_000_000_000  # ns of data for which a fused temperature is used


class HydraulicModelNode(ModelNode):
    """Telemetry to `hydraulics/state`, `hydraulics/prediction` and `hydraulics/residuals`, and to standard messages of the same."""

    payload_matters = True
    PARAMETERS = (
        Parameter(
            "use_fused_temperatures", True,
            "Take the oil temperatures of temperature_fusion for viscosity where they are fresh; else the model's own.",
            read_only=False,
        ),
    )  # fmt: skip

    def __init__(self) -> None:
        super().__init__("hydraulic_model", topics=[DRIVE_TOPIC, HYDRAULIC_TOPIC], awaited=[DRIVE_TOPIC, HYDRAULIC_TOPIC])
        self._soft_layout, self._free_layout = hydraulic_layout(SOFT_SENSOR), hydraulic_layout(FREE_RUN)
        self._residual_layouts = [hydraulic_residual_layout(source) for source in (SOFT_SENSOR, FREE_RUN)]
        self._soft = self.create_publisher(HydraulicState, "hydraulics/state", qos.OUTPUT)
        self._free = self.create_publisher(HydraulicState, "hydraulics/prediction", qos.OUTPUT)
        self._residuals = self.create_publisher(ResidualArray, "hydraulics/residuals", qos.OUTPUT)
        self._soft_standard, self._free_standard = (StandardMessages(self, mode, mode == FREE_RUN) for mode in (SOFT_SENSOR, FREE_RUN))
        self._fused_used = False
        self._off, self._times_off = False, 0
        self._contradictions = ContradictionWatch(self, self.rig)
        self.begin(required=[DRIVE_TOPIC])
        self.health.add(FUSED_TOPIC, self._judge_fused)
        self.health.add("free run", self._judge_free)
        self.health.add("channels", self._contradictions.judge)

    def work(self, ticks: list[Tick], flush: bool) -> None:
        self._contradictions.add(ticks)
        super().work(ticks, flush)

    def make_model(self, temperature: np.ndarray, payload_mass: float | None) -> HydraulicModel:
        return HydraulicModel(self.rig, temperature, payload_mass, self.interval)

    def model_inputs(self, batch: Batch, air: np.ndarray) -> tuple:
        return batch.measured, batch.command, air

    def driven(self, batch: Batch) -> np.ndarray:
        return HydraulicModel.driven(batch.measured, batch.command)

    def run_model(self, model: HydraulicModel, batch: Batch, air: np.ndarray) -> np.ndarray:
        model.use_temperatures(self._fresh_temperatures(int(batch.end_ns[0])))
        result = model.advance(*self.model_inputs(batch, air))
        self._follow_course(batch, result.off)
        points = (result.soft, result.free)
        free = hydraulic_values(result.free, result.free_temperature, result.known, self.interval)
        soft = hydraulic_values(result.soft, result.soft_temperature, result.known, self.interval)
        self._send(self._free, self._free_layout, batch, free)  # first: the fusion looks for it when the state comes
        self._send(self._soft, self._soft_layout, batch, soft)
        self._free_standard.send(batch.end_ns, result.free, result.free_temperature)
        self._soft_standard.send(batch.end_ns, result.soft, result.soft_temperature)
        for layout, point, settled in zip(self._residual_layouts, points, (None, result.settled), strict=True):
            self._send(self._residuals, layout, batch, hydraulic_residuals(self.rig, batch.measured, point, settled))
        return result.known

    def _follow_course(self, batch: Batch, off: np.ndarray) -> None:
        """Count how often the free run lost its command, (n,); say so the first time."""
        begins = np.flatnonzero(off & ~np.concatenate([[self._off and not batch.first], off[:-1]]))
        self._off = bool(off[-1])
        self._times_off += begins.size
        if begins.size:
            self.warn_once("off", f"{DRIVE_TOPIC}: no speed_command is known at {batch.end_ns[begins[0]] * 1e-9:.3f} s; the free run is "
                           "off until it is taken up from what is measured; its temperatures lack the heat of that time")

    def _send(self, publisher, layout, batch: Batch, values: dict) -> None:
        for message in layout.compose(batch.end_ns, values):
            publisher.publish(message)

    def _fresh_temperatures(self, now_ns: int) -> np.ndarray | None:
        wanted = self.get_parameter("use_fused_temperatures").value
        fresh = wanted and self._fused is not None and abs(now_ns - self._fused[0]) < FRESH
        self._fused_used = bool(fresh)
        return self._fused[1] if fresh else None

    def _judge_free(self, report: Report) -> str:
        report.add("times without a speed command", self._times_off, "1")
        report.add("off", self._off)
        if self._off:
            report.warn("no speed command is known, the free run is off until it is taken up from what is measured")
        return "follows the speed command"

    def _judge_fused(self, report: Report) -> str:
        age = (self.newest_ns - self._fused[0]) * 1e-9 if self._fused is not None else float("nan")
        report.add("messages", self._fused_input.received, "1")
        report.add("age in data", age, "s")
        report.add("age limit", FRESH * 1e-9, "s")
        report.add("used", self._fused_used)
        return "used" if self._fused_used else "not used, the model takes its own temperatures"


def main(args: list[str] | None = None) -> int:
    return run(HydraulicModelNode, args)
