"""While the twin runs, sensors that are out of place are told within minutes, and the filter begins again without them."""

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.place_watch import LASTING, WINDOW, PlaceWatch
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.estimation.temperature_fusion import FusionInputs, Reading, Readings, TemperatureFusion
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.intervals import INTERVAL

STEP = 40  # intervals of a call


@pytest.fixture(scope="module")
def result(paper_cycle_bag):
    return replay(read_recording(paper_cycle_bag).between(0.0, 150.0), load_rig())


def readings(result, names):
    """All readings of a replay; ``names``: sensor to the one whose connector it sits on."""
    parts = [(c.row, np.full(c.row.size, SENSORS.index(names.get(s, s))), c.measured) for s, c in result.sensors.items()]
    row, sensor, temperature = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(row, kind="stable")
    return Readings(row[order], sensor[order], temperature[order])


def watched(result, names, free=None, state=None):
    """When the watch tells something, s, and what."""
    watch, free = PlaceWatch(load_rig(), INTERVAL), result.free_temperature if free is None else free
    state = TemperatureFusion(load_rig()).state if state is None else state
    read, told = readings(result, names), []
    for start in range(0, len(free), STEP):
        if found := watch.take(free[start: start + STEP], read.between(start, start + STEP), state):
            told.append((result.time[min(start + STEP, len(free)) - 1], found))
    return told


SWAP = {"motor_winding": "tank_oil", "tank_oil": "motor_winding"}


def test_two_that_are_exchanged_are_told_once_with_the_first_window(result):
    (told,) = watched(result, SWAP)
    assert told[0] == pytest.approx(WINDOW, abs=3.0) and told[1].sensors == ("motor_winding", "tank_oil")
    assert "look exchanged" in told[1].why


def test_of_sensors_in_their_places_nothing_is_told(result):
    assert watched(result, {}) == [] and watched(result, {"line_a": "line_b", "line_b": "line_a"}) == []


def test_where_the_free_run_says_nothing_nothing_is_told(result):
    assert watched(result, SWAP, np.full_like(result.free_temperature, np.nan)) == []


def test_a_free_run_that_says_something_in_turn_is_enough(result):
    free = result.free_temperature.copy()
    free[(np.arange(len(free)) // 100) % 2 == 1] = np.nan
    assert [found.sensors for _, found in watched(result, SWAP, free)] == [("motor_winding", "tank_oil")]


def test_a_zero_that_is_far_off_is_told_once_it_lasts(result):
    state = TemperatureFusion(load_rig()).state
    state.offset[SENSORS.index("line_a")] = 6.0
    told = watched(result, {}, state=state)
    assert told[0][0] == pytest.approx(LASTING, abs=5.0) and told[0][1].sensors == ("line_a",)
    assert "held to read +6.0 K off, 20 standard deviations" in told[0][1].why


def test_zeros_of_most_that_are_far_off_are_no_ones_fault(result):
    state = TemperatureFusion(load_rig()).state
    state.offset[:5] = 6.0
    assert watched(result, {}, state=state) == []


def test_a_filter_that_leaves_sensors_out_is_as_unsure_as_at_a_start_and_uses_them_no_more():
    fusion, truth = TemperatureFusion(load_rig(), ambient=295.0), np.full(N, 315.0)
    at = NODE_INDEX["motor_winding"]
    for _ in range(60):
        lie = fusion.advance(FusionInputs.unknown(20), [Reading(2, "motor_winding", 296.0), Reading(2, "line_a", 315.0)])
    assert abs(lie.temperature[-1, at] - truth[at]) > 4.0 * lie.standard_deviation[-1, at]
    usual, air = fusion.state.usual_heat.copy(), fusion.state.ambient
    fusion.leave_out(("motor_winding",), truth)
    assert np.array_equal(fusion.state.usual_heat, usual) and fusion.state.ambient == air and fusion.state.ambient_known
    for _ in range(10):
        after = fusion.advance(FusionInputs.unknown(20), [Reading(2, "motor_winding", 296.0), Reading(2, "line_a", 315.0)])
    assert abs(after.temperature[-1, at] - truth[at]) < after.standard_deviation[-1, at]
    assert after.standard_deviation[-1, at] > 5.0 > 1.0 > after.standard_deviation[-1, NODE_INDEX["line_a"]]
    assert [i.accepted for i in after.innovations if i.sensor == "motor_winding"] == [False]
    fusion.reset()
    assert not fusion.left_out.any()
