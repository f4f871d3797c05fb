"""The table of everything that the page shows live: streams of numbers, each with its columns.

A column is named ``stream.field``. Numbers are those of the topics: SI, temperatures in degC.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.gap.watch.watch import HYDRAULIC, TEMPERATURES
from ddh_twin_py.physics.thermal_network import FLOW_PATHS, MOTOR_NODES, NODES
from ddh_twin_py.telemetry.signals import (
    DRIVE_FIELDS,
    DRIVE_TOPIC,
    HYDRAULIC_FIELDS,
    HYDRAULIC_TOPIC,
    TEMPERATURE_PREFIX,
    TEMPERATURE_SENSORS,
)
from ddh_twin_py.twin.hydraulic_model import RESIDUAL_SIGNALS
from ddh_twin_py.twin.losses import LOSSES

STATE_FIELDS = {
    "speed": "rad/s", "torque": "N*m", "current": "A", "voltage": "V", "electrical_power": "W",
    "pressure_piston_side": "Pa", "pressure_rod_side": "Pa", "pump_1_port_pressure": "Pa", "pump_2_port_pressure": "Pa",
    "rod_position": "m", "rod_velocity": "m/s", "cylinder_force": "N", "friction_force": "N",
    "pump_1_flow": "m3/s", "pump_2_flow": "m3/s", "pump_1_leakage": "m3/s", "pump_2_leakage": "m3/s",
    "relief_flow": "m3/s", "check_a_flow": "m3/s", "check_b_flow": "m3/s", "pump_1_torque": "N*m", "pump_2_torque": "N*m",
    "shaft_power": "W", "hydraulic_power": "W", "mechanical_power": "W",
}  # fmt: skip
"""Numbers of `HydraulicState` with their SI unit."""
MOTOR_FIELDS = ("copper_loss", "iron_loss_teeth", "iron_loss_yoke", "friction_loss", "hot_spot_temperature")
"""Numbers of `MotorThermalState` that are shown."""
ESTIMATE_PARTS = ("temperature", "standard_deviation", "predicted", "measured")
"""Of `TemperatureEstimate`, for every thermal node."""


@dataclass(frozen=True)
class Stream:
    """Columns that come together, in messages of one kind.

    `raw`: samples of a sensor, averaged over a row's time. `sparse`: a message holds some of the columns, NaN for the others.
    """

    name: str
    topic: str
    fields: tuple[str, ...]
    raw: bool = False
    sparse: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        return tuple(f"{self.name}.{field}" for field in self.fields)


def _with(prefix: str, names: Iterable[str]) -> tuple[str, ...]:
    return tuple(f"{prefix}.{name}" for name in names)


_POINT = (*STATE_FIELDS, *_with("loss", LOSSES))
STREAMS: tuple[Stream, ...] = (
    Stream("drive", DRIVE_TOPIC, DRIVE_FIELDS, raw=True),
    Stream("hydraulics", HYDRAULIC_TOPIC, HYDRAULIC_FIELDS, raw=True),
    *(Stream(sensor, TEMPERATURE_PREFIX + sensor, ("reading",), raw=True) for sensor in TEMPERATURE_SENSORS),
    Stream("state", "hydraulics/state", ("known", *_POINT, *_with("heat", NODES), *_with("flow", FLOW_PATHS))),
    Stream("prediction", "hydraulics/prediction", (*_POINT, *_with("temperature", NODES))),
    Stream("noise", "hydraulics/residuals", tuple(name for name, _, _ in RESIDUAL_SIGNALS)),
    Stream("motor", "motor/thermal_state", (*MOTOR_FIELDS, *_with("temperature", MOTOR_NODES))),
    Stream("estimate", "temperature/estimates", ("ambient", *(f"{node}.{part}" for node in NODES for part in ESTIMATE_PARTS))),
    Stream("innovation", "temperature/residuals", tuple(f"{sensor}.{part}" for sensor in SENSORS for part in ("residual", "deviation")),
           sparse=True),  # fmt: skip
    Stream("gap", "gap/residuals", tuple(name for name, _, _ in HYDRAULIC)),
    Stream("temperature_gap", "gap/residuals", TEMPERATURES, sparse=True),
)
BY_NAME = {stream.name: stream for stream in STREAMS}
NUMBER = {stream.name: number for number, stream in enumerate(STREAMS)}
COLUMNS: tuple[str, ...] = tuple(column for stream in STREAMS for column in stream.columns)
PLACE = {column: place for place, column in enumerate(COLUMNS)}
"""Where each column stands in a row of all columns."""
FIRST = {stream.name: PLACE[stream.columns[0]] for stream in STREAMS}
"""Where the columns of a stream begin in that row."""
