"""Sensors whose errors the rig file knows: what is compared with the model is what it would be without them."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.cli.simulated import collect
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.duty_file import duty_file
from ddh_twin_py.twin.sensor_errors import delay_ns, take_off_air, take_off_delay, temperature_noise, temperature_zero_errors
from ddh_twin_py.twin.simulated_rig import SimulatedRig
from ddh_twin_py.twin.temperature_sensors import SENSORS
from support.erring import ERRORS, erring


@pytest.fixture(scope="module")
def plain(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 30.0)


def test_known_errors_change_nothing_that_is_compared(plain):
    rig = load_rig()
    base, known = replay(plain, rig), replay(erring(plain), rig.with_values(ERRORS))
    unknown = replay(erring(plain), rig)
    assert base.time.size == known.time.size
    for name in ("current", "current_square", "torque", "electrical_power", "rod_position", "rod_velocity", "pressure_piston_side"):
        a, b = base.measured[name], known.measured[name]
        size = np.nanmax(np.abs(a))
        assert np.nanmax(np.abs(b - a)) < 1e-9 * size, name
        if name != "pressure_piston_side":
            assert np.nanmax(np.abs(unknown.measured[name][: a.size] - a)) > 0.1 * size, name
    assert np.abs(known.fused - base.fused).max() < 1e-6
    np.testing.assert_allclose(known.soft["torque"], base.soft["torque"], atol=1e-9)


def test_the_skew_is_of_the_hydraulic_stream_alone(plain):
    rig = load_rig().with_values({"measurement.time_skew": 0.02})
    assert (delay_ns(rig, DRIVE_TOPIC), delay_ns(rig, HYDRAULIC_TOPIC)) == (0, 20_000_000)
    shifted = take_off_delay(plain, rig)
    np.testing.assert_allclose(shifted.hydraulic.time, plain.hydraulic.time - 0.02, atol=1e-12)
    assert shifted.drive is plain.drive and take_off_delay(plain, load_rig()) is plain
    alone = replace(plain, hydraulic=None)
    assert take_off_delay(alone, rig) is alone


POOR = {"measurement.surface_contact": 0.3, "measurement.surface_lag_ratio": 6.0, "surroundings.enclosure_rise": 3.0}


@pytest.fixture(scope="module")
def poorly_attached():
    rig = load_rig().with_values(POOR)
    return rig, collect(SimulatedRig(rig, load_duty(duty_file("mixed")), 3, exactly=True).run(300.0), 0, 300.0, lambda share: None)


def furthest(result, of):
    """The largest RMS of a sensor's reading less ``of`` it, in noises, after a minute."""
    late = {name: c.time > 60.0 for name, c in result.sensors.items()}
    return max(np.sqrt(np.nanmean((c.measured - getattr(c, of))[late[name]] ** 2)) / c.noise for name, c in result.sensors.items())


def test_replay_counts_on_how_sensors_touch_their_surfaces(poorly_attached):
    rig, recording = poorly_attached
    known = replay(recording, rig)
    assert furthest(known, "predicted") < 1.6
    assert furthest(known, "fused") < 1.6
    for path in POOR:
        other = replay(recording, rig.with_values({path: load_rig()[path]}))
        assert furthest(other, "predicted") > 2.5, path


def test_the_fusion_finds_what_the_surfaces_have_and_not_what_is_read(poorly_attached):
    rig, recording = poorly_attached
    known = replay(recording, rig)
    oil, wall = (NODES.index(name) for name in ("tank_oil", "tank_wall"))
    truth = known.free_temperature[-1]
    for node in (oil, wall, NODES.index("housing"), NODES.index("pump_1_case")):
        assert abs(known.fused[-1, node] - truth[node]) < 4.0 * known.fused_std[-1, node] + 0.05, NODES[node]
        assert known.fused_std[-1, node] < 1.0
    read = recording.temperatures["pump_1_case"].values[-5:, 0].mean()
    assert known.fused[-1, NODES.index("pump_1_case")] - read > 0.4  # of 0.6 K; a sensor's noise is 0.1 K


def test_a_sensor_that_reads_the_air_is_noisier_of_its_surface():
    rig = load_rig().with_values({"measurement.surface_contact": 0.5, "measurement.line_a_offset": 0.4})
    inner, outer = SENSORS.index("tank_oil"), SENSORS.index("line_a")
    noise = rig.sensors["temperature"].noise
    assert temperature_noise(rig)[[inner, outer]] == pytest.approx([noise, 2.0 * noise])
    assert temperature_zero_errors(rig)[0][[inner, outer]] == pytest.approx([0.0, 0.8])
    readings = np.array([320.0, 320.0])
    assert take_off_air(readings, np.array([inner, outer]), 300.0, rig) == pytest.approx([320.0, 340.0])
