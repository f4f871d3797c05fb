"""Sensors that read each other's places, or are far off their zero, are named beside what the filter made of them."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.doubts.out_of_place import far_off_zero
from ddh_twin_py.estimation.left_out import out_of_place
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.sensors import NODE_INDEX
from ddh_twin_py.rig import load_rig

_OF_OIL = ("tank_oil", "tank_wall", "line_a", "line_b")


@pytest.fixture(scope="module")
def minute(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 60.0)


def exchanged(recording, one, two):
    read = recording.temperatures
    return replace(recording, temperatures={**read, one: read[two], two: read[one]})


def test_two_that_read_each_others_places_look_exchanged(minute):
    said = out_of_place(replay(exchanged(minute, "motor_winding", "tank_oil"), load_rig()))
    assert said.startswith("temperature/motor_winding and temperature/tank_oil look exchanged, as each reads what the free run shows of")


@pytest.mark.parametrize("pair", [("motor_winding", "tank_oil"), ("motor_winding", "motor_housing"), ("pump_1_case", "motor_winding")])
def test_two_that_are_exchanged_are_left_out_and_the_band_holds_the_truth(minute, pair):
    truth, result = replay(minute, load_rig()), replay(exchanged(minute, *pair), load_rig(), smooth=True)
    assert {name for name, sensor in result.sensors.items() if not sensor.used} == set(pair)
    assert set(result.left_out[0].sensors) == set(pair) and len(result.left_out) == 1
    assert np.all(np.abs(result.fused[-1] - truth.fused[-1]) < 2.0 * result.fused_std[-1])
    at = NODE_INDEX["motor_winding"]
    assert result.fused_std[-1, at] > 5.0 * truth.fused_std[-1, at]
    assert "neither is used: what is fused is of the models and the other sensors" in out_of_place(result)
    assert out_of_place(result).count("look exchanged") == 1
    assert np.abs(result.smoothed[-1, at] - truth.fused[-1, at]) < 2.0 * result.smoothed_std[-1, at]


def test_of_sensors_in_their_places_none_is_left_out(minute):
    assert replay(minute, load_rig()).left_out == () and replay(minute, load_rig(), without=("tank_oil",)).left_out == ()


def test_sound_ones_and_two_that_read_alike_are_in_their_places(minute):
    assert out_of_place(replay(minute, load_rig())) == ""
    assert out_of_place(replay(exchanged(minute, "line_a", "line_b"), load_rig())) == ""


def test_one_that_comes_off_is_far_off_its_zero_and_left_out_and_not_exchanged(minute):
    tank = minute.temperatures["tank_oil"]
    drifts = replace(tank, values=tank.values + np.outer(np.minimum(tank.time / 5.0, 9.0), [1.0, 0.0]))
    result = replay(replace(minute, temperatures={**minute.temperatures, "tank_oil": drifts}), load_rig())
    assert [found.sensors for found in result.left_out] == [("tank_oil",)] and not result.sensors["tank_oil"].used
    assert out_of_place(result).startswith("temperature/tank_oil is held to read +")
    assert "standard deviations of its zero error; it is not used: what is fused is of the models" in out_of_place(result)
    truth = replay(minute, load_rig())
    assert np.all(np.abs(result.fused[-1] - truth.fused[-1]) < 2.0 * result.fused_std[-1])


def test_one_of_which_only_noise_is_left_stands_still_and_is_left_out(paper_cycle_bag):
    recording = read_recording(paper_cycle_bag)
    winding = recording.temperatures["motor_winding"]
    noise = 0.1 * np.random.default_rng(0).standard_normal(len(winding))
    values = np.column_stack([winding.values[:, 0].mean() + noise, winding.values[:, 1]])
    still = replace(recording, temperatures={**recording.temperatures, "motor_winding": replace(winding, values=values)})
    result, truth = replay(still, load_rig()), replay(recording, load_rig())
    assert truth.left_out == () and [found.sensors for found in result.left_out] == [("motor_winding",)]
    assert out_of_place(result).startswith("temperature/motor_winding stands still while its place must move, and was up to 1")
    assert np.all(np.abs(result.fused - truth.fused) < 2.0 * result.fused_std)


def test_a_calibrated_one_that_is_little_off_is_told_and_still_used(minute):
    """Its zero is known to 0.02 K, of which 1 K is much, and of the sheet's tolerance of 0.3 K is not."""
    assert far_off_zero(("tank_oil", 50.0, 1.0), load_rig()) is None
    assert far_off_zero(("tank_oil", 50.0, 4.0), load_rig()).sensors == ("tank_oil",)
    assert "may be off by more than is stated" in out_of_place(replace(replay(minute, load_rig()), zero_error=("tank_oil", 50.0, 1.0)))


def test_where_half_of_them_are_far_off_it_is_not_they_that_lie(minute):
    """A unit that was warmed while nobody looked: all are used, however far the filter holds their zeros off."""
    warmer = {name: replace(stream, values=stream.values + np.outer(8.0 * (stream.time > 30.0), [1.0, 0.0])) if name in _OF_OIL else stream
              for name, stream in minute.temperatures.items()}
    result = replay(replace(minute, temperatures=warmer), load_rig())
    assert abs(result.zero_error[1]) > 10.0
    assert result.left_out == () and all(sensor.used for sensor in result.sensors.values())
    assert "what is fused near it may be off by more than is stated" in out_of_place(result)


def test_one_that_is_a_few_deviations_off_is_no_doubt(minute):
    result = replay(minute, load_rig())
    assert out_of_place(replace(result, zero_error=("tank_oil", 9.0, 2.7))) == ""


@pytest.mark.filterwarnings("error")
def test_a_place_of_which_the_free_run_shows_nothing_tells_nothing(minute):
    result = replay(exchanged(minute, "motor_winding", "tank_oil"), load_rig())
    blind = replace(result.sensors["tank_oil"], predicted=np.full(result.sensors["tank_oil"].time.size, np.nan))
    assert out_of_place(replace(result, sensors={**result.sensors, "tank_oil": blind}, zero_error=None, left_out=())) == ""
