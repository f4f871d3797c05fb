"""What may be wrong with a rig, as one record of numbers that the plant's laws read."""

from __future__ import annotations

import numpy as np

NEUTRAL: dict[str, float] = {
    # hydraulic
    "leakage_1": 1.0, "leakage_2": 1.0, "cross_leakage": 0.0, "seat_leakage": 0.0, "hose_swell": 0.0,
    "rough_a": 0.0, "rough_b": 0.0,
    # mechanical
    "rubbing_1": 0.0, "rubbing_2": 0.0, "bearing_rubbing": 0.0, "seal_rubbing": 0.0, "boom_slope": 0.0, "payload": 0.0,
    # electrical
    "iron_ratio": 1.0, "harmonic_power": 0.0, "magnet_slope": 0.0, "current_gain": 1.0,
    # thermal
    "interface_ratio": 1.0, "motor_wind": 1.0, "pump_wind": 1.0, "tank_wind": 1.0, "barrel_wind": 1.0, "flange": 0.0,
    "fill_ratio": 1.0, "mount": 0.0, "sun": 0.0, "enclosure": 0.0,
    # measurement
    "zero_a": 0.0, "zero_b": 0.0, "span_b": 1.0, "rod_scale": 1.0, "surface_lag": 0.0, "surface_share": 0.0, "skew": 0.0,
    # not in the catalogue
    "hot_valve": 0.0, "hot_valve_from": 273.15 + 27.0, "foam": 0.0, "starvation": 0.0, "sway": 0.0, "sway_rate": 5.0,
    "hose_heater": 0.0, "slip": 0.0, "sag": 0.0, "thermostat_fan": 0.0, "thermostat_from": 273.15 + 30.0, "bent_rod": 0.0,
    "cold_suction": 0.0, "drift": 0.0, "current_zero": 0.0, "clearance_growth": 0.0, "brake_drag": 0.0,
    "worn_middle": 0.0, "picked_up": 0.0, "saturation": 0.0, "wear": 0.0, "one_way_leak": 0.0, "cooler": 0.0, "cooler_above": 2.0,
    "draught": 0.0, "rubs_back": 0.0, "pressure_drift": 0.0, "housing_gain": 0.0, "flap": 0.0, "command_zero": 0.0,
}
"""Quantity to the value at which the rig is sound; SI, K where a temperature is meant. `payload` and `surface_lag`: 0
takes the rig's own."""

CONDITION_DTYPE = np.dtype([(name, np.float64) for name in NEUTRAL])
"""Fields of a condition, shape (1,) as compiled code takes it."""


def sound() -> np.ndarray:
    """The condition of a rig without faults, shape (1,)."""
    record = np.zeros(1, CONDITION_DTYPE)
    for name, value in NEUTRAL.items():
        record[name] = value
    return record
