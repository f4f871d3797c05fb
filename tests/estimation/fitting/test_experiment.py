"""Free runs over recordings that lack something."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.damage import with_value
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.fitting.experiment import Experiment, ExperimentError
from ddh_twin_py.physics.cylinder import piston_area
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Stream
from ddh_twin_py.telemetry.signals import HYDRAULIC_FIELDS
from support.simulated import of_the_sheet


def test_a_load_of_unknown_pressure_is_held_at_the_start(paper_cycle_bag):
    rig, recording = load_rig(), read_recording(paper_cycle_bag).between(0.0, 60.0)
    blind = recording
    for name in ("pressure_piston_side", "pressure_rod_side"):
        blind = with_value(blind, "hydraulics/telemetry", name, np.nan)
    known, held = (Experiment(r, rig) for r in (recording, blind))
    points = held.operating(held.parameters(rig))[0]
    force = recording.rig.payload_mass * rig["load.gravity"]
    assert points["pressure_piston_side"][0] == pytest.approx(force / piston_area(held.parameters(rig)[0]), rel=0.15)
    measured = known.operating(known.parameters(rig))[0]
    assert np.abs(points["rod_position"] - measured["rod_position"]).max() < 2e-3
    off = held.parameters(rig)
    for name in ("pressure_piston_side", "pressure_rod_side"):
        off[f"measurement_{name}_offset"] = 5.0e4  # of a transducer that is not there
    np.testing.assert_array_equal(held.operating(off)[0], points)


def test_a_recording_that_begins_a_little_beyond_a_stop_begins_at_it(paper_cycle_bag):
    rig, recording = load_rig(), read_recording(paper_cycle_bag).between(0.0, 60.0)
    values = recording.hydraulic.values.copy()
    position = values[:, HYDRAULIC_FIELDS.index("rod_position")]
    position -= position[0] + 5.0e-4
    at_it = Experiment(replace(recording, hydraulic=replace(recording.hydraulic, values=values)), rig)
    points = at_it.operating(at_it.parameters(rig))[0][:20]
    assert np.abs(points["rod_position"]).max() < 1e-4 and points["pressure_rod_side"].max() < 1e5


@pytest.mark.parametrize(("declared", "taken"), [(137.0, 137.0), (0.0, None), (-5.0, None), (np.inf, None), (np.nan, None)])
def test_a_payload_that_is_no_mass_declares_nothing(paper_cycle_bag, declared, taken):
    rig, recording = load_rig(), read_recording(paper_cycle_bag).between(0.0, 10.0)
    told = replace(recording, rig=replace(recording.rig, payload_mass=declared))
    assert Experiment(told, rig).payload == (taken or rig["load.payload_mass"])


SINKING = """
payload_kg: 420
ambient_degC: 40
start_position_m: 0.03
ramp_rpm_per_s: 3000
repeat: 0
cycle:
  - lift: {speed_rpm: 1400, to_m: 0.37}
  - dwell: {duration_s: 1}
  - lower: {speed_rpm: 1400, to_m: 0.03}
  - dwell: {duration_s: 3}
"""


def test_a_rod_that_sinks_at_rest_makes_no_stroke_error():
    """Leakage lets it sink by two millimetres a second: positions of half a second after a stroke are not those of its end."""
    rig, recording = load_rig(), of_the_sheet(SINKING, 90.0)
    experiment = Experiment(recording, rig)
    strokes = experiment.signals["rod_position"]
    off = (strokes.measured - experiment.predict(experiment.parameters(rig))["rod_position"])[strokes.binning.bin >= 0]
    assert off.size > 10 and np.sqrt(np.mean(off**2)) < strokes.noise and abs(off.mean()) < 0.3 * strokes.noise


def test_a_resting_rod_that_sinks_and_a_drive_at_its_limit_follow_no_command():
    rig, recording = load_rig(), of_the_sheet(SINKING, 120.0, 5)
    sunk = Experiment(recording, rig)
    velocity, speed = sunk.signals["rod_velocity"], sunk.signals["speed"]
    moving = np.interp(velocity.time, recording.drive.time, recording.drive.column("speed_command")) != 0.0
    assert velocity.follows[moving].mean() > 0.9 and velocity.follows[~moving].mean() < 0.3 and speed.follows.all()
    weak = rig.with_values({"motor.current_limit": 0.5 * float(np.abs(recording.drive.column("current")).max())})
    limited = Experiment(recording, weak).signals["speed"]
    assert 0.0 < np.count_nonzero(~limited.follows) < limited.time.size


WORKING = SINKING.replace("420", "900").replace("1400", "500").replace("duration_s: 1", "duration_s: 3").replace("0.37", "0.35")


def test_a_recording_that_begins_in_the_middle_of_work_begins_as_warm_as_the_unit_is():
    """A winding that rises by a quarter of a kelvin each second is 1.4 K ahead of its sensor."""
    rig, whole = load_rig(), of_the_sheet(WORKING, 200.0, 5)
    true, begun = Experiment(whole, rig), Experiment(whole.between(150.0, 1e9), rig)
    at = np.argmin(np.abs(true.axis - 150.0))
    there = true.operating(true.parameters(rig))[1][at]
    parameters = begun.parameters(rig)
    node, housing = NODES.index("end_winding"), NODES.index("housing")
    start = begun.operating(parameters)[1][0]
    assert abs(start[node] - there[node]) < 0.4 and abs(start[housing] - there[housing]) < 0.1
    winding = begun.signals["temperature/motor_winding"]
    early = winding.time < 10.0
    off = (winding.measured - begun.predict(parameters)["temperature/motor_winding"])[early]
    assert abs(off.mean()) < 0.2 and abs(off[:3].mean()) < 0.3


def test_a_sensor_that_begins_in_what_is_held_out_is_as_if_it_were_not_there(paper_cycle_bag):
    rig, recording = load_rig(), read_recording(paper_cycle_bag).between(0.0, 60.0)
    others = {name: stream for name, stream in recording.temperatures.items() if name != "tank_oil"}
    late = replace(recording, temperatures=others | {"tank_oil": recording.temperatures["tank_oil"].between(54.0, 60.0)})
    without = Experiment(replace(recording, temperatures=others), rig, used=0.75)
    begun = Experiment(late, rig, used=0.75)
    assert "tank_oil" not in begun.sensors and begun.sensors == without.sensors and begun.signals.keys() == without.signals.keys()
    for name, predicted in begun.predict(begun.parameters(rig)).items():
        np.testing.assert_array_equal(predicted, without.predict(without.parameters(rig))[name])
    assert "tank_oil" in Experiment(late, rig).sensors


@pytest.mark.parametrize("length", [36.79, 42.63, 51.39, 58.0])
def test_what_is_stamped_after_the_end_is_predicted_as_at_the_end(length, paper_cycle_bag):
    """Where hydraulic samples are stamped early, the last ones are of the run's last instant, which its steps meet but for rounding."""
    rig = load_rig()
    experiment = Experiment(read_recording(paper_cycle_bag).between(0.0, length), rig)
    parameters = experiment.parameters(rig)
    parameters["measurement_time_skew"] = -0.03
    assert all(np.isfinite(values).all() for values in experiment.predict(parameters).values())


def thinned(stream, hertz):
    """The stream with so many samples per second."""
    every = round(1.0 / hertz / np.median(np.diff(stream.time)))
    return Stream(stream.time[::every], stream.values[::every], stream.fields)


@pytest.mark.parametrize("hertz", [100.0, 20.0, 10.0])
def test_how_far_a_clock_was_set_back_is_told_whatever_the_rate(hertz, paper_cycle_bag):
    recording = read_recording(paper_cycle_bag).between(0.0, 60.0)
    streams = {name: stepped(thinned(s, hertz) if "telemetry" in name else s, 3.0) for name, s in recording.streams()}
    with pytest.raises(ExperimentError, match=r": the stamps jump 1 time, first by -3\.0 s at (29\.9|30\.0) s; "):
        Experiment(recording.with_streams(streams), load_rig())


def test_a_topic_whose_clock_leaps_to_and_fro_is_named(paper_cycle_bag):
    recording = read_recording(paper_cycle_bag).between(0.0, 20.0)
    ambient = recording.temperatures["ambient"]
    leaping = Stream(ambient.time + 3600.0 * (np.arange(len(ambient)) % 2), ambient.values, ambient.fields)
    odd = replace(recording, temperatures=recording.temperatures | {"ambient": leaping})
    with pytest.raises(ExperimentError, match=r"/ambient: its stamps, and those of no other topic, jump 3\d times, first by \+3600"):
        Experiment(odd, load_rig())


def stepped(stream, by):
    """The stream with a clock that goes back by so many seconds behind 30 s."""
    return Stream(np.where(stream.time <= 30.0, stream.time, stream.time - by), stream.values, stream.fields)


@pytest.mark.parametrize("topics, by, said", [
    (("hydraulic",), 20.0, "/hydraulics/telemetry: its stamps, and those of no other topic, jump 1 time, first by -20"),
    (("tank_oil",), 20.0, "/temperature/tank_oil: its stamps, and those of no other topic, jump 1 time, first by -20"),
    (("drive", "hydraulic"), 20.0, "/hydraulics/telemetry: their stamps, and those of no other topic, jump 1 time, first by -20"),
    (("tank_oil", "line_a", "line_b", "motor_winding", "motor_housing"), -3600.0,
     " and 2 more: their stamps, and those of no other topic, jump 1 time, first by +3600.0 s at 29."),  # a logger of its own
    (("drive", "slow"), 0.8, ": the stamps jump 1 time"),  # at 1 Hz none would show it
])
def test_a_clock_that_jumps_is_named_where_it_is_that_of_some_topics_alone(topics, by, said, paper_cycle_bag):
    recording = read_recording(paper_cycle_bag).between(0.0, 60.0)
    if "slow" in topics:
        every = round(1.0 / np.median(np.diff(recording.hydraulic.time)))
        slow = Stream(recording.hydraulic.time[::every], recording.hydraulic.values[::every], recording.hydraulic.fields)
        recording = replace(recording, hydraulic=slow, temperatures={})
    for name in topics:
        if name in recording.temperatures:
            recording = replace(recording, temperatures=recording.temperatures | {name: stepped(recording.temperatures[name], by)})
        elif name != "slow":
            recording = replace(recording, **{name: stepped(getattr(recording, name), by)})
    with pytest.raises(ExperimentError) as refused:
        Experiment(recording, load_rig())
    assert said in str(refused.value) and str(refused.value).startswith(f"{recording.path}: ")


def test_a_recording_of_a_moment_is_refused_with_its_length(paper_cycle_bag):
    recording = read_recording(paper_cycle_bag).between(0.0, 0.03)
    with pytest.raises(ExperimentError, match=r"lasts 0\.02\d* s, which is too short for a free run; at least 0\.2 s are needed$"):
        Experiment(recording, load_rig())


def test_half_a_second_whose_used_part_holds_no_temperature_is_taken_as_it_is(paper_cycle_bag):
    recording = read_recording(paper_cycle_bag)
    for begin in np.arange(0.0, 0.5, 0.1):
        assert Experiment(recording.between(100.0 + begin, 100.5 + begin), load_rig(), used=0.75).duration < 0.6


def test_both_streams_are_merged_in_order_whatever_their_clocks_are_apart(paper_cycle_bag):
    experiment = Experiment(read_recording(paper_cycle_bag), load_rig())
    for skew in (0.0, 0.004, -0.0137):
        instants, at_drive, at_hydraulic = experiment._merge(skew)
        assert np.all(np.diff(instants) >= 0.0) and sorted([*at_drive, *at_hydraulic]) == list(range(instants.size))
        end = experiment.duration
        assert instants[at_drive] == pytest.approx(np.minimum(experiment._drive_time, end), abs=2e-6)
        assert instants[at_hydraulic] == pytest.approx(np.minimum(experiment._hydraulic_time - skew, end), abs=2e-6)


def test_a_run_leaves_what_earlier_ones_predicted(paper_cycle_bag):
    """Runs of one thread write into the same arrays; nothing of these is handed out."""
    rig = load_rig()
    experiment = Experiment(read_recording(paper_cycle_bag).between(0.0, 40.0), rig)
    parameters = experiment.parameters(rig)
    first = experiment.predict(parameters)
    kept = {name: values.copy() for name, values in first.items()}
    points, temperatures = experiment.operating(parameters)
    speed, warmest = points["speed"].copy(), temperatures.copy()
    parameters["pump_1_leakage"] *= 2.0
    other = experiment.predict(parameters)
    assert np.abs(other["pressure_piston_side"] - kept["pressure_piston_side"]).max() > 1e3
    for name, values in first.items():
        np.testing.assert_array_equal(values, kept[name])
    np.testing.assert_array_equal(points["speed"], speed)
    np.testing.assert_array_equal(temperatures, warmest)


@pytest.mark.parametrize("length", [60.0, 60.05])
@pytest.mark.parametrize("field, factor", [("pump_1_leakage", 1.3), ("load_payload_mass", 1.1), ("motor_housing_capacity", 0.9)])
def test_rough_runs_differ_as_fine_ones_do(field, factor, length, paper_cycle_bag):
    """Whether the last of the longer intervals is whole or not."""
    rig = load_rig()
    experiment = Experiment(read_recording(paper_cycle_bag).between(0.0, length), rig)
    plain, changed = experiment.parameters(rig), experiment.parameters(rig)
    changed[field] *= factor
    difference = {}
    for roughly, step in ((False, 1.0e-3), (True, 4.0e-3)):
        base, moved = (experiment.predict(p, step, roughly=roughly) for p in (plain, changed))
        counted = [s.binning.bin >= 0 for s in experiment.signals.values()]
        difference[roughly] = np.concatenate([(moved[name] - base[name])[used] / s.noise
                                              for (name, s), used in zip(experiment.signals.items(), counted, strict=True)])
    assert np.isfinite(difference[True]).all()
    apart = np.sqrt(np.mean((difference[True] - difference[False]) ** 2))
    assert apart < 0.08 * np.sqrt(np.mean(difference[False] ** 2))


def test_a_topic_with_a_stamp_far_from_its_others_is_named(paper_cycle_bag):
    recording = read_recording(paper_cycle_bag).between(0.0, 60.0)
    oil = recording.temperatures["tank_oil"]
    time = oil.time.copy()
    time[-1] += 3600.0
    odd = replace(recording, temperatures=recording.temperatures | {"tank_oil": Stream(time, oil.values, oil.fields)})
    with pytest.raises(ExperimentError, match=r"/temperature/tank_oil has 1 stamp far after all its others, at 36\d\d\.\d s of"):
        Experiment(odd, load_rig())


def test_a_temperature_in_whole_degrees_is_noisier_by_its_rounding(paper_cycle_bag):
    rig, recording = load_rig(), read_recording(paper_cycle_bag).between(0.0, 300.0)
    oil = recording.temperatures["tank_oil"]
    values = oil.values.copy()
    values[:, 0] = np.round(values[:, 0] - 273.15) + 273.15
    coarse = replace(recording, temperatures=recording.temperatures | {"tank_oil": Stream(oil.time, values, oil.fields)})
    fine, rounded = (Experiment(r, rig).signals["temperature/tank_oil"] for r in (recording, coarse))
    assert fine.rounding == 0.0 and fine.noise == rig.sensors["temperature"].noise
    assert rounded.rounding == pytest.approx(1.0 / np.sqrt(12.0), rel=0.01)
    assert rounded.noise == pytest.approx(np.hypot(fine.noise, rounded.rounding))
