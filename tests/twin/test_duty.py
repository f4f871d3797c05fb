"""Duty files: what is read, what is refused."""

import pytest
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import DutyError, check_for_rig, load_duty, parse_duty
from ddh_twin_py.twin.simulated_rig import SimulatedRig, simulate

CYCLE = "cycle:\n  - lift: {speed_rpm: 500, to_m: 0.39}\n"


@pytest.fixture
def duty(tmp_path):
    def write(text):
        file = tmp_path / "duty.yaml"
        file.write_text(text)
        return file

    return write


def refusal(file):
    with pytest.raises(DutyError) as caught:
        load_duty(file)
    message = str(caught.value)
    assert message.startswith(f"{file}: ") and "\n" not in message
    return message


@pytest.mark.parametrize("name", ["paper_cycle", "mixed"])
def test_the_projects_own_are_sound(repo_root, name):
    check_for_rig(load_duty(repo_root / "ddh_twin_py/config/duty" / f"{name}.yaml"), load_rig())


@pytest.mark.parametrize("entry, expected", [
    ("ambient_degC: []", "ambient_degC: found [], a number or a list of [time_s, degC] is needed"),
    ("ambient_degC: [[]]", "ambient_degC: found [[]]"),
    ("ambient_degC: [[0, 20, 3, 4]]", "ambient_degC: found [[0, 20, 3, 4]]"),
    ("ambient_degC: [0, 20]", "ambient_degC: found [0, 20]"),
    ("ambient_degC: [[0, cold]]", "ambient_degC: value is 'cold'"),
    ("ambient_degC: [[5, 20], [5, 21]]", "times must rise"),
    ("ambient_degC: 81", "ambient_degC: value is 81 degC, allowed are -60 to 80 degC"),
    ("ambient_degC: [[0, 20], [60, -300]]", "ambient_degC: value is -300 degC"),
    ("start_position_m: -0.1", "start_position_m: value is -0.1 m, allowed are 0 to 2 m"),
    ("start_position_m: 39", "start_position_m: value is 39 m"),
    ("payload_kg: 0", "payload_kg: value is 0 kg"),
    ("payload_kg: 1.0e+9", "payload_kg: value is 1e+09 kg, allowed are 0.001 to 100000 kg"),
    ("payload_kg: 1" + "0" * 400, "a finite number is needed"),
    ("ramp_rpm_per_s: 0", "ramp_rpm_per_s: value is 0 rpm/s, allowed are 1 to 1e+06 rpm/s"),
    ("ramp_rpm_per_s: 1.0e+12", "ramp_rpm_per_s: value is 1e+12"),
    ("repeat: -1", "repeat: value is -1, a whole number from 0 on"),
    ("repeat: 2\nrepeat: 3", "repeat: given twice, in lines 1 and 2"),
    ("phases: &a [*a]", "phases: is an alias to what it lies in itself, which begins in line 1"),
    ("repeat: 2.5", "repeat: value is 2.5"),
    ("repeat: 2026-13-45", "is not YAML"),
])
def test_what_cannot_be_used_is_named(duty, entry, expected):
    assert expected in refusal(duty(f"{entry}\n{CYCLE}"))


@pytest.mark.parametrize("segment, expected", [
    ("lift: {speed_rpm: 7000, to_m: 0.3}", "cycle[0].lift.speed_rpm: value is 7000 rpm, allowed are -6000 to 6000 rpm"),
    ("lift: {speed_rpm: -10, to_m: 0.3}", "must be above 0"),
    ("speed: {speed_rpm: -6001, duration_s: 1}", "cycle[0].speed.speed_rpm: value is -6001"),
    ("lower: {speed_rpm: 10, to_m: -0.3}", "cycle[0].lower.to_m: value is -0.3 m, allowed are 0 to 2 m"),
    ("lift: {speed_rpm: 10, to_m: 390}", "cycle[0].lift.to_m: value is 390 m"),
    ("dwell: {duration_s: 0}", "a duration of 0 s; it must be above 0"),
    ("dwell: {duration_s: 1.0e+12}", "a duration of 1e+12 s"),
])
def test_segments_that_cannot_be_used_are_named(duty, segment, expected):
    assert expected in refusal(duty(f"cycle:\n  - {segment}\n"))


@pytest.mark.parametrize("text, expected", [
    ("start_position_m: 0.41\n" + CYCLE, "start_position_m: value is 0.41 m, allowed are 0 to 0.4 m, the stroke of ddh_rig.yaml"),
    ("cycle:\n  - dwell: {duration_s: 1}\n  - lift: {speed_rpm: 9, to_m: 0.5}\n", "cycle[1].lift.to_m: value is 0.5 m"),
])
def test_positions_beyond_the_stroke_of_the_rig_are_named(duty, text, expected):
    file = duty(text)
    with pytest.raises(DutyError) as caught:
        SimulatedRig(load_rig(), load_duty(file), 1)
    assert str(caught.value).startswith(f"{file}: ") and expected in str(caught.value)


def test_seed_and_duration_of_a_simulation(duty):
    file = duty(CYCLE)
    with pytest.raises(DutyError, match="seed of the simulated rig is -1"):
        simulate(None, file, -1, 1.0)
    for duration in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(DutyError, match="duration of the simulation is .* s, it must be above 0"):
            simulate(None, file, 1, duration)


def test_a_text_that_is_larger_than_a_file_may_be_is_not_parsed():
    with pytest.raises(DutyError, match="^duty_file: has 2000000 characters, allowed are 1000000$"):
        parse_duty("x" * 2_000_000, "duty_file")
    with pytest.raises(DutyError) as caught:
        parse_duty("x" * 1_000_000, "duty_file")
    assert len(str(caught.value)) < 200
