"""Faults that no catalogue knows: the right answer to them is `unknown`, at their component."""

from __future__ import annotations

from ddh_twin_py.plant.fault import Fault, adding, zero


def _fault(id: str, domain: str, unit: str, field: str, step: float, highest: float) -> Fault:
    return Fault(id, id.split(".")[0], domain, field, unit, adding(field), zero, step, 0.0, highest, listed=False)


_G = "m3/(s*Pa)"

UNLISTED: dict[str, Fault] = {fault.id: fault for fault in (
    _fault("relief_valve.open_when_warm", "hydraulic", f"{_G}/K", "hot_valve", 3e-14, 1e-11),
    _fault("tank.foam_in_motion", "thermal", "1", "foam", 0.3, 0.98),
    _fault("pump_1.starvation_at_speed", "hydraulic", "m3*s/rad2", "starvation", 4e-10, 1.2e-8),
    _fault("pump_1.cold_suction", "hydraulic", "1", "cold_suction", 0.005, 0.2),
    _fault("pump_2.clearance_growth", "hydraulic", "1/K", "clearance_growth", 0.1, 5.0),
    _fault("load.sway", "mechanical", "N", "sway", 60.0, 700.0),
    _fault("line_a.heated_hose", "thermal", "W", "hose_heater", 4.0, 120.0),
    _fault("sensor.encoder_slip", "measurement", "1", "slip", 0.01, 0.2),
    _fault("drive.supply_sag", "electrical", "1/kW", "sag", 0.02, 0.4),
    _fault("motor.thermostat_fan", "thermal", "1", "thermostat_fan", 2.0, 12.0),
    _fault("cylinder.bent_rod", "mechanical", "N", "bent_rod", 150.0, 1800.0),
    _fault("sensor.drifting_housing", "measurement", "K/s", "drift", 1e-3, 2e-2),
    _fault("sensor.current_zero", "measurement", "A", "current_zero", 0.15, 3.0),
    _fault("motor.dragging_brake", "mechanical", "N*m", "brake_drag", 0.3, 4.0),
    _fault("cylinder.worn_in_the_middle", "hydraulic", _G, "worn_middle", 3e-13, 1e-11),
    _fault("load.picked_up", "mechanical", "kg", "picked_up", 5.0, 120.0),
    _fault("motor.saturation", "electrical", "1", "saturation", 0.05, 1.0),
    _fault("pump_1.wears_on", "hydraulic", "1/s", "wear", 4e-4, 2e-2),
    _fault("pump_2.leaks_one_way", "hydraulic", "1", "one_way_leak", 0.2, 8.0),
    _fault("tank.cooler_when_warm", "thermal", "W/K", "cooler", 5.0, 100.0),
    _fault("ambient.draught", "thermal", "1", "draught", 0.5, 9.0),
    _fault("cylinder.rubs_one_way", "mechanical", "N", "rubs_back", 80.0, 3000.0),
    _fault("sensor.drifting_pressure", "measurement", "Pa/s", "pressure_drift", 300.0, 5000.0),
    _fault("sensor.housing_gain", "measurement", "1", "housing_gain", 0.03, 0.4),
    _fault("line_b.flap", "hydraulic", "1", "flap", 3.0, 60.0),
    _fault("drive.command_zero", "electrical", "rad/s", "command_zero", 0.1, 3.0),
)}
"""Fault to what it does to the plant."""

NEEDS_SENSOR: dict[str, str] = {"sensor.drifting_housing": "motor_housing", "motor.thermostat_fan": "motor_housing",
                                "line_a.heated_hose": "line_a", "tank.foam_in_motion": "tank_wall",
                                "tank.cooler_when_warm": "tank_oil", "ambient.draught": "motor_housing",
                                "sensor.housing_gain": "motor_housing"}
"""Fault to the temperature sensor without which nothing would be seen of it."""

