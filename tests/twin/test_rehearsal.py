"""A rehearsal is a recording that the twin's own free run explains to its noise."""

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import DutyError, parse_duty
from ddh_twin_py.twin.rehearsal import rehearse
from ddh_twin_py.twin.simulated_rig import SimulatedRig

DUTY = """
payload_kg: 180
ambient_degC: [[0, 15.0], [60, 18.0]]
start_position_m: 0.1
repeat: {repeat}
cycle:
  - lift: {{speed_rpm: 700, to_m: 0.25}}
  - dwell: {{duration_s: 1}}
  - lower: {{speed_rpm: 400, to_m: 0.1}}
  - dwell: {{duration_s: 2}}
"""


def duty(repeat=0):
    return parse_duty(DUTY.format(repeat=repeat))


def test_the_free_run_explains_it_to_its_noise():
    rig = load_rig()
    experiment = Experiment(rehearse(rig, duty(), 60.0), rig)
    predicted = experiment.predict(experiment.parameters(rig))
    assert experiment.payload == 180.0
    assert not [str(f) for f in experiment.recording.findings if f.severity != "info"]
    for name, signal in experiment.signals.items():
        used = signal.binning.bin >= 0
        ratio = np.sqrt(np.nanmean((signal.measured - predicted[name])[used] ** 2)) / signal.noise
        assert ratio < 1.35, name


def test_what_is_not_there_is_not_recorded():
    recording = rehearse(load_rig(), duty(), 30.0, ["tank_oil"], pressures=False)
    assert list(recording.temperatures) == ["ambient", "tank_oil"]
    assert np.isnan(recording.hydraulic.column("pressure_piston_side")).all()
    assert np.isfinite(recording.hydraulic.column("rod_position")).all()


def test_ambient_and_start_are_those_asked_for():
    rig = load_rig()
    cold = rehearse(rig, duty(), 40.0)
    start = np.full(cold_nodes(), 320.0)
    warm = rehearse(rig, duty(), 40.0, start=start)
    noise = rig.sensors["temperature"].noise
    assert warm.temperatures["tank_oil"].values[0, 0] == pytest.approx(320.0, abs=6 * noise)
    assert cold.temperatures["tank_oil"].values[0, 0] == pytest.approx(288.15, abs=6 * noise)
    assert cold.temperatures["ambient"].values[-1, 0] == pytest.approx(288.15 + 3.0 * 39.0 / 60.0, abs=6 * noise)


def test_a_table_of_the_air_that_begins_before_the_start_says_how_warm_that_is():
    told = parse_duty(DUTY.format(repeat=0).replace("[0, 15.0]", "[-1000, 0.0], [0, 15.0]"))
    simulated = SimulatedRig(load_rig(), told, 3)
    next(iter(simulated.run(5.0)))
    assert simulated.truth() == pytest.approx(288.15, abs=3.0)
    assert rehearse(load_rig(), told, 2.0).temperatures["tank_oil"].values[0, 0] == pytest.approx(288.15, abs=1.0)


def cold_nodes():
    from ddh_twin_py.physics.thermal_network import N

    return N


def test_a_duty_ends_where_it_says_or_is_refused():
    rig = load_rig()
    once, twice = (rehearse(rig, duty(n)).drive.time[-1] for n in (1, 2))
    assert twice == pytest.approx(2.0 * once, rel=0.05)
    with pytest.raises(DutyError, match="repeat is 0, for ever"):
        rehearse(rig, duty())
    for duration in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(DutyError, match="duration of the rehearsal is .* s, it must be above 0"):
            rehearse(rig, duty(), duration)
