"""What a viewer should show: tabs of charts, each line a field of a topic. PlotJuggler and Foxglove get the same."""

from __future__ import annotations

from dataclasses import dataclass

from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, TOPIC_TYPES

OUTPUT_TYPES = {
    "temperature/estimates": "ddh_msgs/msg/TemperatureEstimateArray",
    "temperature/residuals": "ddh_msgs/msg/ResidualArray",
    "temperature/limits": "ddh_msgs/msg/LimitPrediction",
    "hydraulics/state": "ddh_msgs/msg/HydraulicState",
    "hydraulics/prediction": "ddh_msgs/msg/HydraulicState",
    "hydraulics/residuals": "ddh_msgs/msg/ResidualArray",
    "gap/status": "ddh_msgs/msg/GapStatus",
    "gap/residuals": "ddh_msgs/msg/ResidualArray",
    "motor/thermal_state": "ddh_msgs/msg/MotorThermalState",
    **{f"estimate/{node}": "sensor_msgs/msg/Temperature" for node in NODES},
}
"""Topics that the twin publishes, relative, and their types."""
TYPES = {**TOPIC_TYPES, **OUTPUT_TYPES}

MEASURED, FREE_RUN, SOFT_SENSOR, ESTIMATE, OTHER = "#5f6b7a", "#d55e00", "#009e73", "#0072b2", "#cc79a7"
"""Colours that people who are colour-blind can tell apart (Okabe and Ito): measured, free run, soft sensor, estimate, another."""


@dataclass(frozen=True)
class Line:
    """One line of a chart: `field` of `topic` (relative), dots for nested fields, `[i]` for an entry of an array.

    `where`: (array, key, value) where the field is of that entry of an array whose `key` is `value`; `index` is its place.
    """

    topic: str
    field: str
    label: str
    colour: str
    where: tuple[str, str, str] | None = None
    index: int = 0


@dataclass(frozen=True)
class Plot:
    """One chart."""

    title: str
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class Tab:
    """Charts below each other."""

    title: str
    plots: tuple[Plot, ...]


def _drive(field: str, title: str, unit: str) -> Plot:
    return _against("drive/telemetry", field, title, unit, soft=field != "speed")


def _hydraulic(field: str, title: str, unit: str) -> Plot:
    return _against("hydraulics/telemetry", field, title, unit, soft=False)


def _against(topic: str, field: str, title: str, unit: str, soft: bool) -> Plot:
    lines = [Line(topic, field, "measured", MEASURED), Line("hydraulics/prediction", field, "free run", FREE_RUN)]
    if soft:
        lines.append(Line("hydraulics/state", field, "soft sensor", SOFT_SENSOR))
    return Plot(f"{title} [{unit}]", tuple(lines))


def _temperature(node: str, sensor: str | None, title: str) -> Plot:
    index = NODES.index(node)
    lines = [
        Line(f"estimate/{node}", "temperature", "estimate", ESTIMATE),
        Line("temperature/estimates", "predicted", "free run", FREE_RUN, ("estimates", "location", node), index),
    ]
    if sensor:
        lines.insert(0, Line(TEMPERATURE_PREFIX + sensor, "temperature", "measured", MEASURED))
    return Plot(f"{title} [degC]", tuple(lines))


def _limit(index: int, location: str, title: str) -> Plot:
    return Plot(f"{title} [degC]", tuple(
        Line("temperature/limits", field, label, colour, ("limits", "location", location), index)
        for field, label, colour in (("temperature", "now", ESTIMATE), ("temperature_at_horizon", "at the horizon", FREE_RUN),
                                     ("limit", "limit", OTHER))
    ))


TABS = (
    Tab("Motion and pressure", (
        _hydraulic("pressure_piston_side", "Pressure, piston side", "Pa"), _hydraulic("pressure_rod_side", "Pressure, rod side", "Pa"),
        _hydraulic("rod_position", "Rod position", "m"), _hydraulic("rod_velocity", "Rod velocity", "m/s"),
    )),
    Tab("Drive", (
        Plot("Shaft speed [rad/s]", (
            Line("drive/telemetry", "speed_command", "command", OTHER), Line("drive/telemetry", "speed", "measured", MEASURED),
            Line("hydraulics/prediction", "speed", "free run", FREE_RUN),
        )),
        _drive("current", "Current", "A"), _drive("electrical_power", "Electrical power", "W"),
    )),
    Tab("Temperatures", (
        _temperature("end_winding", "motor_winding", "End winding"), _temperature("housing", "motor_housing", "Motor housing"),
        _temperature("pump_1_oil", None, "Oil in pump 1"), _temperature("tank_oil", "tank_oil", "Tank oil"),
        _temperature("cylinder_barrel", "cylinder_barrel", "Cylinder barrel"),
    )),
    Tab("Limits", tuple(
        _limit(index, location, title) for index, (location, title) in enumerate(
            (("winding_hot_spot", "Winding hot spot"), ("oil", "Hottest oil"), ("seals", "Seals")))
    )),
    Tab("Losses", (
        Plot("Power [W]", tuple(
            Line("hydraulics/state", field, label, colour) for field, label, colour in (
                ("electrical_power", "electrical", MEASURED), ("shaft_power", "shaft", ESTIMATE),
                ("hydraulic_power", "hydraulic", SOFT_SENSOR), ("mechanical_power", "piston", FREE_RUN))
        )),
        Plot("Motor losses [W]", tuple(
            Line("motor/thermal_state", field, label, colour) for field, label, colour in (
                ("copper_loss", "copper", FREE_RUN), ("iron_loss_teeth", "iron, teeth", ESTIMATE),
                ("iron_loss_yoke", "iron, yoke", SOFT_SENSOR), ("friction_loss", "friction", OTHER))
        )),
    )),
)
"""What both viewers show of a running twin, or of a bag of `ddh-twin export --mcap`."""


@dataclass(frozen=True)
class TablePlot:
    """One chart of a table of `ddh-twin export --csv` or `--parquet`: columns by name, with colours."""

    title: str
    columns: tuple[tuple[str, str], ...]


def table_tabs() -> list[tuple[str, list[TablePlot]]]:
    """The same for the columns of a table: tabs by title."""
    def signal(name: str, *sources: str) -> TablePlot:
        colours = {"measured": MEASURED, "free_run": FREE_RUN, "soft_sensor": SOFT_SENSOR}
        return TablePlot(name, tuple((f"{name}/{source}", colours[source]) for source in ("measured", *sources)))

    def temperature(node: str, sensor: str | None) -> TablePlot:
        read = ((f"{TEMPERATURE_PREFIX}{sensor}/measured", MEASURED),) if sensor else ()
        fields = (("temperature", ESTIMATE), ("lower", "#56b4e9"), ("upper", "#56b4e9"), ("free_run", FREE_RUN))
        return TablePlot(node, (*read, *((f"estimate/{node}/{field}", colour) for field, colour in fields)))

    return [
        ("Motion and pressure", [signal(name, "free_run") for name in (
            "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity")]),
        ("Drive", [signal("speed", "free_run"), signal("current", "free_run", "soft_sensor"),
                   signal("electrical_power", "free_run", "soft_sensor")]),
        ("Temperatures", [temperature("end_winding", "motor_winding"), temperature("housing", "motor_housing"),
                          temperature("pump_1_oil", None), temperature("tank_oil", "tank_oil"),
                          temperature("cylinder_barrel", "cylinder_barrel")]),
    ]
