"""The fusion: consistent, honest about what it is not told, and the same from run to run."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.consistency import JUDGED
from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading
from ddh_twin_py.estimation.fusion.state_file import StateFileError, load_state, save_state
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.estimation.replay import ReplayError, replay
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Recording, drive_stream
from ddh_twin_py.telemetry.signals import DRIVE_FIELDS
from scipy.stats import chi2
from support.simulated import simulated

SEEDS = range(5)


@pytest.fixture(scope="module")
def rig():
    return load_rig()


def test_errors_and_innovations_are_as_large_as_said(rig):
    """Rigs drawn within tolerance: errors of all nodes, whitened with their covariance, and innovations in their bands."""
    nees, squares, count = 0.0, [], 0
    for seed in SEEDS:
        recording, truth = simulated(seed)
        result = replay(recording, rig, smooth=True, covariances=True)
        row = result.smoothed_row[-1]
        assert result.time[row] == pytest.approx(240.0)  # when the truth is told
        error = (result.fused[row] - truth)[JUDGED]
        nees += error @ np.linalg.solve(result.covariance[-1][np.ix_(JUDGED, JUDGED)], error)
        z = [(i.measured - i.expected) / i.standard_deviation for i in result.innovations]
        squares.append(np.mean(np.square(z)))
        count += sum(not i.accepted for i in result.innovations)
    freedom = len(SEEDS) * JUDGED.size
    # these rigs start as warm as the air and meet no unknown heat, which is milder than the filter believes: half the lower end
    assert 0.5 * chi2.ppf(0.025, freedom) < nees < chi2.ppf(0.975, freedom), nees / freedom
    assert 0.85 < np.mean(squares) < 1.15, squares
    assert count == 0


@pytest.mark.parametrize("without", [("motor_winding",), ("motor_winding", "pump_1_case", "pump_2_case", "line_a", "line_b")])
def test_what_is_not_measured_lies_within_its_interval(rig, without):
    z = []
    for seed in SEEDS:
        recording, truth = simulated(seed)
        result = replay(recording, rig, without=without)
        hidden = [NODES.index("end_winding"), NODES.index("slot_winding"), NODES.index("pump_1_oil")]
        z += list((result.fused[-1, hidden] - truth[hidden]) / result.fused_std[-1, hidden])
    assert np.sqrt(np.mean(np.square(z))) < 1.6
    assert np.max(np.abs(z)) < 4.0


def test_fewer_sensors_never_make_it_surer(rig):
    recording, _ = simulated(0)
    full = replay(recording, rig).fused_std[-1]
    some = replay(recording, rig, without=SENSORS[:4]).fused_std[-1]
    none = replay(recording, rig, without=SENSORS).fused_std[-1]
    assert np.all(some >= full - 1e-3) and np.all(none >= some - 1e-3)
    assert np.all(none > 1.0)


def test_replay_is_the_same_to_the_last_bit(rig):
    recording, _ = simulated(1)
    first, second = replay(recording, rig), replay(recording, rig)
    for name in ("fused", "fused_std", "free_temperature", "soft", "free", "measured"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes(), name


@pytest.mark.parametrize(("sensor", "wrong"), [("motor_winding", 90.0), ("tank_oil", -40.0)])
def test_one_wrong_first_reading_is_gone_with_the_next_two(rig, sensor, wrong):
    fusion, true = TemperatureFusion(rig, ambient=298.15), TemperatureFusion(rig, ambient=298.15)
    spread = []
    for second in range(20):
        value = wrong + 273.15 if second == 0 else 298.15 + 0.01 * second
        result = fusion.advance(FusionInputs.unknown(20), [Reading(2, sensor, value)])
        spread.append(result.standard_deviation[-1, NODE_INDEX[sensor]])
        known = true.advance(FusionInputs.unknown(20), [Reading(2, sensor, value)] if second else [])
    assert spread[5] < 0.5 * spread[0]  # it is no more than a hint until the next agrees
    off = result.temperature[-1] - known.temperature[-1]
    assert abs(off[NODE_INDEX[sensor]]) < 0.2 and np.all(np.abs(off) < 2.0 * known.standard_deviation[-1] + 0.2)


@pytest.mark.parametrize("away", [900.0, 3600.0])
def test_one_wrong_reading_after_a_rest_is_gone_with_the_next_two(rig, away):
    fusion = TemperatureFusion(rig, ambient=298.15)
    at = NODE_INDEX["motor_winding"]
    for _ in range(30):
        fusion.advance(FusionInputs.unknown(20), [Reading(2, "motor_winding", 310.0)])
    fusion.restore(fusion.state, away)
    for value in (363.15, *np.linspace(305.0, 304.0, 12)):
        result = fusion.advance(FusionInputs.unknown(20), [Reading(2, "motor_winding", value)])
    assert result.temperature[-1, at] == pytest.approx(305.0, abs=2.0)


def test_of_a_sensor_that_says_two_things_in_turn_the_first_is_believed(rig):
    fusion = TemperatureFusion(rig, ambient=298.15)
    for second in range(40):
        value = 363.15 if second % 2 else 300.0
        result = fusion.advance(FusionInputs.unknown(20), [Reading(2, "tank_oil", value)])
    assert result.temperature[-1, NODE_INDEX["tank_oil"]] == pytest.approx(300.0, abs=1.0)
    assert not any(i.accepted for i in result.innovations)


def test_a_first_reading_that_the_next_confirms_is_taken_however_far_off(rig):
    fusion = TemperatureFusion(rig, ambient=298.15)
    for value in (390.0, 390.2):
        result = fusion.advance(FusionInputs.unknown(20), [Reading(2, "motor_winding", value)])
    assert result.temperature[-1, NODE_INDEX["motor_winding"]] == pytest.approx(390.0, abs=1.0)


def test_models_gone_the_uncertainty_grows(rig):
    fusion = TemperatureFusion(rig, ambient=293.15)
    recording, _ = simulated(2)
    base = replay(recording, rig)
    fusion.state.covariance[:] *= 0.01
    before = fusion.advance(FusionInputs.unknown(20)).standard_deviation[-1]
    after = fusion.advance(FusionInputs.unknown(20 * 60)).standard_deviation[-1]
    ratio = dict(zip(NODES, after / before, strict=True))
    # where nothing is known to be heated, the tank's wall and the layers of its oil average their doubts
    tank = {"tank_wall", "tank_oil", "tank_oil_top"}
    assert {node for node in NODES if ratio[node] <= 1.0} <= tank and min(ratio[node] for node in tank) > 0.95, ratio
    assert after[NODES.index("slot_winding")] > 5.0 > base.fused_std[-1, NODES.index("slot_winding")]


@pytest.mark.parametrize(("first_air", "told_until"), [(0, 120), (13, 120), (47, 120), (0, 70)])
def test_how_intervals_are_dealt_out_to_calls_does_not_matter(rig, first_air, told_until):
    """Also not while the air and the first readings come in, which live nodes get in pieces of any size, nor once telemetry has stopped."""
    n = 120
    air = np.where(np.arange(n) % 20 == first_air % 20, 287.0 + 0.01 * np.arange(n), np.nan)
    air[:first_air] = np.nan
    readings = [Reading(k + i, s, 290.0 + 3.0 * i) for i, s in enumerate(SENSORS) for k in range(5, n - len(SENSORS), 20)]

    def estimate(size):
        fusion, rows = TemperatureFusion(rig), []
        for start in range(0, n, size):
            inputs = FusionInputs.unknown(min(size, n - start))
            inputs.heat[:] = 30.0
            inputs.hydraulics_known[:] = inputs.motor_known[:] = np.arange(start, start + len(inputs)) < told_until
            inputs.ambient[:] = air[start: start + size]
            now = [Reading(r.index - start, r.sensor, r.temperature) for r in readings if start <= r.index < start + size]
            result = fusion.advance(inputs, now)
            rows.append(np.hstack([result.temperature, result.standard_deviation, result.ambient[:, None]]))
        return np.vstack(rows)

    whole = estimate(n)
    assert np.ptp(whole[:, 0]) > 1.0  # the readings and the air moved it
    for size in (1, 7, 20, 50):
        np.testing.assert_allclose(estimate(size), whole, rtol=0.0, atol=1e-9)


def test_sensors_alone_are_followed(rig):
    fusion = TemperatureFusion(rig, ambient=293.15)
    for _ in range(120):
        readings = [Reading(10, "motor_housing", 330.0), Reading(10, "tank_oil", 315.0)]
        result = fusion.advance(FusionInputs.unknown(20), readings)
    for node, value in (("housing", 330.0), ("tank_oil", 315.0)):
        at = NODES.index(node)
        assert abs(result.temperature[-1, at] - value) < 3 * result.standard_deviation[-1, at] < 3.0


def test_a_wild_reading_is_refused_and_a_shifted_sensor_is_lived_with(rig):
    recording, truth = simulated(3)
    values = recording.temperatures["tank_oil"].values.copy()
    values[200, 0] += 40.0
    values[300:, 0] += 2.0  # the sensor came loose; by more it would be left out
    import dataclasses
    stream = dataclasses.replace(recording.temperatures["tank_oil"], values=values)
    broken = dataclasses.replace(recording, temperatures={**recording.temperatures, "tank_oil": stream})
    result = replay(broken, rig)
    refused = [i for i in result.innovations if not i.accepted]
    assert {i.sensor for i in refused} == {"tank_oil"} and len(refused) >= 2
    at = NODES.index("tank_oil")
    assert abs(result.fused[-1, at] - truth[at]) < 4 * result.fused_std[-1, at]
    assert result.fused_std[-1, at] > replay(recording, rig).fused_std[-1, at]


def test_state_survives_and_ages(rig, tmp_path):
    recording, _ = simulated(0)
    fusion = TemperatureFusion(rig, ambient=293.15)
    fusion.advance(FusionInputs.unknown(40), [Reading(i, s, 330.0) for i in range(0, 40, 10) for s in SENSORS])
    spread = np.sqrt(np.diagonal(fusion.state.covariance)[: len(NODES)])
    save_state(tmp_path / "state.npz", fusion.state, "rig_7", 123_000_000_000)
    again = TemperatureFusion(rig, ambient=293.15)
    saved = load_state(tmp_path / "state.npz", again.state)
    assert (saved.rig_id, saved.stamp_ns) == ("rig_7", 123_000_000_000)
    np.testing.assert_array_equal(saved.state.covariance, fusion.state.covariance)
    again.restore(saved.state, age=600.0)
    after = np.sqrt(np.diagonal(again.state.covariance)[: len(NODES)])
    read = list(NODE_INDEX.values())  # what was known well is known less, and nothing is known better
    assert np.all(after[read] > spread[read]) and np.all(after > 0.999999 * spread)
    assert again.state.dynamic[NODES.index("housing")] < fusion.state.dynamic[NODES.index("housing")]  # it cooled
    assert again.state.dynamic[NODES.index("housing")] > 315.0  # and is not cold


@pytest.mark.parametrize("age", [0.0, 0.05, 1.0, 60.0, 600.0])
def test_a_pause_makes_no_estimate_surer(rig, age):
    worked, told = TemperatureFusion(rig, ambient=293.15), np.ones(400, dtype=bool)
    heat = replace(FusionInputs.unknown(400), heat=np.full((400, len(NODES)), 20.0), hydraulics_known=told, motor_known=told)
    worked.advance(heat, [Reading(i, s, 300.0) for i in range(0, 400, 20) for s in SENSORS])
    before = worked.state.covariance.copy()
    worked.rest(age)
    after = worked.state.covariance
    warm = len(NODES) + len(SENSORS)
    assert (np.sqrt(np.diagonal(after)[:warm]) > (1.0 - 1e-9) * np.sqrt(np.diagonal(before)[:warm])).all()
    np.testing.assert_array_equal(after, after.T)
    assert np.linalg.eigvalsh(after).min() > -1e-9


def test_a_working_unit_that_was_unseen_may_be_warmer_by_its_readings_too(rig):
    """Its heat comes to the lagged reading within seconds, so that the first reading is not refused or taken for too much."""
    fusion = TemperatureFusion(rig, ambient=293.15)
    fusion.advance(FusionInputs.unknown(40), [Reading(i, s, 330.0) for i in range(0, 40, 10) for s in SENSORS])
    node, reading = NODES.index("end_winding"), len(NODES) + SENSORS.index("motor_winding")
    fusion.rest(28.0)
    spread = np.sqrt(np.diagonal(fusion.state.covariance))
    assert spread[node] > 3.0 and spread[reading] > 0.7 * spread[node]


@pytest.mark.parametrize("days", [2, 5, 20])
def test_a_unit_that_stood_for_days_is_as_warm_as_the_air_and_no_more_is_known(rig, days):
    fusion = TemperatureFusion(rig, ambient=293.15)
    fusion.advance(FusionInputs.unknown(40), [Reading(i, s, 330.0) for i in range(0, 40, 10) for s in SENSORS])
    fusion.rest(days * 86400.0)
    covariance = fusion.state.covariance
    assert np.isfinite(covariance).all() and np.linalg.eigvalsh(covariance).min() > -1e-9
    np.testing.assert_allclose(fusion.state.dynamic, 293.15, atol=0.3)
    assert 2.0 < np.sqrt(covariance[NODES.index("tank_oil"), NODES.index("tank_oil")]) < 30.0


def test_state_file_that_is_none(rig, tmp_path):
    like = TemperatureFusion(rig).state
    assert load_state(tmp_path / "none.npz", like) is None
    for name, content in (("text.npz", b"hello"), ("empty.npz", b"")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(StateFileError, match=name):
            load_state(tmp_path / name, like)
    broken = TemperatureFusion(rig).state
    broken.dynamic[0] = np.nan
    save_state(tmp_path / "nan.npz", broken, "rig", 0)
    with pytest.raises(StateFileError, match="dynamic"):
        load_state(tmp_path / "nan.npz", like)


def test_without_drive_telemetry_there_is_nothing_to_replay(rig):
    with pytest.raises(ReplayError, match="drive/telemetry"):
        replay(Recording("somewhere", 0, None, None, None), rig)


def test_with_drive_telemetry_of_which_nothing_is_measured_there_is_nothing_to_replay(rig):
    def drive(**known):
        values = np.full((200, len(DRIVE_FIELDS)), np.nan)
        for name, value in known.items():
            values[:, DRIVE_FIELDS.index(name)] = value
        return Recording("somewhere", 10**18, None, drive_stream(np.arange(200) * 0.01, values), None, namespace="/ddh")

    said = "somewhere: /ddh/drive/telemetry speed_command, speed, current: NaN or refused in all of 200 messages; the twin needs at least"
    with pytest.raises(ReplayError, match=said):
        replay(drive(voltage=300.0), rig)
    assert len(replay(drive(speed=3.0), rig).time)


@pytest.mark.parametrize(("epoch", "time", "said"), [
    (10**18, [0.0], "somewhere: /ddh/drive/telemetry lasts 0 s; at least 0.2 s are needed"),
    (10**18, [0.0, 0.1], "lasts 0.1 s; at least 0.2 s are needed"),
    (0, [0.0, 0.0, 0.0], "lasts 0 s, as all stamps are 0: nobody set header.stamp; at least"),
])  # fmt: skip
def test_what_lasts_no_time_is_not_replayed(rig, epoch, time, said):
    drive = drive_stream(np.array(time), np.ones((len(time), len(DRIVE_FIELDS))))
    with pytest.raises(ReplayError, match=said):
        replay(Recording("somewhere", epoch, None, drive, None, namespace="/ddh"), rig)


def test_paper_cycle_agrees(rig, paper_cycle_bag):
    """The recording of the nominal rig: temperatures within the noise, the hidden winding within its interval."""
    from ddh_twin_py.bags.reader import read_recording

    recording = read_recording(paper_cycle_bag)
    result = replay(recording, rig)
    for name, sensor in result.sensors.items():
        assert np.sqrt(np.nanmean((sensor.measured - sensor.predicted) ** 2)) < 0.4, name
    blind = replay(recording, rig, without=("motor_winding",)).sensors["motor_winding"]
    error = blind.measured - blind.fused
    assert np.sqrt(np.nanmean(error**2)) < blind.fused_std[-1]


def test_it_may_start_on_a_hot_machine(rig, paper_cycle_bag):
    """From the middle of a recording, winding 25 K above the rest."""
    from ddh_twin_py.bags.reader import read_recording

    result = replay(read_recording(paper_cycle_bag).between(200.0, 290.0), rig)
    assert all(i.accepted for i in result.innovations)
    for name, sensor in result.sensors.items():
        late = sensor.time > sensor.time[0] + 10.0
        assert np.sqrt(np.nanmean((sensor.measured - sensor.fused)[late] ** 2)) < 0.5, name
