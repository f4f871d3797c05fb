"""The table of all telemetry signals: topic, field, unit, plausible range, likely mistakes of unit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ddh_twin_py.names import no_such

ZERO_CELSIUS = 273.15  # K

DRIVE_TOPIC = "drive/telemetry"
HYDRAULIC_TOPIC = "hydraulics/telemetry"
TEMPERATURE_PREFIX = "temperature/"
BESIDE_SENSORS = ("temperature/estimates", "temperature/limits", "temperature/residuals")
"""Topics of the twin that lie among those of the temperature sensors."""
RIG_TOPIC = "rig"

DRIVE_TYPE = "ddh_msgs/msg/DriveTelemetry"
HYDRAULIC_TYPE = "ddh_msgs/msg/HydraulicTelemetry"
TEMPERATURE_TYPE = "sensor_msgs/msg/Temperature"
RIG_TYPE = "ddh_msgs/msg/RigInfo"

DRIVE_FIELDS = ("speed_command", "speed", "torque", "current", "voltage", "electrical_power")
HYDRAULIC_FIELDS = ("pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity")
TEMPERATURE_FIELDS = ("temperature", "variance")
MACHINE_FIELDS: Mapping[str, tuple[str, ...]] = {DRIVE_TOPIC: DRIVE_FIELDS, HYDRAULIC_TOPIC: HYDRAULIC_FIELDS}
"""Of the topics that carry no temperature."""

TEMPERATURE_SENSORS = (
    "ambient",
    "motor_winding",
    "motor_housing",
    "pump_1_case",
    "pump_2_case",
    "tank_oil",
    "tank_wall",
    "cylinder_barrel",
    "line_a",
    "line_b",
)


@dataclass(frozen=True)
class UnitMistake:
    """A unit that a signal is often given in by mistake.

    A value given in `unit` reads ``factor * right_value + offset`` (in the unit of the
    signal inside the project, kelvin for temperatures).
    """

    unit: str
    factor: float
    offset: float = 0.0

    def corrected(self, value: float) -> float:
        """The value in the right unit, had `value` been given in the wrong one."""
        return (value - self.offset) / self.factor


@dataclass(frozen=True)
class Signal:
    """One measured quantity.

    `topic` is relative; `unit` is the unit inside the project (temperatures: K) and
    `message_unit` the one on the wire (temperatures: degC). `lowest` and `highest` bound what
    a sound sensor of this rig could ever report, offset and noise included, in `unit`; within `usual`
    it is what a machine is likely to have, by which a mistake of unit is told from others.
    `noise_key` names the entry of the rig sheet's `sensors`, None for a quantity without noise.
    """

    topic: str
    message_type: str
    field: str
    unit: str
    message_unit: str
    lowest: float
    highest: float
    noise_key: str | None
    mistakes: tuple[UnitMistake, ...] = ()
    message_offset: float = 0.0  # value inside = value of the message + message_offset
    usual: tuple[float, float] = (-math.inf, math.inf)

    @property
    def name(self) -> str:
        """Name within the rig: the field, or `temperature/<sensor>`."""
        return self.topic if self.topic.startswith(TEMPERATURE_PREFIX) else self.field

    def to_message(self, value: float) -> float:
        """Value in the unit of the message, for people to read."""
        return value - self.message_offset


_RPM = UnitMistake("rpm", 30.0 / math.pi)
_PRESSURE_MISTAKES = (
    UnitMistake("bar", 1e-5),
    UnitMistake("MPa", 1e-6),
    UnitMistake("Pa, converted from bar twice", 1e5),
)
DEGF = UnitMistake("degF", 1.8, ZERO_CELSIUS + 32.0 - 1.8 * ZERO_CELSIUS)
KELVIN = UnitMistake("K", 1.0, ZERO_CELSIUS)
TENTHS = UnitMistake("tenths of degC", 10.0, -9.0 * ZERO_CELSIUS)
OTHER_SIGN = UnitMistake("degC of the other sign", -1.0, 2.0 * ZERO_CELSIUS)
_TEMPERATURE_MISTAKES = (
    KELVIN,
    DEGF,
    TENTHS,
    UnitMistake("degC less 273.15", 1.0, -ZERO_CELSIUS),
    OTHER_SIGN,
)


def _drive(field, unit, limit, noise_key, *mistakes, lowest=None):
    return Signal(
        DRIVE_TOPIC,
        DRIVE_TYPE,
        field,
        unit,
        unit,
        -limit if lowest is None else lowest,
        limit,
        noise_key,
        mistakes,
    )


def _hydraulic(field, unit, lowest, highest, noise_key, *mistakes):
    return Signal(HYDRAULIC_TOPIC, HYDRAULIC_TYPE, field, unit, unit, lowest, highest, noise_key, mistakes)


def _temperature(sensor, lowest_celsius, highest_celsius):
    return Signal(
        TEMPERATURE_PREFIX + sensor,
        TEMPERATURE_TYPE,
        "temperature",
        "K",
        "degC",
        lowest_celsius + ZERO_CELSIUS,
        highest_celsius + ZERO_CELSIUS,
        "temperature",
        _TEMPERATURE_MISTAKES,
        ZERO_CELSIUS,
        (ZERO_CELSIUS - 40.0, ZERO_CELSIUS + _HOTTEST.get(sensor, 110.0)),
    )


# Limits: motor 3000 rpm and 23.5 A; relief at 160 bar, sensor full scale 400 bar; stroke 0.4 m.
# Gauge pressure cannot be below -1.0e5 Pa, but a sensor's offset and noise can take it there.
DRIVE_SIGNALS = (
    _drive("speed_command", "rad/s", 450.0, None, _RPM),
    _drive("speed", "rad/s", 450.0, "speed", _RPM),
    _drive("torque", "N*m", 120.0, "torque", UnitMistake("N*mm", 1e3)),
    _drive("current", "A", 75.0, "current", UnitMistake("mA", 1e3)),
    _drive("voltage", "V", 1000.0, "voltage", UnitMistake("mV", 1e3), lowest=-50.0),
    _drive("electrical_power", "W", 40000.0, "electrical_power", UnitMistake("mW", 1e3)),
)
HYDRAULIC_SIGNALS = (
    _hydraulic("pressure_piston_side", "Pa", -5e5, 6e7, "pressure", *_PRESSURE_MISTAKES),
    _hydraulic("pressure_rod_side", "Pa", -5e5, 6e7, "pressure", *_PRESSURE_MISTAKES),
    _hydraulic("rod_position", "m", -0.2, 1.0, "rod_position", UnitMistake("mm", 1e3)),
    _hydraulic("rod_velocity", "m/s", -2.0, 2.0, "rod_velocity", UnitMistake("mm/s", 1e3)),
)
_HOTTEST = {"ambient": 60.0, "motor_winding": 160.0}  # degC that are usual
_CELSIUS_LIMITS = {"ambient": (-50.0, 70.0), "motor_winding": (-50.0, 230.0)}
TEMPERATURE_SIGNALS = tuple(
    _temperature(sensor, *_CELSIUS_LIMITS.get(sensor, (-50.0, 180.0))) for sensor in TEMPERATURE_SENSORS
)
SIGNALS = DRIVE_SIGNALS + HYDRAULIC_SIGNALS + TEMPERATURE_SIGNALS

TOPIC_TYPES: Mapping[str, str] = {
    DRIVE_TOPIC: DRIVE_TYPE,
    HYDRAULIC_TOPIC: HYDRAULIC_TYPE,
    **{TEMPERATURE_PREFIX + sensor: TEMPERATURE_TYPE for sensor in TEMPERATURE_SENSORS},
    RIG_TOPIC: RIG_TYPE,
}
RATES: Mapping[str, tuple[float, float]] = {
    DRIVE_TOPIC: (50.0, 1000.0),
    HYDRAULIC_TOPIC: (50.0, 1000.0),
    TEMPERATURE_PREFIX: (0.1, 10.0),
}
"""Lowest and highest rate of the interface, Hz."""


def signals_of(topic: str) -> tuple[Signal, ...]:
    """Signals of a relative topic, in the order of its fields.

    Raises KeyError, naming the nearest valid topic, when the topic carries no signal.
    """
    found = tuple(signal for signal in SIGNALS if signal.topic == topic)
    if not found:
        raise KeyError(no_such("topic", topic, sorted({s.topic for s in SIGNALS})))
    return found


def signal_named(name: str) -> Signal:
    """The signal of that name, such as `speed` or `temperature/tank_oil`.

    Raises KeyError, naming the nearest valid name, when there is none.
    """
    for signal in SIGNALS:
        if signal.name == name:
            return signal
    raise KeyError(no_such("signal", name, [s.name for s in SIGNALS]))
