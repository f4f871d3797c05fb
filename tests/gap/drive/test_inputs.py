"""Unknown inputs of a unit from its recordings alone: what was added to a rig is found where it was added."""

import numpy as np
import pytest
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.gap.drive.inputs import unknown_inputs
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.rehearsal import rehearse
from support.simulated import DUTY

SENSORS = ["motor_winding", "motor_housing", "tank_oil"]


def recorded(changed, duration=150.0):
    return rehearse(load_rig().with_values(changed), load_duty(DUTY / "paper_cycle.yaml"), duration, SENSORS)


def found(changed, duration=150.0):
    rows = unknown_inputs(recorded(changed, duration), recorded({}, duration), load_rig())
    assert sum(row.share for row in rows) == pytest.approx(1.0 if changed else 0.0)
    return {(row.component, row.phase, row.regime, row.unit): row for row in rows}


def test_a_bearing_that_drags_is_a_torque_at_the_shaft_against_the_motion():
    rows = found({"motor.friction_coulomb": load_rig()["motor.friction_coulomb"] + 0.45})
    lifting, lowering = rows[("motor", "lifting", "", "N*m")], rows[("motor", "lowering", "", "N*m")]
    assert lifting.value == pytest.approx(0.45, abs=0.03) and lowering.value == pytest.approx(-0.45, abs=0.03)
    assert abs(lifting.value) > 4.0 * lifting.std
    force = rows[("cylinder", "lifting", "", "N")]
    assert abs(force.value) < 4.0 * force.std


def test_a_pump_that_leaks_gives_the_rod_less_flow_than_its_laws_say():
    leakage = load_rig()["pump_1.leakage"]
    rows = found({"pump_1.leakage": 3.0 * leakage})
    measured = replay(recorded({"pump_1.leakage": 3.0 * leakage}), load_rig()).measured
    pressure = np.median(measured["pressure_piston_side"][measured["speed"] > 50.0])
    flow = rows[("pump_1", "lifting", "", "m3/s")]
    assert flow.value < -4.0 * flow.std and flow.value == pytest.approx(-2.0 * leakage * pressure, rel=0.15)


def test_a_heater_is_heat_of_the_part_that_it_warms():
    rows = found({"learned.motor_heat": 60.0}, 600.0)
    heat = {key: row for key, row in rows.items() if key[3] == "W"}
    housing = heat[("motor", "all", "housing", "W")]
    assert 10.0 < housing.value < 60.0 and housing.value > 2.0 * housing.std
    assert max(heat.values(), key=lambda row: row.value) is housing


def test_a_recording_without_motion_tells_heat_alone():
    rows = found({}, 3.0)
    assert {key[3] for key in rows} == {"W"}
