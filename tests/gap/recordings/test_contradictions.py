"""Channels that cannot all be right are told, and sound recordings are not suspected."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.damage import with_clock_jump
from ddh_twin_py.gap.recordings.contradictions import contradictions, other_clock
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import temperature_stream
from ddh_twin_py.telemetry.signals import TEMPERATURE_SENSORS, ZERO_CELSIUS
from support.simulated import simulated


@pytest.fixture(scope="module")
def recording():
    return simulated(1, "mixed", 120.0)[0]


def changed(recording, stream, change):
    own = getattr(recording, stream)
    values = own.values.copy()
    change(values, own.fields.index)
    return replace(recording, **{stream: replace(own, values=values)})


def test_no_current_at_all_has_no_wrong_sign(recording):
    def none(values, at):
        values[:, at("current")] = 0.0

    assert contradictions(changed(recording, "drive", none), load_rig()) == []


def later(recording, seconds):
    return replace(recording, hydraulic=replace(recording.hydraulic, time=recording.hydraulic.time + seconds))


def flipped(values, at):
    values[:, at("rod_position")] = 0.4 - values[:, at("rod_position")]


def reversed_rod(values, at):
    flipped(values, at)
    values[:, at("rod_velocity")] *= -1.0


def reversed_current(values, at):
    values[:, at("current")] *= -1.0


def reversed_command(values, at):
    values[:, at("speed_command")] *= -1.0


def stuck_command(values, at):
    values[:, at("speed_command")] = 60.0


def command_in_percent(values, at):
    values[:, at("speed_command")] /= 3.0


def speeds_in_revolutions(values, at):
    values[:, [at("speed_command"), at("speed")]] /= 2.0 * np.pi


def swapped(values, at):
    one, other = at("pressure_piston_side"), at("pressure_rod_side")
    values[:, [one, other]] = values[:, [other, one]]


def test_a_sound_recording_is_not_suspected(recording):
    assert contradictions(recording, load_rig()) == []
    assert contradictions(later(recording, 0.1), load_rig()) == []


@pytest.mark.parametrize(("stream", "change", "said"), [
    ("hydraulic", flipped, "one of them counts from the other end"), ("hydraulic", reversed_rod, "has the wrong sign"),
    ("drive", reversed_command, "speed_command is negative"), ("drive", stuck_command, "speed_command is 60 rad/s throughout"),
    ("drive", command_in_percent, "speed is 3 times speed_command"),
    ("drive", speeds_in_revolutions, "/telemetry rod_velocity is 6."),
    ("drive", reversed_current, "its sign is likely the wrong one"), ("hydraulic", swapped, "connectors are likely swapped"),
])  # fmt: skip
def test_what_cannot_be_is_told(recording, stream, change, said):
    found = contradictions(changed(recording, stream, change), load_rig())
    assert len(found) == 1 and said in found[0] and recording.path in found[0] and "/telemetry" in found[0]


@pytest.mark.parametrize("sensor", [np.abs, lambda current: np.maximum(current, 0.0)], ids=["its size", "one way"])
def test_a_current_without_its_sign_is_told(recording, sensor):
    def told(values, at):
        values[:, at("current")] = sensor(values[:, at("current")])

    (said,) = contradictions(changed(recording, "drive", told), load_rig())
    assert "/drive/telemetry: current is" in said and "likely told without its sign" in said


def declaring(recording, payload):
    return replace(recording, rig=replace(recording.rig, payload_mass=payload))


def test_another_payload_than_declared_is_no_swapped_connector(recording):
    """Pressures exchanged would carry what is declared, too, and the current tells which it is."""
    heavy = declaring(recording, 700.0)
    (said,) = contradictions(heavy, load_rig())
    assert "do not fit the 700 kg" in said and "was it another payload, about 202 kg as they are" in said and "swapped" not in said
    (said,) = contradictions(changed(heavy, "drive", lambda values, at: values[:, at("current")].fill(np.nan)), load_rig())
    assert "either their connectors are swapped, or the payload is another than the 700 kg" in said


def test_a_pressure_that_is_missing_where_it_is_large_swaps_no_connectors(recording):
    """As where the transducer is at its end: what is left of it does not carry the load."""
    def lost(values, at):
        one = values[:, at("pressure_piston_side")]
        one[one > np.quantile(one, 0.8)] = np.nan

    assert contradictions(changed(declaring(recording, 800.0), "hydraulic", lost), load_rig()) == []


def test_a_speed_in_revolutions_is_told_of_a_shaft_that_never_makes_ten_of_them_in_a_second():
    slow = simulated(1, "paper_cycle", 60.0)[0]
    slow = changed(slow, "drive", speeds_in_revolutions)
    assert np.abs(slow.drive.column("speed")).max() < 10.0
    (said,) = contradictions(slow, load_rig())
    assert "/telemetry rod_velocity is 6." in said and "one of the two is likely in another unit" in said


def rig_with(**changed):
    """The reference rig with other values, by path with dots as double underscores."""
    rig = load_rig()
    paths = {name.replace("__", "."): value for name, value in changed.items()}
    return replace(rig, quantities={p: replace(q, value=paths.get(p, q.value)) for p, q in rig.quantities.items()})


@pytest.mark.parametrize(("changed", "said"), [
    ({"pump_1__displacement": 1.3}, "rod_velocity is 0.7"), ({"pump_1__displacement": 0.8}, "rod_velocity is 1.2"),
    ({"cylinder__stroke": 0.7}, "and the stroke in"),
])  # fmt: skip
def test_a_rig_file_of_another_machine_is_asked_about(recording, changed, said):
    sheet = {name: factor * load_rig()[name.replace("__", ".")] for name, factor in changed.items()}
    (found,) = contradictions(recording, rig_with(**sheet))
    assert said in found and found.endswith("is that the rig file of this machine?")


@pytest.mark.parametrize("factor", [0.1, 10.0])
def test_pressures_without_their_decimal_place_are_told_by_the_current_whatever_the_payload(recording, factor):
    def pressures(offset=0.0, times=1.0):
        def change(values, at):
            for field in ("pressure_piston_side", "pressure_rod_side"):
                values[:, at(field)] = times * values[:, at(field)] + offset

        return changed(recording, "hydraulic", change)

    (said,) = contradictions(pressures(times=factor), load_rig())
    assert "the pressures ask for" in said and said.endswith("are likely in another unit, or a decimal place is lost")
    other = replace(recording, rig=replace(recording.rig, payload_mass=20.0))
    assert contradictions(other, load_rig()) == contradictions(pressures(offset=1.0e5), load_rig()) == []


@pytest.mark.parametrize("ways", [(0.7, 1.3), (0.8, 1.15), (1.08, 1.08)])
def test_leakage_and_tolerances_are_no_other_machine(recording, ways):
    def leaky(values, at):
        velocity = values[:, at("rod_velocity")]
        values[:, at("rod_velocity")] = np.where(velocity > 0.0, ways[0], ways[1]) * velocity

    assert contradictions(changed(recording, "hydraulic", leaky), load_rig()) == []


@pytest.mark.parametrize(("seconds", "said"), [(2.0, "2.0 s earlier"), (-1.5, "1.5 s later"), (0.5, "0.5 s earlier"),
                                               (0.3, "0.3 s earlier"), (-0.3, "0.3 s later")])  # fmt: skip
def test_clocks_that_differ_are_told(recording, seconds, said):
    assert [said in text for text in contradictions(later(recording, seconds), load_rig())] == [True]


def test_clocks_that_differ_as_the_rig_file_says_are_not_told(recording):
    rig = load_rig()
    assert contradictions(later(recording, 0.8), rig.with_values({"measurement.time_skew": 0.8})) == []
    assert ["0.8 s earlier" in text for text in contradictions(later(recording, 0.8), rig)] == [True]


@pytest.mark.parametrize("back", [2.5, 20.0, 3600.0])
def test_clocks_that_jump_back_alike_do_not_differ(recording, back):
    assert contradictions(with_clock_jump(recording, 60.0, -back), load_rig()) == []
    apart = with_clock_jump(later(recording, 0.5), 60.0, -back)
    assert ["0.5 s earlier" in text for text in contradictions(apart, load_rig())] == [True]


@pytest.mark.parametrize(("seconds", "said"), [(40.0, "40.0 s earlier"), (-40.0, "40.0 s later"), (12.0, "12.0 s earlier"),
                                               (5000.0, "5000.0 s earlier")])  # fmt: skip
def test_clocks_that_are_far_apart_are_told_by_how_much(recording, seconds, said):
    odd = later(recording, seconds)
    assert [said in text and "their clocks differ" in text for text in contradictions(odd, load_rig())] == [True]
    assert said in other_clock(odd)


def test_a_topic_that_begins_and_ends_later_is_of_the_same_clock(recording):
    drive, hydraulic = recording.drive, recording.hydraulic
    begun_late = replace(recording, drive=drive.between(20.0, 1e9), hydraulic=hydraulic.between(0.0, float(drive.time[-1]) - 20.0))
    assert other_clock(begun_late) == "" and contradictions(begun_late, load_rig()) == []
    assert other_clock(recording) == "" and other_clock(replace(recording, drive=None)) == ""


def test_what_is_missing_or_stands_still_tells_nothing(recording):
    assert contradictions(replace(recording, hydraulic=None), load_rig()) == []
    still = changed(recording, "drive", lambda values, at: values.fill(0.0))
    assert contradictions(changed(still, "hydraulic", lambda values, at: values.fill(np.nan)), load_rig()) == []


def in_degf(recording, *names):
    """A recording of which those sensors are read in degF."""
    read = dict(recording.temperatures)
    for name in names or read:
        celsius = read[name].values[:, 0] - ZERO_CELSIUS
        read[name] = temperature_stream(read[name].time, 1.8 * celsius + 32.0 + ZERO_CELSIUS)
    return replace(recording, temperatures=read)


@pytest.mark.parametrize("name", [name for name in TEMPERATURE_SENSORS if name != "motor_housing"])
def test_a_temperature_in_degf_is_told_by_its_neighbours(recording, name):
    (said,) = contradictions(in_degf(recording, name), load_rig())
    mean = recording.temperatures[name].values[:, 0].mean() - ZERO_CELSIUS
    assert said.startswith(f"{recording.path}: {recording.namespace}/temperature/{name} temperature looks as if given in degF: ")
    assert f"it reads {1.8 * mean + 32.0:.0f} degC " in said and said.endswith(f"it would be {mean:.0f} degC")


def test_a_housing_in_degf_is_told_by_a_winding_that_is_warmer_at_any_time(recording):
    warm = replace(recording, temperatures={
        "motor_winding": temperature_stream(np.arange(60.0), ZERO_CELSIUS + 70.0 + 0.1 * np.arange(60.0)),
        "motor_housing": temperature_stream(np.arange(60.0), np.full(60, ZERO_CELSIUS + 50.0)),
    })  # fmt: skip
    assert contradictions(warm, load_rig()) == []
    (said,) = contradictions(in_degf(warm, "motor_housing"), load_rig())
    assert "motor_housing temperature looks as if given in degF: it reads 122 degC on average, motor_winding 73 degC; " in said
    assert "it would be 50 degC" in said


def test_all_temperatures_in_degf_are_told_by_the_air(recording):
    warmer = {name: replace(stream, values=stream.values + [12.0, 0.0]) for name, stream in recording.temperatures.items()}
    (said,) = contradictions(in_degf(replace(recording, temperatures=warmer)), load_rig())
    assert "/temperature/ambient temperature looks as if given in degF, perhaps with others: it reads " in said


def test_what_is_hot_or_alone_is_not_in_degf(recording):
    def only(**celsius):
        read = {name: temperature_stream(np.arange(60.0), np.full(60, ZERO_CELSIUS + value)) for name, value in celsius.items()}
        return contradictions(replace(recording, temperatures=read), load_rig())

    assert only(tank_oil=104.0) == only(motor_winding=110.0, tank_oil=40.0) == []
    assert only(motor_winding=100.0, motor_housing=55.0, tank_oil=45.0, ambient=20.0) == []
    assert only(pump_1_case=75.0, pump_2_case=50.0, ambient=-5.0) == only(ambient=48.0, tank_oil=70.0) == []


def test_a_winding_whose_sensor_is_exchanged_with_one_of_the_oil_is_told(recording):
    time = np.arange(200.0)

    def read(recording=recording, **celsius):
        return replace(recording, temperatures={name: temperature_stream(time, ZERO_CELSIUS + value) for name, value in celsius.items()})

    warms, cool = 23.0 + 12.0 * time / 200.0, np.full(200, 23.2)
    sound = {"motor_winding": warms, "motor_housing": cool, "tank_oil": cool, "tank_wall": cool, "line_a": cool + 0.3}
    assert contradictions(read(**sound), load_rig()) == []
    (said,) = contradictions(read(**sound | {"motor_winding": cool, "tank_oil": warms}), load_rig())
    assert f"{recording.namespace}/temperature/motor_winding stays as cool as motor_housing while tank_oil warms by " in said
    all_oil = dict.fromkeys(("tank_oil", "tank_wall", "line_a"), warms)
    assert contradictions(read(**sound | all_oil | {"motor_winding": cool}), load_rig()) == [], "a heater in the tank"


def test_sensors_of_winding_and_housing_that_are_exchanged_are_told(recording):
    time = np.arange(200.0)
    warm = {"motor_winding": temperature_stream(time, ZERO_CELSIUS + 60.0 + 0.01 * time),
            "motor_housing": temperature_stream(time, np.full(200, ZERO_CELSIUS + 50.0))}  # fmt: skip
    assert contradictions(replace(recording, temperatures=warm), load_rig()) == []
    exchanged = {"motor_winding": warm["motor_housing"], "motor_housing": warm["motor_winding"]}
    (said,) = contradictions(replace(recording, temperatures=exchanged), load_rig())
    assert f"{recording.namespace}/temperature/motor_winding is 11 K colder than motor_housing most of the time" in said
