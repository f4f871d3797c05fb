"""The catalogue's effects in the plant."""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.plant.fault import Apply, Fault, adding, zero


def _sheetadding(field: str) -> Apply:
    def apply(params: np.ndarray, condition: np.ndarray, x: float) -> None:
        params[field] += x

    return apply


def _sheet_ratio(field: str) -> Apply:
    def apply(params: np.ndarray, condition: np.ndarray, x: float) -> None:
        params[field] *= 1.0 + x

    return apply


def _viscosity_slope(params: np.ndarray, condition: np.ndarray, x: float) -> None:
    """B changes, A follows so that the viscosity at 40 degC stays."""
    params["oil_walther_b"] += x
    params["oil_walther_a"] += x * math.log10(313.15)


def _payload(params: np.ndarray, condition: np.ndarray, x: float) -> None:
    condition["payload"] = params["load_payload_mass"] + x


def _seal(params: np.ndarray, condition: np.ndarray, x: float) -> None:
    condition["seal_rubbing"] += x if x > 0.0 else 0.0
    params["cylinder_friction_coulomb"] += min(x, 0.0)


def _slow_sensors(params: np.ndarray, condition: np.ndarray, x: float) -> None:
    condition["surface_lag"] = params["sensors_temperature_time_constant"] + x


def _one(record: np.ndarray) -> float:
    return 1.0


def _of(field: str):
    return lambda record: float(record[field][0])


def _fault(id: str, domain: str, parameter: str, unit: str, apply: Apply, nominal, step: float, lowest: float = 0.0,
           highest: float = math.inf, paths: tuple = (), ratio: bool = False) -> Fault:
    return Fault(id, id.split(".")[0], domain, parameter, unit, apply, nominal, step, lowest, highest, paths, ratio)


_H, _M, _E, _T, _S = "hydraulic", "mechanical", "electrical", "thermal", "measurement"
_G = "m3/(s*Pa)"

LISTED: dict[str, Fault] = {fault.id: fault for fault in (
    _fault("pump_1.leakage", _H, "leakage_ratio", "1", adding("leakage_1"), _one, 0.1, 0.0, 5.0, (("pump_1.leakage", 1.0),), True),
    _fault("pump_2.leakage", _H, "leakage_ratio", "1", adding("leakage_2"), _one, 0.1, 0.0, 5.0, (("pump_2.leakage", 1.0),), True),
    _fault("cylinder.cross_leakage", _H, "conductance", _G, adding("cross_leakage"), zero, 1e-13, 0.0, 3e-12),
    _fault("relief_valve.setting", _H, "opening_pressure", "Pa", _sheetadding("relief_valve_opening_pressure"),
           _of("relief_valve_opening_pressure"), 3e5, -7e6, 6e6, (("relief_valve.opening_pressure", 1.0),)),
    _fault("relief_valve.seat_leakage", _H, "conductance", _G, adding("seat_leakage"), zero, 1e-13, 0.0, 3e-12),
    _fault("check_valve.cracking", _H, "cracking_pressure", "Pa", _sheetadding("check_valve_cracking_pressure"),
           _of("check_valve_cracking_pressure"), 1e4, 0.0, 5.8e4, (("check_valve.cracking_pressure", 1.0),)),
    _fault("oil.viscosity_temperature", _H, "viscosity_index_slope", "1", _viscosity_slope, _of("oil_walther_b"), 0.05, -0.6, 0.6,
           (("oil.walther_b", 1.0),)),
    _fault("oil.air_content", _H, "volume_fraction", "1", _sheetadding("oil_air_fraction"), _of("oil_air_fraction"), 0.005, 0.0, 0.1,
           (("oil.air_fraction", 1.0),)),
    _fault("line_b.compliance", _H, "volume_expansion", "m3/Pa", adding("hose_swell"), zero, 2e-13, 0.0, 4e-12),
    _fault("pump_1.friction", _M, "torque", "N*m", adding("rubbing_1"), zero, 0.2, 0.0, 4.0),
    _fault("pump_2.friction", _M, "torque", "N*m", adding("rubbing_2"), zero, 0.2, 0.0, 4.0),
    _fault("motor.bearing_friction", _M, "torque", "N*m", adding("bearing_rubbing"), zero, 0.2, 0.0, 4.0,
           (("motor.friction_coulomb", 1.0),)),
    _fault("cylinder.seal_friction", _M, "force", "N", _seal, _of("cylinder_friction_coulomb"), 80.0, 0.0, 3000.0,
           (("cylinder.friction_coulomb", 1.0),)),
    _fault("load.mass", _M, "mass", "kg", _payload, _of("load_payload_mass"), 5.0, -45.0, 120.0, (("load.payload_mass", 1.0),)),
    _fault("load.geometry", _M, "force_slope", "N/m", adding("boom_slope"), zero, 400.0, -3000.0, 6000.0),
    _fault("line_a.pressure_drop", _M, "quadratic_coefficient", "Pa*s2/m6", adding("rough_a"), zero, 1e12, 0.0, 2e13),
    _fault("line_b.pressure_drop", _M, "quadratic_coefficient", "Pa*s2/m6", adding("rough_b"), zero, 1e12, 0.0, 2e13),
    _fault("motor.copper_resistance", _E, "resistance_ratio", "1", _sheet_ratio("motor_phase_resistance_20C"), _one, 0.05, -0.5, 1.5,
           (("motor.phase_resistance_20C", 1.0),), True),
    _fault("motor.iron_loss", _E, "loss_ratio", "1", adding("iron_ratio"), _one, 1.0, 0.0, 12.0,
           (("motor.iron.hysteresis_coefficient", 1.0),), True),
    _fault("motor.pwm_loss", _E, "power", "W", adding("harmonic_power"), zero, 8.0, 0.0, 250.0),
    _fault("motor.demagnetisation", _E, "torque_constant_slope", "1/K", lambda p, c, x: adding("magnet_slope")(p, c, -x), zero,
           1e-3, 0.0, 1.2e-2),
    _fault("drive.torque_estimate", _E, "gain", "1", adding("current_gain"), _one, 0.03, -0.4, 0.6,
           (("motor.torque_constant", -1.0),)),
    _fault("drive.speed_lag", _E, "time_constant", "s", _sheetadding("motor_speed_loop_time_constant"),
           _of("motor_speed_loop_time_constant"), 0.02, 0.0, 0.6, (("motor.speed_loop_time_constant", 1.0),)),
    _fault("motor.contact_resistance", _T, "resistance_ratio", "1", adding("interface_ratio"), _one, 2.0, 0.0, 25.0,
           (("motor.thermal.yoke_to_housing", -1.0),), True),
    _fault("motor.cooling", _T, "convection_ratio", "1", adding("motor_wind"), _one, 1.0, -0.95, 9.0,
           (("motor.thermal.housing_convection", 1.0),), True),
    _fault("motor.flange_conduction", _T, "conductance", "W/K", adding("flange"), zero, 1.0, 0.0, 25.0),
    _fault("pump_1.cooling", _T, "convection_ratio", "1", adding("pump_wind"), _one, 1.0, -0.95, 9.0,
           (("pump_1.convection", 0.5), ("pump_2.convection", 0.5)), True),
    _fault("tank.cooling", _T, "convection_ratio", "1", adding("tank_wind"), _one, 1.0, -0.95, 9.0, (("tank.convection", 1.0),), True),
    _fault("tank.oil_level", _T, "volume_ratio", "1", adding("fill_ratio"), _one, 0.2, -0.75, 0.6, (("tank.oil_volume", 1.0),), True),
    _fault("tank.mount_conduction", _T, "conductance", "W/K", adding("mount"), zero, 2.0, 0.0, 40.0),
    _fault("cylinder.cooling", _T, "convection_ratio", "1", adding("barrel_wind"), _one, 1.0, -0.95, 9.0,
           (("cylinder.convection", 1.0),), True),
    _fault("ambient.solar_load", _T, "power", "W", adding("sun"), zero, 30.0, 0.0, 500.0),
    _fault("ambient.enclosure", _T, "temperature_rise", "K", adding("enclosure"), zero, 3.0, 0.0, 35.0),
    _fault("sensor.pressure_piston_side_offset", _S, "offset", "Pa", adding("zero_a"), zero, 8e4, -3e6, 3e6),
    _fault("sensor.pressure_rod_side_offset", _S, "offset", "Pa", adding("zero_b"), zero, 8e4, -3e6, 3e6),
    _fault("sensor.pressure_rod_side_gain", _S, "gain", "1", adding("span_b"), _one, 0.01, -0.3, 0.3),
    _fault("sensor.rod_position_scale", _S, "gain", "1", adding("rod_scale"), _one, 0.01, -0.15, 0.15),
    _fault("sensor.temperature_lag", _S, "time_constant", "s", _slow_sensors, _of("sensors_temperature_time_constant"), 40.0, 0.0,
           400.0, (("sensors.temperature.time_constant", 1.0),)),
    _fault("sensor.surface_contact", _S, "ambient_fraction", "1", adding("surface_share"), zero, 0.1, 0.0, 0.8),
    _fault("sensor.time_skew", _S, "delay", "s", adding("skew"), zero, 0.02, 0.0, 0.4),
)}
"""Effect of the catalogue to what it does to the plant."""
