"""While the twin runs, sensors that are out of place are told within minutes, and the filter begins again without them."""

from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.doubts.agrees_again import AGREES, AgreesAgain
from ddh_twin_py.estimation.doubts.place_watch import LASTING, WINDOW, PlaceWatch
from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading, Readings, air_of
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
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
    line = replace(result.sensors["line_a"], measured=result.sensors["line_a"].measured + 6.0)
    told = watched(replace(result, sensors={**result.sensors, "line_a": line}), {}, state=state)
    assert told[0][0] == pytest.approx(LASTING, abs=5.0) and told[0][1].sensors == ("line_a",)
    assert "held to read +6.0 K off, 20 standard deviations" in told[0][1].why


def test_zeros_of_most_that_are_far_off_are_no_ones_fault(result):
    state = TemperatureFusion(load_rig()).state
    state.offset[:5] = 6.0
    assert watched(result, {}, state=state) == []


def moved(recording, sensor, by):
    """The recording, in which a sensor reads so many K more, of its times, s."""
    stream = recording.temperatures[sensor]
    values = stream.values + np.outer(by(stream.time), [1.0, 0.0])
    return replace(recording, temperatures={**recording.temperatures, sensor: replace(stream, values=values)})


def with_exchanged(recording, one, other, since=0.0, until=np.inf):
    """Two sensors exchanged from s to s."""
    read = dict(recording.temperatures)
    a, b = read[one], read[other]
    for name, own, theirs in ((one, a, b), (other, b, a)):
        values = np.interp(own.time, theirs.time, theirs.values[:, 0])
        meanwhile = (own.time >= since) & (own.time < until)
        read[name] = replace(own, values=np.column_stack([np.where(meanwhile, values, own.values[:, 0]), own.values[:, 1]]))
    return replace(recording, temperatures=read)


def live(truth, recording):
    """What is fused and its deviations where sensors are left out and used again as the node does it, and what was told when, s.

    The models are those of the sound recording, as they hardly follow the sensors.
    """
    rig = load_rig()
    fusion, watch, again = TemperatureFusion(rig), PlaceWatch(rig, INTERVAL), AgreesAgain(rig, INTERVAL)
    read_all = [Reading(int(row), name, float(value)) for name, stream in recording.temperatures.items()
                for row, value in zip(np.searchsorted(truth.time, stream.time), stream.values[:, 0], strict=True)]
    said, rows, spreads = [], [], []
    for start in range(0, truth.time.size, STEP):
        part = slice(start, min(start + STEP, truth.time.size))
        read = [replace(reading, index=reading.index - start) for reading in read_all if part.start <= reading.index < part.stop]
        air = air_of(read, part.stop - start)
        result = fusion.advance(FusionInputs(*(column[part] for column in truth.given)), read)
        rows.append(result.temperature)
        spreads.append(result.standard_deviation)
        surface = Readings.of(read)
        for back in again.take(surface, air, result):
            watch.told.remove(back)
            fusion.use_again(back.sensors)
            said.append((truth.time[part.stop - 1], "back", back.sensors))
        if found := watch.take(truth.free_temperature[part], surface, fusion.state, air):
            fusion.leave_out(found.sensors, truth.free_temperature[part.stop - 1], watch.air)
            said.append((truth.time[part.stop - 1], "out", found.sensors))
            if found.sensors:
                again.follow(found)
    return np.concatenate(rows), np.concatenate(spreads), said


@pytest.fixture(scope="module")
def whole(paper_cycle_bag):
    """The cycle and what the models make of it."""
    recording, given = read_recording(paper_cycle_bag), []
    advance = TemperatureFusion.advance
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(TemperatureFusion, "advance", lambda self, inputs, read: given.append(inputs) or advance(self, inputs, read))
        truth = replay(recording, load_rig())
    columns = (np.concatenate([getattr(inputs, entry.name) for inputs in given]) for entry in fields(FusionInputs))
    return recording, SimpleNamespace(**vars(truth), given=tuple(columns))


AT = NODE_INDEX["motor_winding"]


def test_air_and_winding_that_are_exchanged_are_told_within_a_minute_and_used_again_once_put_right(whole):
    recording, truth = whole
    fused, spread, said = live(truth, with_exchanged(recording, "ambient", "motor_winding", until=60.0))
    (out, _, sensors), (back, word, _) = said
    assert sensors == ("ambient", "motor_winding") and out < 45.0 and word == "back" and 60.0 + AGREES < back < 60.0 + 2.0 * AGREES
    off, sure = np.abs(fused - truth.fused), spread
    assert np.all(off[1200:] < 2.0 * sure[1200:]) and sure[-1, AT] < 0.5


def test_an_exchange_that_ended_before_it_was_told_leaves_no_filter_that_doubts_the_winding(whole):
    recording, truth = whole
    fused, spread, said = live(truth, with_exchanged(recording, "ambient", "motor_winding", until=20.0))
    assert [entry[1:] for entry in said] == [("out", ())] and said[0][0] < 60.0
    assert np.all(np.abs(fused - truth.fused)[1400:] < 2.5 * spread[1400:])


def test_a_sensor_that_was_off_for_a_while_is_used_again(whole):
    recording, truth = whole
    fused, spread, said = live(truth, moved(recording, "motor_winding", lambda t: 13.0 * ((t > 30.0) & (t < 130.0))))
    assert [entry[1:] for entry in said] == [("out", ("motor_winding",)), ("back", ("motor_winding",))]
    assert said[1][0] > 130.0 + AGREES and abs(fused[-1, AT] - truth.fused[-1, AT]) < 2.0 * spread[-1, AT] < 1.0


def test_one_that_was_believed_from_the_start_and_jumps_is_not_used_though_others_were_bent_to_it(whole):
    recording, truth = whole
    fused, spread, said = live(truth, moved(recording, "tank_oil", lambda t: np.where(t < 130.0, 13.0, -4.0)))
    assert [entry[1:] for entry in said] == [("out", ("tank_oil",))] and said[0][0] == pytest.approx(130.0 + LASTING, abs=15.0)
    assert np.all(np.abs(fused - truth.fused)[-1] < 2.0 * spread[-1])


@pytest.mark.parametrize(("other", "since"), [("motor_housing", 30.0), ("motor_housing", 100.0), ("line_a", 100.0)])
def test_of_two_that_are_exchanged_within_a_window_neither_is_believed_in_the_end(whole, other, since):
    recording, truth = whole
    fused, spread, said = live(truth, with_exchanged(recording, "motor_winding", other, since))
    assert said[-1][1:] == ("out", tuple(sorted(("motor_winding", other), key=SENSORS.index)))
    assert abs(fused[-1, AT] - truth.fused[-1, AT]) < 2.0 * spread[-1, AT] < 40.0


def test_of_two_that_are_exchanged_the_other_is_not_believed_once_one_is_left_out(whole):
    recording, truth = whole
    fused, spread, said = live(truth, with_exchanged(recording, "motor_winding", "tank_oil", 20.0))
    assert [entry[1:] for entry in said] == [("out", ("motor_winding", "tank_oil"))] and said[0][0] < 100.0
    after = truth.time > said[0][0] + 1.0
    assert np.all(np.abs(fused - truth.fused)[after, AT] < 2.5 * spread[after, AT])


@pytest.mark.parametrize("kept", [2.0, 5.0])
def test_a_sensor_that_keeps_an_error_of_its_own_is_not_used_again(whole, kept):
    recording, truth = whole
    odd = moved(recording, "motor_winding", lambda t: np.where(t > 30.0, np.where(t < 130.0, 13.0, kept), 0.0))
    assert [entry[1] for entry in live(truth, odd)[2]] == ["out"]


@pytest.mark.parametrize("by", [lambda t: 13.0 * (t > 30.0), lambda t: np.where(t > 20.0, np.maximum(t - 100.0, 0.0) / 10.0 - 15.0, 0.0)])
def test_a_broken_one_that_crosses_the_estimate_or_stays_where_it_is_is_not(whole, by):
    recording, truth = whole
    assert [entry[1] for entry in live(truth, moved(recording, "motor_winding", by))[2]] == ["out"]


def first_read(recording, sensor, since):
    """The recording, in which a sensor says nothing before s."""
    stream = recording.temperatures[sensor]
    spoken = stream.time >= since
    silent = replace(stream, time=stream.time[spoken], values=stream.values[spoken])
    return replace(recording, temperatures={**recording.temperatures, sensor: silent})


@pytest.mark.parametrize(("sensor", "by", "since"), [
    ("motor_winding", -12.0, 0.0), ("motor_winding", -12.0, 120.0), ("motor_winding", -25.0, 120.0), ("motor_housing", -8.0, 120.0),
    ("motor_winding", 12.0, 120.0), ("tank_oil", 6.0, 120.0),
])  # fmt: skip
def test_a_sensor_that_is_wrong_from_its_first_reading_is_told_and_nothing_else_is_blamed(whole, sensor, by, since):
    recording, truth = whole
    fused, spread, said = live(truth, first_read(moved(recording, sensor, lambda t: np.full(t.size, by)), sensor, since))
    assert [entry[1:] for entry in said] == [("out", (sensor,))]
    read, begin = list(NODE_INDEX.values()), round(20.0 / INTERVAL)
    assert np.all(np.abs(fused - truth.fused)[begin:, read] < 3.5 * spread[begin:, read])
    assert abs(fused[-1, NODE_INDEX[sensor]] - truth.fused[-1, NODE_INDEX[sensor]]) < 2.0


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_sound_sensor_that_speaks_late_is_believed_at_once(whole, sensor):
    recording, truth = whole
    fused, spread, said = live(truth, first_read(recording, sensor, 120.0))
    at, after = NODE_INDEX[sensor], round(140.0 / INTERVAL)
    assert said == [] and np.all(np.abs(fused - truth.fused)[after:, at] < 0.3) and spread[after, at] < 0.5


def test_one_that_was_wrong_from_its_first_reading_is_used_again_once_it_is_put_right(whole):
    recording, truth = whole
    wrong = moved(recording, "motor_winding", lambda t: np.where(t < 170.0, -12.0, 0.0))
    fused, spread, said = live(truth, wrong)
    assert [entry[1:] for entry in said] == [("out", ("motor_winding",)), ("back", ("motor_winding",))]
    assert said[1][0] > 170.0 + AGREES and abs(fused[-1, AT] - truth.fused[-1, AT]) < 2.0 * spread[-1, AT] < 1.0


def standing(recording, sensor, since=0.0, until=np.inf):
    """A sensor of which only noise is left from s to s, about what it reads on the whole."""
    stream = recording.temperatures[sensor]
    read, meanwhile = stream.values[:, 0], (stream.time >= since) & (stream.time < until)
    noise = 0.1 * np.random.default_rng(0).standard_normal(read.size)
    values = np.column_stack([np.where(meanwhile, read.mean() + noise, read), stream.values[:, 1]])
    return replace(recording, temperatures={**recording.temperatures, sensor: replace(stream, values=values)})


@pytest.mark.parametrize("since", [0.0, 60.0])
def test_a_sensor_that_stands_still_is_not_used_while_its_place_moves_and_not_again_as_that_passes_by(whole, since):
    recording, truth = whole
    fused, spread, said = live(truth, standing(recording, "motor_winding", since))
    assert [entry[1:] for entry in said] == [("out", ("motor_winding",))] and said[0][0] < since + LASTING + 30.0
    settled = slice(round((said[0][0] + 30.0) / INTERVAL), None)
    assert np.all(np.abs(fused - truth.fused)[settled] < 2.5 * spread[settled])


def test_a_sensor_that_stood_still_for_a_while_is_used_again(whole):
    recording, truth = whole
    said = live(truth, standing(recording, "motor_winding", until=150.0))[2]
    assert [entry[1:] for entry in said] == [("out", ("motor_winding",)), ("back", ("motor_winding",))] and said[1][0] > 150.0


def test_of_a_unit_that_does_not_move_as_told_no_sensor_stands_still(whole):
    recording, truth = whole
    at_rest = recording
    for sensor in recording.temperatures:
        at_rest = standing(at_rest, sensor)
    assert live(SimpleNamespace(**{**vars(truth), "given": tuple(np.zeros_like(column) for column in truth.given)}), at_rest)[2] == []


def test_where_the_free_run_began_wrong_a_sensor_that_it_moves_away_from_does_not_stand_still(whole):
    """A tank's oil that is read too warm warms its wall in the free run and nowhere else."""
    recording, truth = whole
    free, since = truth.free_temperature.copy(), truth.time - truth.time[0]
    free[:, NODE_INDEX["tank_oil"]] += 13.0 * np.exp(-since / 100.0)
    free[:, NODE_INDEX["tank_wall"]] += 8.0 * (1.0 - np.exp(-since / 60.0))
    warm = moved(recording, "tank_oil", lambda t: np.full(t.size, 13.0))
    said = live(SimpleNamespace(**{**vars(truth), "free_temperature": free}), warm)[2]
    assert ("tank_wall",) not in [entry[2] for entry in said]


def test_air_that_warms_is_no_winding(whole):
    recording, truth = whole
    assert live(truth, moved(recording, "ambient", lambda t: np.clip(t - 20.0, 0.0, 60.0) / 4.0))[2] == []


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
