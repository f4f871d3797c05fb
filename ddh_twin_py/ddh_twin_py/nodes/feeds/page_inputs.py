"""What the graph publishes, from its messages to the streams of the live page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ddh_msgs.msg import HydraulicState, MotorThermalState, ResidualArray, TemperatureEstimateArray
from ddh_twin_py.bags.cdr import floats_of_messages
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.nodes.feeds.telemetry_feed import field_count
from ddh_twin_py.nodes.messages.conversion import FREE_RUN
from ddh_twin_py.nodes.messages.named import of_source, ordered
from ddh_twin_py.nodes.messages.wire import BulkParser
from ddh_twin_py.physics.thermal_network import FLOW_PATHS, MOTOR_NODES, NODES
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX
from ddh_twin_py.twin.losses import LOSSES
from ddh_twin_py.web.streams import BY_NAME, ESTIMATE_PARTS, MOTOR_FIELDS, STATE_FIELDS

Rows = Iterator[tuple[str, np.ndarray, np.ndarray]]
"""Stream, stamps int64 (n,) in ns, values (n, fields)."""


def telemetry_rows(topic: str, messages: Sequence[bytes]) -> tuple[np.ndarray, np.ndarray]:
    """Stamps in ns and fields of telemetry messages, sound ones alone; a temperature without its variance."""
    stamps, values, sound = floats_of_messages(messages, field_count(topic))
    if topic.startswith(TEMPERATURE_PREFIX):
        values = values[:, :1]
    return stamps[sound], values[sound]


class PageRows:
    """Rows of the streams that one of the twin's outputs gives; ``rows`` puts what is parsed of it into one stream."""

    def __init__(self, message_type: type, rows: Callable[[object, dict], tuple[str, np.ndarray]], source: str = "") -> None:
        self.message_type, self._rows, self._source = message_type, rows, source
        self._parser = BulkParser(message_type)

    @property
    def unreadable(self) -> int:
        """How many messages were left out, see `BulkParser`."""
        return self._parser.unreadable

    @property
    def why(self) -> str:
        """Of the first of them, see `BulkParser`."""
        return self._parser.why

    def parse(self, messages: Sequence[bytes]) -> Rows:
        """Rows of these messages, of those of one source where there is one to look for."""
        for example, stamps, values in self._parser.parse(of_source(messages, self._source) if self._source else messages):
            stream, block = self._rows(example, values)
            yield stream, stamps, block


def page_rows() -> dict[str, PageRows]:
    """Of each of the twin's outputs that the page shows, by topic."""
    return {
        "hydraulics/state": PageRows(HydraulicState, _state),
        "hydraulics/prediction": PageRows(HydraulicState, _prediction),
        "hydraulics/residuals": PageRows(ResidualArray, _noise, FREE_RUN),
        "motor/thermal_state": PageRows(MotorThermalState, _motor),
        "temperature/estimates": PageRows(TemperatureEstimateArray, _estimates),
        "temperature/residuals": PageRows(ResidualArray, _innovations),
        "gap/residuals": PageRows(ResidualArray, _gap),
    }


def _state(example: HydraulicState, values: dict) -> tuple[str, np.ndarray]:
    return "state", np.column_stack([
        values["telemetry_known"], _point(example, values),
        ordered(example.heat_nodes, NODES, values["heat"]), ordered(example.flow_paths, FLOW_PATHS, values["flow"]),
    ])  # fmt: skip


def _prediction(example: HydraulicState, values: dict) -> tuple[str, np.ndarray]:
    return "prediction", np.column_stack([_point(example, values), ordered(example.temperature_nodes, NODES, values["temperature"])])


def _point(example: HydraulicState, values: dict) -> np.ndarray:
    names = [loss.component for loss in example.losses]
    return np.column_stack([*(values[name] for name in STATE_FIELDS), ordered(names, LOSSES, values["losses.power"])])


def _noise(example: ResidualArray, values: dict) -> tuple[str, np.ndarray]:
    return "noise", ordered(_signals(example), BY_NAME["noise"].fields, values["residuals.standard_deviation"])


def _motor(example: MotorThermalState, values: dict) -> tuple[str, np.ndarray]:
    return "motor", np.column_stack([*(values[name] for name in MOTOR_FIELDS), ordered(example.nodes, MOTOR_NODES, values["temperature"])])


def _estimates(example: TemperatureEstimateArray, values: dict) -> tuple[str, np.ndarray]:
    names = [estimate.location for estimate in example.estimates]
    parts = [ordered(names, NODES, values[f"estimates.{part}"]) for part in ESTIMATE_PARTS]
    by_node = np.stack(parts, axis=2).reshape(len(parts[0]), -1)
    return "estimate", np.column_stack([values["ambient"], by_node])


def _innovations(example: ResidualArray, values: dict) -> tuple[str, np.ndarray]:
    names, wanted = _signals(example), [TEMPERATURE_PREFIX + sensor for sensor in SENSORS]
    parts = [ordered(names, wanted, values[f"residuals.{part}"]) for part in ("residual", "standard_deviation")]
    return "innovation", np.stack(parts, axis=2).reshape(len(parts[0]), -1)


def _gap(example: ResidualArray, values: dict) -> tuple[str, np.ndarray]:
    names = _signals(example)
    stream = "temperature_gap" if any(name.startswith(TEMPERATURE_PREFIX) for name in names) else "gap"
    return stream, ordered(names, BY_NAME[stream].fields, values["residuals.residual"])


def _signals(example: ResidualArray) -> list[str]:
    return [residual.signal for residual in example.residuals]
