"""Sensors that read each other's places, or are far off their zero, are named beside what the filter made of them."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.out_of_place import out_of_place
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.rig import load_rig


@pytest.fixture(scope="module")
def minute(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 60.0)


def exchanged(recording, one, two):
    read = recording.temperatures
    return replace(recording, temperatures={**read, one: read[two], two: read[one]})


def test_two_that_read_each_others_places_look_exchanged(minute):
    said = out_of_place(replay(exchanged(minute, "motor_winding", "tank_oil"), load_rig()))
    assert said.startswith("temperature/motor_winding and temperature/tank_oil look exchanged, as each reads what the free run shows of")


def test_sound_ones_and_two_that_read_alike_are_in_their_places(minute):
    assert out_of_place(replay(minute, load_rig())) == ""
    assert out_of_place(replay(exchanged(minute, "line_a", "line_b"), load_rig())) == ""


def test_one_that_comes_off_is_far_off_its_zero_and_not_exchanged(minute):
    tank = minute.temperatures["tank_oil"]
    drifts = replace(tank, values=tank.values + np.outer(np.minimum(tank.time / 5.0, 9.0), [1.0, 0.0]))
    result = replay(replace(minute, temperatures={**minute.temperatures, "tank_oil": drifts}), load_rig())
    assert result.zero_error[0] == "tank_oil" and result.zero_error[1] > 10.0
    assert out_of_place(result).startswith("temperature/tank_oil is held to read +")
    assert "standard deviations of its zero error; what is fused near it may be off" in out_of_place(result)


def test_one_that_is_a_few_deviations_off_is_no_doubt(minute):
    result = replay(minute, load_rig())
    assert out_of_place(replace(result, zero_error=("tank_oil", 9.0, 2.7))) == ""


@pytest.mark.filterwarnings("error")
def test_a_place_of_which_the_free_run_shows_nothing_tells_nothing(minute):
    result = replay(exchanged(minute, "motor_winding", "tank_oil"), load_rig())
    blind = replace(result.sensors["tank_oil"], predicted=np.full(result.sensors["tank_oil"].time.size, np.nan))
    assert out_of_place(replace(result, sensors={**result.sensors, "tank_oil": blind}, zero_error=None)) == ""
