"""A simulated rig that is exactly the one of its file."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.cli.simulated import collect
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.gap.shrink.size import ratios
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Finding
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.duty_file import duty_file
from ddh_twin_py.twin.simulated_rig import SimulatedRig

DURATION = 120.0
ERRING = {
    "measurement.current_gain": 1.05, "measurement.pressure_rod_side_gain": 1.1, "measurement.rod_position_scale": 1.03,
    "measurement.surface_contact": 0.2, "measurement.surface_lag_ratio": 3.0, "measurement.pressure_piston_side_offset": 2.0e5,
    "measurement.time_skew": 0.02,
}


def simulated(rig, exactly):
    run = SimulatedRig(rig, load_duty(duty_file("mixed")), 3, exactly=exactly)
    return collect(run.run(DURATION), 0, DURATION, lambda share: None)


def off(recording, rig):
    experiment = Experiment(recording, rig)
    return ratios(experiment.signals, experiment.predict(experiment.parameters(rig), 1e-3))


def test_a_twin_of_the_same_file_leaves_noise_alone():
    rig = load_rig().with_values(ERRING)
    recording = simulated(rig, exactly=True)
    assert max(off(recording, rig).values()) < 1.3
    plain = off(recording, load_rig())
    for name in ("current", "electrical_power", "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity"):
        assert plain[name] > 1.5, name


def test_a_drawn_one_is_another():
    drawn = off(simulated(load_rig(), exactly=False), load_rig())
    assert max(drawn.values()) > 3.0


@pytest.mark.parametrize("path, sensor, inner", [("measurement.surface_contact", "motor_housing", "motor_winding")])
def test_a_sensor_on_a_surface_reads_the_air_beside_it(path, sensor, inner):
    plain, beside = (simulated(rig, exactly=True) for rig in (load_rig(), load_rig().with_values({path: 0.5})))
    last = {name: np.array([r.temperatures[name].values[-20:, 0].mean() for r in (plain, beside)]) for name in (sensor, inner, "ambient")}
    air = last["ambient"][0]
    assert (last[sensor][1] - air) == pytest.approx(0.5 * (last[sensor][0] - air), abs=0.1)
    assert last[inner][1] == pytest.approx(last[inner][0], abs=0.1)


@pytest.mark.parametrize(("text", "name"), [("rig_id: press_7\n", "press_7"), ("", "simulated_3"), (None, "simulated_3")])
@pytest.mark.parametrize("exactly", [True, False])
def test_it_is_announced_by_the_name_of_its_file_else_by_its_seed(exactly, text, name, tmp_path):
    file = None if text is None else tmp_path / "rig.yaml"
    if file is not None:
        file.write_text(text + "ambient: {value: 18.0, unit: degC}\n")
    run = SimulatedRig(load_rig(file), load_duty(duty_file("mixed")), 3, exactly=exactly)
    assert run.info.rig_id == name and next(run.run(1.0)).rig.rig_id == name


def test_the_name_of_a_rig_changes_nothing_else():
    """A rig as new and worn: both files name it, and the seed still draws the same one."""
    sheet, duty = load_rig(), load_duty(duty_file("mixed"))
    plain, named = (SimulatedRig(rig, duty, 3) for rig in (sheet, replace(sheet, rig_id="press_7")))
    np.testing.assert_array_equal(plain.rig.parameters, named.rig.parameters)
    one, other = (next(run.run(1.0)) for run in (plain, named))
    np.testing.assert_array_equal(one.hydraulic.values, other.hydraulic.values)


def test_a_recording_of_another_oil_says_so_and_is_not_doubted_beside_its_rig_file():
    recording = simulated(load_rig().with_oil("ISO VG 46"), True)
    assert recording.rig.oil_grade == "ISO VG 46"
    doubted = replace(recording, findings=[Finding("warning", "bag", "/ddh/rig", "oil_grade", "ISO VG 46", 1, "another oil")])
    assert doubted.held_against("vg46").findings == [] and doubted.held_against("ISO VG 32").findings == doubted.findings
    (said,) = recording.held_against("ISO VG 68").findings
    assert "oil_grade is 'ISO VG 46', the rig file's is 'ISO VG 68'; the oil of the rig file is used" in said.message
