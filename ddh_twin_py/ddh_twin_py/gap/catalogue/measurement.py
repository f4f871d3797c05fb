"""Sensors that do not read what is there."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.effect import Effect, added, fixed, scaled, value_of


def _offset(side: str, *confused_with: str) -> Effect:
    return Effect(
        id=f"sensor.pressure_{side}_side_offset", component="sensor", domain="measurement", parameter="offset", unit="Pa",
        title=f"sensor: zero of the {side}-side pressure",
        reference=fixed(0.0), laws=(added(f"measurement_pressure_{side}_side_offset"),), step=5e4, lowest=-2e7, highest=2e7,
        about=f"Zero error of the {side}-side pressure transducer: it reads too much.",
        about_below=f"Zero error of the {side}-side pressure transducer: it reads too little.",
        law="p_read = p + offset",
        signature=f"{side.capitalize()}-side pressure is off by the same in all phases; current and temperatures are not.",
        check=(
            "Lower and secure the load, stop the drive, relieve both sides to tank and see on a second gauge that the pressure is "
            "gone: the sensor should read 0."
        ),
        confused_with=confused_with,
    )


def _lag(record: np.ndarray, x: float) -> None:
    record["measurement_surface_lag_ratio"] += x / record["sensors_temperature_time_constant"]


EFFECTS = (
    _offset("piston", "cylinder.seal_friction", "load.mass"),
    _offset("rod", "check_valve.cracking", "sensor.pressure_rod_side_gain"),
    Effect(
        id="sensor.pressure_rod_side_gain", component="sensor", domain="measurement", parameter="gain", unit="1",
        title="sensor: span of the rod-side pressure",
        reference=fixed(1.0), laws=(scaled("measurement_pressure_rod_side_gain"),), step=0.02, lowest=-0.5, highest=1.0,
        about="Span error of the rod-side pressure transducer: it reads too much.",
        about_below="Span error of the rod-side pressure transducer: it reads too little.",
        law="p_read = g p",
        signature="Rod-side pressure is off in proportion to itself; current does not follow.",
        check=(
            "Depressurised, fit a calibrated gauge rated for the unit's highest pressure beside it; compare at several pressures "
            "below the relief setting."
        ),
        confused_with=("pump_2.leakage", "relief_valve.setting", "relief_valve.seat_leakage", "sensor.pressure_rod_side_offset"),
    ),
    Effect(
        id="sensor.rod_position_scale", component="sensor", domain="measurement", parameter="gain", unit="1",
        reference=fixed(1.0), laws=(scaled("measurement_rod_position_scale"),), step=0.01, lowest=-0.3, highest=0.5,
        about="The wire encoder's scale is off: position and velocity read too much.",
        about_below="The wire encoder's scale is off: position and velocity read too little.",
        law="x_read = g x",
        signature="Strokes and velocity are off by one factor; pressures are not.",
        check="Measure the rod at two standstills with a tape, the drive stopped and nobody beneath the load.",
        confused_with=("pump_1.leakage",),
    ),
    Effect(
        id="sensor.temperature_lag", component="sensor", domain="measurement", parameter="time_constant", unit="s",
        title="sensor: lag on surfaces",
        reference=lambda record: float(record["sensors_temperature_time_constant"][0] * record["measurement_surface_lag_ratio"][0]),
        laws=(_lag,), step=10.0, lowest=-4.5, highest=1000.0, grows=True,
        about="The surface sensors follow more slowly than {reference}.",
        about_below="The surface sensors follow faster than {reference}.",
        law="tau dT_read/dt = T - T_read",
        signature="Surface temperatures trail while they change and agree when steady.",
        check="Warm a sensor by hand and time it.",
        confused_with=("tank.oil_level", "sensor.surface_contact"),
    ),
    Effect(
        id="sensor.surface_contact", component="sensor", domain="measurement", parameter="ambient_fraction", unit="1",
        title="sensor: contact with surfaces",
        reference=fixed(0.0), laws=(added("measurement_surface_contact"),), step=0.05, lowest=0.0, highest=0.9,
        about="The surface sensors read between surface and air.",
        law="T_read = (1 - f) T + f T_ambient",
        signature="All surface temperatures read low in proportion to their rise; oil and winding do not.",
        check="Press a second sensor with paste beside one of them.",
        confused_with=(
            "motor.contact_resistance", "motor.cooling", "pump_1.cooling", "tank.cooling", "tank.mount_conduction", "cylinder.cooling",
            "ambient.enclosure", "sensor.temperature_lag",
        ),
    ),
    Effect(
        id="sensor.time_skew", component="sensor", domain="measurement", parameter="delay", unit="s",
        title="sensor: clocks apart",
        reference=value_of("measurement_time_skew"), laws=(added("measurement_time_skew"),), step=0.01, lowest=-0.5, highest=0.5,
        about="The hydraulic stream is stamped later than the drive stream for the same instant.",
        about_below="The hydraulic stream is stamped earlier than the drive stream for the same instant.",
        law="t_stamp = t + delay",
        signature="Pressures and velocity trail speed and current at every change, by the same time.",
        check="Compare both clocks, or record one signal in both streams.",
        confused_with=("oil.air_content", "line_b.compliance", "drive.speed_lag"),
    ),
)
