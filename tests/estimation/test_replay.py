"""How warm a replay begins, and goes on after a pause: what slow sensors, and sensors after a pause, tell of it."""

import numpy as np
import pytest
from ddh_twin_py.bags.damage import with_clock_jump, with_value, without_samples
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.signals import ZERO_CELSIUS
from ddh_twin_py.twin.lagged_readings import lagged

LAG, INTERVAL = 5.0, 0.05
SENSORS = ("motor_winding", "motor_housing", "tank_oil", "cylinder_barrel", "line_a", "line_b", "tank_wall")


@pytest.fixture(scope="module")
def recording(paper_cycle_bag):
    """20 s of the paper's cycle, of a unit that is 17 K warmer than the sheet assumes."""
    warm = read_recording(paper_cycle_bag).between(0.0, 20.0)
    for sensor in warm.temperatures:
        if sensor != "ambient":
            warm = with_value(warm, f"temperature/{sensor}", "temperature", 40.0 + ZERO_CELSIUS)
    return warm


def free(result, sensor):
    """Times, s, and what the sensor would read of the free run, degC."""
    return result.sensors[sensor].time, result.sensors[sensor].predicted - ZERO_CELSIUS


def test_what_a_sensor_reads_jumps_with_a_run_that_is_put_to_a_reading():
    time = INTERVAL * np.arange(1, 401)
    rising = 300.0 + 0.01 * time
    smooth = lagged(rising[:, None], rising[:1], INTERVAL, np.array([LAG]))[:, 0]
    put = lagged((rising + 5.0 * (time > 10.0))[:, None], rising[:1], INTERVAL, np.array([LAG]))[:, 0]
    assert np.abs(put - 5.0 * (time > 10.0) - smooth).max() < 1e-3
    assert smooth[-1] == pytest.approx(rising[-1] - 0.01 * LAG, abs=2e-3)  # behind a ramp by its lag


def test_a_free_run_begins_as_warm_as_slow_sensors_say(recording):
    slow = recording
    for sensor in recording.temperatures:
        slow = without_samples(slow, f"temperature/{sensor}", 0.0, 8.0)
    late = replay(slow, load_rig())
    for sensor in SENSORS:
        lag = 2.5 if sensor == "motor_winding" else 0.1  # K, by which a sensor is behind what is heated
        assert free(late, sensor)[1][0] == pytest.approx(40.0, abs=lag)
    assert late.free_temperature[0].max() < 30.0 + ZERO_CELSIUS  # nothing said so before


@pytest.mark.parametrize(("pause", "late"), [(40.0, 0.0), (20.0, 5.0), (3.0, 60.0)])
def test_after_a_pause_the_free_run_is_as_warm_as_sensors_say_at_once_or_as_is_fused_after_seconds(recording, pause, late):
    moved = recording
    for sensor in SENSORS:
        moved = with_value(moved, f"temperature/{sensor}", "temperature", 50.0 + ZERO_CELSIUS, 10.0)
    result = replay(with_clock_jump(moved, 10.0, pause), load_rig())
    time, read = free(result, "tank_oil")
    late += 10.0 + pause
    assert read[time < late] == pytest.approx(40.0, abs=1.0) and read[time > late] == pytest.approx(50.0, abs=1.0)


def test_a_clock_that_is_put_back_leaves_a_unit_as_warm_as_it_is_without_any_sensor(recording):
    blind = recording
    for sensor in SENSORS:
        blind = without_samples(blind, f"temperature/{sensor}", 5.0, 30.0)
    near, far = (replay(with_clock_jump(blind, 15.0, by), load_rig()) for by in (-3.0, -12.0))
    assert near.free_temperature[-1].min() > 38.0 + ZERO_CELSIUS and near.fused[-1].min() > 38.0 + ZERO_CELSIUS
    begun = far.free_temperature[np.flatnonzero(np.diff(far.time) < 0.0)[0] + 1]
    assert begun.max() < 41.0 + ZERO_CELSIUS
