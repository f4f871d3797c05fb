"""Values of the library to messages and back, K to degC among them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from sensor_msgs.msg import Temperature

from ddh_msgs.msg import (
    ComponentLoss,
    HydraulicState,
    MotorThermalState,
    Residual,
    ResidualArray,
    TemperatureEstimate,
    TemperatureEstimateArray,
)
from ddh_twin_py.nodes.messages.wire import Layout
from ddh_twin_py.physics.thermal_network import FLOW_PATHS, MOTOR_NODES, NODES
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.signals import ZERO_CELSIUS
from ddh_twin_py.twin.hydraulic_model import RESIDUAL_SIGNALS
from ddh_twin_py.twin.losses import LOSSES
from ddh_twin_py.twin.machine_thermal import MotorResult

SOFT_SENSOR, FREE_RUN, FUSION = "soft_sensor", "free_run", "fusion"

_POINT_FIELDS = [
    name
    for name, kind in HydraulicState.get_fields_and_field_types().items()
    if kind == "double" and name != "interval"
]


def to_kelvin(celsius):
    """K of degC."""
    return np.asarray(celsius) + ZERO_CELSIUS


def to_celsius(kelvin):
    """degC of K."""
    return np.asarray(kelvin) - ZERO_CELSIUS


def hydraulic_layout(mode: str) -> Layout:
    """`HydraulicState` with the twin's names in it."""
    nodes = len(NODES)
    return Layout(
        HydraulicState(
            mode=mode,
            losses=[ComponentLoss(component=name) for name in LOSSES],
            heat_nodes=list(NODES),
            heat=[0.0] * nodes,
            flow_paths=list(FLOW_PATHS),
            flow=[0.0] * len(FLOW_PATHS),
            temperature_nodes=list(NODES),
            temperature=[0.0] * nodes,
        )
    )


def hydraulic_values(points: np.ndarray, temperature: np.ndarray, known: np.ndarray, interval: float) -> dict:
    """Fields of `HydraulicState` for n operating points and temperatures in K (n, N)."""
    values = {name: points[name] for name in _POINT_FIELDS}
    values["losses.power"] = np.column_stack([sum(points[field] for field in fields) for fields in LOSSES.values()])
    values |= {"interval": interval, "telemetry_known": known, "heat": points["heat"], "flow": points["flow"]}
    values["temperature"] = to_celsius(temperature)
    return values


def residual_layout(source: str, names: Sequence[str], units: Sequence[str]) -> Layout:
    """`ResidualArray` of the named signals."""
    rows = [Residual(signal=name, unit=unit) for name, unit in zip(names, units, strict=True)]
    return Layout(ResidualArray(source=source, residuals=rows))


def hydraulic_residual_layout(source: str) -> Layout:
    """`ResidualArray` of the hydraulic model."""
    return residual_layout(source, [name for name, _, _ in RESIDUAL_SIGNALS], [unit for _, _, unit in RESIDUAL_SIGNALS])


def hydraulic_residuals(rig: Rig, measured: np.ndarray, points: np.ndarray, settled: np.ndarray | None = None) -> dict:
    """Fields of `ResidualArray` for n intervals; predictions and residuals are NaN where the model is not ``settled``, (n,).

    What was not measured is NaN, too.
    """
    read = np.column_stack([measured[name] for name, _, _ in RESIDUAL_SIGNALS])
    noise = [rig.sensors[key].noise if key in rig.sensors else np.nan for _, key, _ in RESIDUAL_SIGNALS]
    predicted = np.column_stack([points[name] for name, _, _ in RESIDUAL_SIGNALS])
    if settled is not None:
        predicted[~settled] = np.nan
    return _residuals(read, predicted, np.array([noise]))


def _residuals(measured: np.ndarray, predicted: np.ndarray, deviation: np.ndarray) -> dict:
    return {
        "residuals.measured": measured,
        "residuals.predicted": predicted,
        "residuals.residual": measured - predicted,
        "residuals.standard_deviation": np.broadcast_to(deviation, measured.shape),
    }


def motor_layout() -> Layout:
    """`MotorThermalState` with the twin's names in it."""
    count = len(MOTOR_NODES)
    nodes = list(MOTOR_NODES)
    zeros = [0.0] * count
    return Layout(MotorThermalState(heat_nodes=nodes, heat=zeros, nodes=nodes, temperature=zeros))


def motor_values(result: MotorResult, interval: float) -> dict:
    """Fields of `MotorThermalState` for n intervals."""
    points, temperature = result.points, to_celsius(result.temperature)
    winding = [i for i, name in enumerate(MOTOR_NODES) if "winding" in name]
    return {
        "interval": interval,
        "telemetry_known": result.known,
        "mean_square_current": points["mean_square_current"],
        "speed": points["speed"],
        "speed_absolute": points["speed_absolute"],
        "copper_loss": points["loss_copper"],
        "iron_loss_teeth": points["heat"][:, MOTOR_NODES.index("teeth")],
        "iron_loss_yoke": points["heat"][:, MOTOR_NODES.index("yoke")],
        "friction_loss": points["loss_motor_friction"],
        "heat": points["heat"][:, : len(MOTOR_NODES)],
        "temperature": temperature,
        "hot_spot_temperature": temperature[:, winding].max(axis=1),
    }


def estimate_layout() -> Layout:
    """`TemperatureEstimateArray` of all thermal nodes."""
    return Layout(TemperatureEstimateArray(estimates=[TemperatureEstimate(location=name) for name in NODES]))



def location_layout(location: str) -> Layout:
    """`sensor_msgs/Temperature` of one location, named in its frame."""
    message = Temperature()
    message.header.frame_id = location
    return Layout(message)
