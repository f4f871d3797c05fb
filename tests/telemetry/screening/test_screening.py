"""Screening: sound sensors pass in silence, each fault is named with file, topic and value."""

import json
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags import damage
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.causes import Cause
from ddh_twin_py.telemetry.recording import Stream, drive_stream
from ddh_twin_py.telemetry.screening.screening import StreamScreen, screen_by_sheet, screen_recording
from ddh_twin_py.telemetry.signals import DRIVE_FIELDS, HYDRAULIC_FIELDS, SIGNALS, TEMPERATURE_SENSORS, ZERO_CELSIUS
from ddh_twin_py.telemetry.units.drive_units import judge_drive
from ddh_twin_py.telemetry.units.unit_scales import UnitScales

DRIVE, HYDRAULIC = "drive/telemetry", "hydraulics/telemetry"


def only(recording, noise, scales=None):
    """The one finding of a recording, and the screened recording."""
    screened = screen_recording(recording, noise, scales=scales)
    (finding,) = screened.findings
    assert finding.severity in ("warning", "error")
    assert recording.path in finding.message
    assert finding.topic in finding.message
    if finding.field:
        assert finding.field in finding.message
    return finding, screened


# Sound recordings


def test_paper_cycle_passes_in_silence(paper, noise):
    screened = screen_recording(paper, noise)
    assert screened.findings == []
    for (name, before), (_, after) in zip(paper.streams(), screened.streams(), strict=True):
        np.testing.assert_array_equal(before.time, after.time, name)
        np.testing.assert_array_equal(before.values, after.values, name)


def test_open_cases_have_no_false_findings(shared_dir, noise, scales):
    """Imperfect clocks and drop-outs are named, but no sound sensor is called stuck or off."""
    folders = sorted((shared_dir / "data" / "open_cases").glob("case_*/*"))
    if not folders:
        pytest.skip("no open cases")
    quiet = 0
    for folder in folders:
        recording = read_recording(folder)
        assert recording.findings == [], folder
        screened = screen_recording(recording, noise, scales=scales)
        quiet += not screened.findings
        nans = sum(int(np.isnan(s.values).sum()) for _, s in recording.streams())
        said = sum(f.count for f in screened.findings if "is NaN in" in f.message)
        for finding in screened.findings:
            assert any(w in finding.message for w in ("is NaN in", "repeats a stamp", "out of order")), finding
        repeated = sum(len(s) for _, s in recording.streams()) - sum(len(s) for _, s in screened.streams())
        assert repeated == sum(f.count for f in screened.findings if "repeats a stamp" in f.message)
        assert said <= nans <= said + 6 * repeated  # a repeated message may repeat a NaN
        for _, stream in screened.streams():
            assert (np.diff(stream.time) > 0).all()
    assert quiet >= len(folders) * 0.8


@pytest.mark.parametrize("coarse", [0.5, 1.0, 2.0, 4.0])
def test_coarse_sensors_are_not_stuck(coarse):
    """A quantised sensor repeats its value legitimately, also at standstill."""
    noise = 0.1
    rng = np.random.default_rng(7)
    kelvin = 296.15 + rng.normal(0.0, noise, 400_000) + rng.uniform(-1, 1) * coarse * noise
    step = coarse * noise
    values = np.column_stack([np.round(kelvin / step) * step, np.zeros(kelvin.size)])
    screen = StreamScreen("temperature/ambient", {"temperature": noise})
    screen.screen(np.arange(kelvin.size) * 500_000_000, values)
    assert screen.health()["stuck"] == 0


def test_sample_and_hold_is_not_stuck():
    """A sensor read every 2 s and published at 10 Hz."""
    rng = np.random.default_rng(8)
    kelvin = np.repeat(np.round(296.15 + rng.normal(0.0, 0.1, 5000), 2), 20)
    screen = StreamScreen("temperature/ambient", {"temperature": 0.1})
    screen.screen(np.arange(kelvin.size) * 100_000_000, np.column_stack([kelvin, kelvin * 0]))
    assert screen.health()["stuck"] == 0


def test_a_drive_that_is_switched_off_is_not_stuck(noise):
    screen = StreamScreen(DRIVE, noise)
    values = np.zeros((6000, 6))
    values[:, 1] = np.random.default_rng(1).normal(0, 0.15, 6000)  # the encoder still sees noise
    screen.screen(np.arange(6000) * 10_000_000, values)
    assert screen.health()["stuck"] == 0


# Values


def test_nan_is_counted_and_said(paper, noise):
    finding, screened = only(damage.with_value(paper, DRIVE, "torque", np.nan, 12.0, 13.0), noise)
    assert finding.field == "torque"
    assert f"/ddh/{DRIVE} torque is NaN in {finding.count} of 32995 samples, first at 12.0" in finding.message
    assert finding.count == int(np.isnan(screened.drive.column("torque")).sum()) in range(99, 102)
    assert finding.first_time == pytest.approx(12.0, abs=0.011)


def test_infinity_becomes_nan(paper, noise):
    finding, screened = only(damage.with_value(paper, DRIVE, "current", np.inf, 5.0, 5.05), noise)
    assert "current is inf in 5 of 32995 samples" in finding.message
    assert not np.isinf(screened.drive.values).any()


@pytest.mark.parametrize(
    ("stream", "field", "value", "allowed"),
    [
        (DRIVE, "current", 812.0, "reads 812 A at 3."),
        (DRIVE, "voltage", -400.0, "allowed are -50 to 1000 V"),
        (HYDRAULIC, "pressure_rod_side", 9e7, "allowed are -500000 to 6e+07 Pa"),
        ("temperature/tank_oil", "temperature", 273.15 + 850.0, "reads 850 degC at 3."),
    ],
)
def test_out_of_range_is_left_out_and_said(paper, noise, stream, field, value, allowed):
    finding, screened = only(damage.with_value(paper, stream, field, value, 3.0, 3.6), noise)
    assert allowed in finding.message
    assert "are out of range and not used" in finding.message
    assert "looks as if" not in finding.message
    values = dict(screened.streams())[stream].column(field)
    assert int(np.isnan(values).sum()) == finding.count > 0


# Units


@pytest.mark.parametrize(("factor", "unit"), [(1e-5, "bar (factor 1e-05)"), (1e-3, "kPa (factor 0.001)")])
def test_both_pressures_in_another_unit(paper, noise, factor, unit):
    bad = paper
    for field in ("pressure_piston_side", "pressure_rod_side"):
        bad = damage.with_wrong_unit(bad, HYDRAULIC, field, factor)
    finding, screened = only(bad, noise)
    assert finding.severity == "error"
    assert (
        f"pressure_piston_side and pressure_rod_side look as if given in {unit}, expected is Pa: "
        "pressure_piston_side and pressure_rod_side stay below 1" in finding.message
    )
    assert np.isnan(screened.hydraulic.values[:, :2]).all()
    assert np.isfinite(screened.hydraulic.values[:, 2:]).all()


@pytest.mark.parametrize(
    ("stream", "field", "factor", "offset", "said"),
    [
        (HYDRAULIC, "pressure_piston_side", 1e-5, 0.0, "pressure_piston_side looks as if given in bar (factor 1e-05)"),
        (HYDRAULIC, "pressure_rod_side", 1e-5, 0.0, "pressure_rod_side stays below"),
        (HYDRAULIC, "pressure_piston_side", 1e-3, 0.0, "pressure_piston_side looks as if given in kPa (factor 0.001)"),
        (HYDRAULIC, "pressure_rod_side", 1e5, 0.0, "looks as if given in Pa, converted from bar twice (factor 1e+05), expected is Pa"),
        (HYDRAULIC, "rod_position", 1e3, 0.0, "looks as if given in mm (factor 1000), expected is m"),
        ("temperature/tank_oil", "temperature", 1.0, 273.15, "looks as if given in K (+273.15), expected is degC"),
        ("temperature/tank_oil", "temperature", 1.0, -273.15, "looks as if given in degC less 273.15 (-273.15), expected is degC"),
        # 10 K warmer than it is, as 69 is no more than a hot day
        ("temperature/ambient", "temperature", 1.8, 32.0 - 0.8 * 273.15 + 18.0, "looks as if given in degF (factor 1.8, +32), expected"),
        (
            "temperature/motor_winding",
            "temperature",
            1.0,
            273.15,
            "reads 296.",
        ),
        (DRIVE, "speed", 30 / np.pi, 0.0, "speed looks as if given in rpm (factor 9.549), expected is rad/s"),
        (DRIVE, "speed_command", 30 / np.pi, 0.0, "speed_command looks as if given in rpm"),
        (DRIVE, "electrical_power", 1e-3, 0.0, "electrical_power looks as if given in kW (factor 0.001), expected is W"),
    ],
)
def test_other_units_are_named(paper, noise, stream, field, factor, offset, said):
    screened = screen_recording(damage.with_wrong_unit(paper, stream, field, factor, offset), noise)
    assert {f.field for f in screened.findings} == {field}
    assert any(said in f.message for f in screened.findings)
    assert any("looks as if given in" in f.message and f.severity == "error" for f in screened.findings)


def all_in_degf(recording, warmer):
    """Of a recording, all temperatures in degF and so many K warmer, by sensor, the ambient 3 K."""
    for name in recording.temperatures:
        more = 3.0 if name == "ambient" else warmer(name)
        recording = damage.with_wrong_unit(recording, f"temperature/{name}", "temperature", 1.8, 32.0 - 0.8 * 273.15 + 1.8 * more)
    return recording


def test_what_begins_as_a_refused_temperature_does_is_in_its_unit(paper, noise):
    rested = screen_recording(all_in_degf(paper.between(0.0, 60.0), lambda name: 3.0), noise)
    assert {f.topic.rsplit("/", 1)[1] for f in rested.findings} == set(paper.temperatures)
    assert all("looks as if given in degF" in f.message and f.severity == "error" for f in rested.findings)
    assert all(np.isnan(stream.values[:, 0]).all() for stream in rested.temperatures.values())


def test_what_is_as_warm_as_a_refused_one_reads_by_chance_is_believed(paper, noise):
    """Of a warm unit in degC two places are at 70 to 73 degC, as the air's 22 degC are in degF."""
    part = paper.between(0.0, 60.0)
    warm = damage.with_wrong_unit(part, "temperature/ambient", "temperature", 1.8, 32.0 - 0.8 * 273.15)
    for i, name in enumerate(n for n in part.temperatures if n != "ambient"):
        warm = damage.with_wrong_unit(warm, f"temperature/{name}", "temperature", 1.0, 27.0 + 3.0 * i)
    ambient = warm.temperatures["ambient"]
    hot = warm.with_streams({"temperature/ambient": Stream(ambient.time, ambient.values + [1.0, 0.0], ambient.fields)}, [])
    finding, screened = only(hot, noise)
    assert "/ambient temperature looks as if given in degF" in finding.message
    assert all(np.isfinite(s.values[:, 0]).all() for name, s in screened.temperatures.items() if name != "ambient")


def with_temperatures(recording, change, *names):
    """Of a recording, temperatures changed as numbers in degC, all where none is named."""
    for name in names or recording.temperatures:
        stream = recording.temperatures[name]
        values = np.column_stack([change(stream.values[:, 0] - 273.15) + 273.15, stream.values[:, 1]])
        recording = recording.with_streams(dict(recording.streams()) | {f"temperature/{name}": Stream(stream.time, values, stream.fields)})
    return recording


def refused(recording, noise, scales):
    """What is said of each temperature of which nothing is used, by sensor; of no other anything is."""
    screened = screen_recording(recording, noise, scales=scales)
    said = {finding.topic.rsplit("/", 1)[1]: finding.message for finding in screened.findings if finding.severity == "error"}
    assert said.keys() >= {finding.topic.rsplit("/", 1)[1] for finding in screened.findings}
    assert said.keys() == {name for name, stream in screened.temperatures.items() if np.isnan(stream.values[:, 0]).all()}
    return said


def test_all_temperatures_ten_times_too_large_are_refused_and_named(paper, noise, scales):
    """230 degC may be 23.0, or -43 degC in K, as of a machine never."""
    for colder in (0.0, 8.0):  # 150 degC is in range of all but the air
        said = refused(with_temperatures(paper, lambda celsius, colder=colder: 10.0 * (celsius - colder)), noise, scales)
        assert said.keys() == paper.temperatures.keys()
        assert all("looks as if given in tenths of degC" in text for text in said.values())


def test_a_cold_machine_in_kelvin_is_not_in_tenths(paper, noise, scales):
    """281.3 is 8.2 degC in K and would be 28.1 degC in tenths, of which none has a fraction; 281 may be either."""
    said = refused(with_temperatures(paper, lambda celsius: celsius - 15.0 + 273.15), noise, scales)
    assert said.keys() == paper.temperatures.keys()
    assert all("looks as if given in K (+273.15), expected is degC" in text for text in said.values())
    said = refused(with_temperatures(paper, lambda celsius: np.round(10.0 * (celsius + 5.0))), noise, scales)
    assert said.keys() == paper.temperatures.keys() and all("tenths of degC (factor 10)" in text for text in said.values())


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_the_largest_numbers_are_out_of_range_and_no_more(paper, noise, scales):
    largest = np.finfo(float).max
    drive = Stream(paper.drive.time, np.where(np.arange(6) % 2, largest, -largest) * np.ones((len(paper.drive), 1)), DRIVE_FIELDS)
    damaged = with_temperatures(paper.with_streams(dict(paper.streams()) | {DRIVE: drive}), lambda celsius: np.full(celsius.size, largest))
    screened = screen_recording(damaged, noise, scales=scales)
    said = [finding for finding in screened.findings if finding.severity != "info"]
    assert len(said) == 6 + len(paper.temperatures) and all("are out of range and not used" in f.message for f in said)
    assert not any("looks as if" in f.message for f in said) and np.isnan(screened.drive.values).all()


@pytest.mark.parametrize("colder", [0.0, 8.0])
@pytest.mark.parametrize("name", TEMPERATURE_SENSORS)
def test_one_temperature_ten_times_too_large_is_refused_and_named(paper, noise, scales, name, colder):
    cold = with_temperatures(paper, lambda celsius: celsius - colder)
    (said,) = refused(with_temperatures(cold, lambda celsius: 10.0 * celsius, name), noise, scales).items()
    assert said[0] == name and "looks as if given in tenths of degC" in said[1] and said[1].endswith(("not used", "nor are the others"))


def test_a_winding_that_is_heated_beyond_its_range_is_in_no_other_unit(paper, noise, scales):
    hot = with_temperatures(paper, lambda celsius: celsius + np.linspace(0.0, 260.0, celsius.size), "motor_winding")
    finding, screened = only(hot, noise, scales)
    assert "allowed are -50 to 230 degC" in finding.message and finding.message.endswith("samples are out of range and not used")
    assert np.nanmax(screened.temperatures["motor_winding"].values[:, 0]) > 500.0


@pytest.mark.parametrize(("unit", "change"), [("degF", lambda celsius: 1.8 * celsius + 32.0), ("degC of the other sign", np.negative)])
@pytest.mark.parametrize("name", TEMPERATURE_SENSORS)
def test_one_temperature_in_degf_or_of_the_other_sign_is_refused_and_no_neighbour(paper, noise, scales, name, unit, change):
    (said,) = refused(with_temperatures(paper, change, name), noise, scales).items()
    assert said[0] == name and f"temperature looks as if given in {unit}" in said[1]


@pytest.mark.parametrize("known", [True, False])
def test_ambient_and_winding_that_are_exchanged_are_both_refused_and_the_housing_is_not_blamed(paper, noise, scales, known):
    read = dict(paper.streams())
    air, winding = read["temperature/ambient"], read["temperature/motor_winding"]
    odd = paper.with_streams(read | {"temperature/ambient": winding, "temperature/motor_winding": air})
    said = refused(odd, noise, scales if known else None)
    assert said.keys() == {"ambient", "motor_winding"} and all("their sensors are likely exchanged" in text for text in said.values())


def test_frost_and_hot_air_about_a_sound_machine_are_believed(paper, noise, scales):
    frost = with_temperatures(paper, lambda celsius: celsius - 35.0, "ambient")
    hot = with_temperatures(paper, lambda celsius: celsius + 30.0, "ambient")
    warm = with_temperatures(with_temperatures(paper, lambda celsius: celsius + 20.0), lambda celsius: celsius - 60.0, "ambient")
    cold = with_temperatures(paper, lambda celsius: celsius - 45.0)
    for sound in (frost, hot, warm, cold):
        assert refused(sound, noise, scales) == {}


def test_what_is_in_another_unit_is_not_used_where_it_happens_to_be_in_range(paper, noise):
    wrong = damage.with_wrong_unit(paper, HYDRAULIC, "rod_velocity", 1e3, 0.0)
    finding, screened = only(wrong, noise)
    assert "looks as if given in mm/s" in finding.message and finding.message.endswith("not used, nor are the others")
    assert np.isnan(screened.hydraulic.values[:, 3]).all() and np.isfinite(screened.hydraulic.values[:, :3]).any()


@pytest.mark.parametrize(("share", "severity"), [(0.5, "warning"), (0.99, "error"), (1.0, "warning")])
def test_a_signal_with_next_to_no_values_is_lost_and_one_without_any_is_not_measured(paper, noise, share, severity):
    values = paper.drive.values.copy()
    values[: round(share * len(values)), 3] = np.nan
    finding, _ = only(paper.with_streams({DRIVE: Stream(paper.drive.time, values, paper.drive.fields)}, []), noise)
    assert (finding.severity, finding.field) == (severity, "current")



def test_all_speeds_in_rpm(paper, noise):
    bad = damage.with_wrong_unit(paper, DRIVE, "speed", 30 / np.pi)
    bad = damage.with_wrong_unit(bad, DRIVE, "speed_command", 30 / np.pi)
    screened = screen_recording(bad, noise)
    assert ["speed_command and speed look as if given in rpm" in f.message for f in screened.findings] == [True]
    assert np.isnan(screened.drive.values[:, :2]).all()


@pytest.mark.parametrize(("unit", "factor"), [("rev/s", 0.5 / np.pi), ("deg/s", 180 / np.pi), ("rpm", 30 / np.pi)])
def test_speeds_in_any_unit_are_told_by_the_power_that_they_need(paper, noise, scales, unit, factor):
    bad = damage.with_wrong_unit(damage.with_wrong_unit(paper, DRIVE, "speed", factor), DRIVE, "speed_command", factor)
    finding, screened = only(bad, noise, scales)
    assert f"speed_command and speed look as if given in {unit} (factor {factor:.4g}), expected is rad/s" in finding.message
    assert np.isnan(screened.drive.values[:, :2]).all() and np.isfinite(screened.drive.values[:, 2:]).all()


def drive_with(recording, **factors):
    for field, factor in factors.items():
        recording = damage.with_wrong_unit(recording, DRIVE, field, factor)
    return recording


@pytest.mark.parametrize(("field", "factor", "said"), [
    ("electrical_power", 5.0, "electrical_power is 4.9 times sqrt(3) times voltage times current, with which torque times speed agrees"),
    ("electrical_power", 13.0, "electrical_power is 13 times sqrt(3)"), ("electrical_power", 0.1, "electrical_power is 0.098 times"),
    ("torque", 0.1, "torque is 0.1 times the torque constant times current, with which voltage and electrical power agree"),
    ("torque", 0.01, "torque is 0.01 times"), ("torque", 100.0 / 8.1, "torque looks as if given in % of rated torque (factor 12.35)"),
    ("current", 10.0, "current is 10 times torque over the torque constant, with"), ("current", 0.1, "current is 0.1 times"),
    ("current", 1000.0, "current looks as if given in mA (factor 1000)"), ("voltage", 0.1, "voltage is 0.1 times electrical power over"),
])  # fmt: skip
def test_the_channel_of_a_drive_that_disagrees_with_all_others_is_left_out_alone(paper, noise, scales, field, factor, said):
    """So that neither speed nor any sound channel is taken for one in another unit."""
    finding, screened = only(drive_with(paper, **{field: factor}), noise, scales)
    assert said in finding.message and finding.message.endswith("; not used")
    others = [name for name in DRIVE_FIELDS if name != field]
    assert np.isnan(screened.drive.column(field)).all() and all(np.isfinite(screened.drive.column(name)).all() for name in others)


@pytest.mark.filterwarnings("error")
def test_a_power_that_is_always_zero_is_found_where_its_noise_is_not_known(paper, scales):
    finding, screened = only(drive_with(paper, electrical_power=0.0), {}, scales)
    assert "electrical_power is 0 times sqrt(3) times voltage times current, while torque times speed is 868 W; not used" in finding.message
    assert np.isnan(screened.drive.column("electrical_power")).all() and np.isfinite(screened.drive.values[:, :5]).all()


@pytest.mark.parametrize(("stream", "factors"), [(DRIVE, {"torque": 20.0, "current": 20.0, "electrical_power": 20.0}),
                                                 (HYDRAULIC, {"rod_position": -1.0})])
def test_what_is_out_of_range_by_little_is_in_no_unit_a_thousand_times_as_small(paper, noise, stream, factors):
    """120 N*m that are not allowed would be 0.12 N*m."""
    recording = paper
    for field, factor in factors.items():
        recording = damage.with_wrong_unit(recording, stream, field, factor)
    said = [finding.message for finding in screen_recording(recording, noise).findings]
    assert any("out of range" in text for text in said) and not any("factor 1000" in text for text in said)


@pytest.mark.parametrize("wrong", [{"electrical_power": 8.0}, {"speed": 0.5 / np.pi, "speed_command": 0.5 / np.pi}])
def test_without_voltage_it_is_said_that_power_or_speed_is_wrong_and_all_are_kept(paper, noise, scales, wrong):
    screened = screen_recording(drive_with(paper, voltage=np.nan, **wrong), noise, scales=scales)
    (said,) = [finding.message for finding in screened.findings if finding.field != "voltage"]
    assert said.endswith("times torque times speed while the motor drives; without voltage and current it cannot be told which of them is "
                         "wrong; all are used")
    assert np.isfinite(screened.drive.values[:, [0, 1, 2, 3, 5]]).all()


@pytest.mark.parametrize("share", [0.11, 0.159])
def test_a_shaft_that_the_limit_of_current_holds_back_is_in_no_other_unit(paper, noise, scales, share):
    values = paper.drive.values.copy()
    held = paper.drive.time > 0.5 * paper.drive.time[-1]
    values[held, 1] = share * values[held, 0]
    values[held, 3] = scales.current_limit * np.sign(values[held, 0])
    values[held, 2] = scales.torque_constant * values[held, 3]
    values[held, 5] = 3.0 * scales.phase_resistance * values[held, 3] ** 2 + values[held, 2] * values[held, 1]
    values[held, 4] = values[held, 5] / (np.sqrt(3.0) * scales.current_limit)
    sizes = [noise[name] for name in ("speed", "torque", "current", "voltage", "electrical_power")]
    values[held, 1:] += np.random.default_rng(3).normal(0.0, sizes, (held.sum(), 5))
    pressed = paper.with_streams({DRIVE: drive_stream(paper.drive.time, values)})
    assert screen_recording(pressed, noise, scales=scales).findings == []
    assert "times speed_command" in only(pressed, noise)[0].message, "what the limit is stands in the rig's file"


@pytest.mark.parametrize("slower", [0.5, 0.2, 0.1, 0.05])
def test_a_motor_that_hardly_turns_under_load_is_in_no_other_unit(paper, noise, scales, slower):
    """It takes up to 20 times what it gives, nearly all for its copper."""
    values = paper.drive.values.copy()
    values[:, 5] -= (1.0 - slower) * values[:, 1] * values[:, 2]
    values[:, :2] *= slower
    values[:, :2] += np.random.default_rng(3).normal(0.0, noise["speed"], (len(values), 2))
    assert screen_recording(paper.with_streams({DRIVE: drive_stream(paper.drive.time, values)}), noise, scales=scales).findings == []


@pytest.mark.parametrize("field", ["speed", "speed_command"])
@pytest.mark.parametrize(("unit", "factor"), [("rev/s", 0.5 / np.pi), ("deg/s", 180 / np.pi)])
def test_one_speed_in_another_unit(paper, noise, field, unit, factor):
    screened = screen_recording(damage.with_wrong_unit(paper, DRIVE, field, factor), noise)
    assert [f"{field} looks as if given in {unit} (" in f.message for f in screened.findings] == [True]


@pytest.mark.parametrize(("unit", "factor"), [("bar", 1e-5), ("kPa", 1e-3), ("MPa", 1e-6), ("psi", 1 / 6894.757)])
def test_the_load_tells_the_unit_of_pressures(paper, noise, scales, unit, factor):
    one = damage.with_wrong_unit(paper, HYDRAULIC, "pressure_rod_side", factor)
    both = damage.with_wrong_unit(one, HYDRAULIC, "pressure_piston_side", factor)
    for bad in (one, both):
        screened = screen_recording(bad, noise, scales=scales)
        assert [f"in {unit} (factor {factor:.4g}), expected is Pa" in f.message for f in screened.findings] == [True]


@pytest.mark.filterwarnings("error")
def test_a_torque_that_is_always_zero_is_held_against_nothing():
    window = 200.0 * np.array([[1.0, 100.0, 100.0, 4.0], [0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 4.0, 0.0], [1.0, 10.0, 1600.0, 0.0]])
    assert judge_drive(window, UnitScales.of(load_rig())) == []


def test_without_the_load_all_units_that_fit_are_named(paper, noise):
    """12.2 is as well bar as MPa."""
    bad = damage.with_wrong_unit(paper, HYDRAULIC, "pressure_rod_side", 1e-6)
    finding, _ = only(damage.with_wrong_unit(bad, HYDRAULIC, "pressure_piston_side", 1e-6), noise)
    assert "in bar or MPa (factor 1e-05 or 1e-06), expected is Pa" in finding.message


@pytest.mark.parametrize("first", [0.0, 8.0], ids=["lifted first", "lowered first"])
def test_a_side_without_load_is_in_no_other_unit(paper, noise, scales, first):
    """The rod side lifts with 122 bar; lowered and at rest it is near the tank's pressure, by a sensor quieter than the sheet's."""
    part = paper.between(first, first + 40.0)
    values = part.hydraulic.values.copy()
    idle = values[:, 3] < 0.003
    values[idle, 1] = np.random.default_rng(1).normal(3000.0, 1500.0, idle.sum())
    sound = part.with_streams({HYDRAULIC: Stream(part.hydraulic.time, values, part.hydraulic.fields)}, [])
    screened = screen_recording(sound, noise, scales=scales)
    assert screened.findings == [] and np.isfinite(screened.hydraulic.values).all()


def test_a_side_that_has_shown_its_load_is_in_no_other_unit_though_the_load_is_not_known(paper, noise):
    """Live, a tenth of all pressures: nothing agrees with the load, and yet 12 bar were no number of kPa."""
    values = paper.hydraulic.values.copy()
    values[:, :2] *= 0.1
    screen = StreamScreen(HYDRAULIC, noise)
    screened = screen.screen(paper.hydraulic.stamps(paper.epoch_ns), values)
    assert screen.suspicions == [] and np.isfinite(screened.values).all()


@pytest.mark.parametrize("side", [0, 1])
def test_a_side_that_goes_over_to_another_unit_is_told(paper, noise, scales, side):
    """A machine's software is changed beside a twin that runs on."""
    stream, half = paper.hydraulic, len(paper.hydraulic) // 2
    values = stream.values.copy()
    values[half:, side] *= 1e-5
    screen = StreamScreen(HYDRAULIC, noise, scales=scales)
    screen.screen(stream.stamps(paper.epoch_ns), values)
    assert [(one.fields, one.unit) for one in screen.suspicions] == [((side,), "bar")]


def test_pressure_near_zero_at_rest_is_no_wrong_unit(noise):
    """A machine that stands without pressure, seen by quiet sensors, gives no evidence of bar."""
    rng = np.random.default_rng(2)
    values = np.column_stack([rng.normal(0, 50, (5000, 2)), rng.normal(0.2, 2e-4, 5000), rng.normal(0, 1e-3, 5000)])
    screen = StreamScreen(HYDRAULIC, noise)
    screen.screen(np.arange(5000) * 10_000_000, values)
    assert screen.suspicions == []


def test_a_unit_put_right_is_believed_again(paper, noise):
    screen = StreamScreen(HYDRAULIC, noise)
    half = len(paper.hydraulic) // 2
    values = paper.hydraulic.values.copy()
    values[:half, :2] *= 1e-5
    screened = screen.screen(paper.hydraulic.stamps(paper.epoch_ns)[:half], values[:half])
    assert np.isnan(screened.values[-1, :2]).all()
    assert len(screen.suspicions) == 1
    for i in range(half, len(values), 10):
        last = screen.screen(paper.hydraulic.stamps(paper.epoch_ns)[i : i + 10], values[i : i + 10])
    assert np.isfinite(last.values).all()


# Full scale


def clipped(recording, limit):
    """The recording whose piston side's transducer ends at so many Pa."""
    values = recording.hydraulic.values.copy()
    values[:, 0] = np.minimum(values[:, 0], limit)
    return recording.with_streams(dict(recording.streams()) | {HYDRAULIC: Stream(recording.hydraulic.time, values, HYDRAULIC_FIELDS)}, [])


def test_readings_at_the_full_scale_are_told_and_left_out(paper, noise, scales):
    """A transducer of 25 bar where the piston side goes to 31: what it reads there is where it ends, and not that it is stuck."""
    low = replace(scales, full_scale={"pressure": 2.5e6})
    beyond = paper.hydraulic.values[:, 0] >= 2.5e6
    assert beyond.any() and paper.hydraulic.values[:, 1].max() > 2.5e6
    part = clipped(paper, 2.5e6)
    part.hydraulic.values[:, 1] *= 0.2
    finding, screened = only(part, noise, low)
    assert np.array_equal(np.isnan(screened.hydraulic.values[:, 0]), beyond) and np.isfinite(screened.hydraulic.values[:, 1]).all()
    assert (finding.field, finding.value, finding.count, finding.severity) == ("pressure_piston_side", 2.5e6, beyond.sum(), "warning")
    assert "reads 2.5e+06 Pa at" in finding.message and "the sensor's full scale is 2.5e+06 Pa: it is saturated in" in finding.message


def test_live_readings_at_the_full_scale_are_told_alike(paper, noise, scales):
    """Sample by sample, and in the unit of the message."""
    low = replace(scales, full_scale={"temperature": ZERO_CELSIUS + 24.0, "pressure": 2.5e6})
    for topic, stream in (("temperature/tank_oil", paper.temperatures["tank_oil"]), (HYDRAULIC, clipped(paper, 2.5e6).hydraulic)):
        stamps = stream.stamps(paper.epoch_ns)
        whole, live = (StreamScreen(topic, noise, scales=low) for _ in range(2))
        at_once = whole.screen(stamps, stream.values)
        one_by_one = [live.screen(stamps[i : i + 1], stream.values[i : i + 1]).values for i in range(len(stream))]
        np.testing.assert_array_equal(np.concatenate(one_by_one), at_once.values)
        said = [str(finding) for finding in live.findings("f")]
        assert said == [str(finding) for finding in whole.findings("f")] and live.count(Cause.SATURATED) == whole.count(Cause.SATURATED) > 0
        assert ("full scale is 24 degC" if topic != HYDRAULIC else "full scale is 2.5e+06 Pa") in said[0]


def test_the_full_scale_of_the_sheet_is_that_of_every_screen(paper):
    """400 bar, by the rig file alone."""
    values = paper.hydraulic.values.copy()
    values[100, 0] = 4.0e7
    recording = paper.with_streams(dict(paper.streams()) | {HYDRAULIC: Stream(paper.hydraulic.time, values, HYDRAULIC_FIELDS)}, [])
    (finding,) = screen_by_sheet(recording, load_rig()).findings
    assert "full scale is 4e+07 Pa: it is saturated in 1 of" in finding.message


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_a_transducer_that_ends_where_nobody_said_is_saturated_and_not_stuck(paper, noise, scales, share):
    """In a recording: it repeats its largest reading, in runs as short as they may be."""
    limit = float(np.quantile(paper.hydraulic.values[:, 0], share))
    finding, screened = only(clipped(paper, limit), noise, scales)
    beyond = paper.hydraulic.values[:, 0] >= limit
    assert np.array_equal(np.isnan(screened.hydraulic.values[:, 0]), beyond) and finding.count == beyond.sum()
    assert "none is larger, and noise repeats no reading so often: it is saturated in" in finding.message


# Stuck


@pytest.mark.parametrize(
    ("stream", "field"),
    [
        (DRIVE, "speed"),
        (DRIVE, "torque"),
        (DRIVE, "electrical_power"),
        (HYDRAULIC, "pressure_piston_side"),
        (HYDRAULIC, "rod_position"),
        (HYDRAULIC, "rod_velocity"),
        *((f"temperature/{sensor}", "temperature") for sensor in TEMPERATURE_SENSORS),
    ],
)
def test_stuck_sensor(paper, noise, stream, field):
    finding, screened = only(damage.with_stuck_sensor(paper, stream, field, 100.0), noise)
    assert "is stuck: it repeats exactly" in finding.message
    assert "although noise of" in finding.message
    # from the first repetition on, however long it took to notice
    column = dict(screened.streams())[stream]
    since = column.time[column.time >= 100.0][0]
    assert finding.first_time == pytest.approx(since, abs=1e-6)
    assert f"since {since:.3f} s although" in finding.message
    values = column.column(field)
    assert np.isnan(values[column.time >= 100.0]).all()
    assert np.isfinite(values[column.time < 100.0]).all()
    assert finding.count == int(np.isnan(values).sum())


def test_live_a_stuck_sensor_is_said_since_when(paper, noise):
    """Sample by sample nothing can be taken back, but where the repetition began is told."""
    bad = damage.with_stuck_sensor(paper.between(0.0, 60.0), "temperature/tank_oil", "temperature", 20.0, 55.0)
    stream = bad.temperatures["tank_oil"]
    stamps, screen = stream.stamps(bad.epoch_ns), StreamScreen("temperature/tank_oil", noise)
    for i in range(len(stream)):
        screen.screen(stamps[i : i + 1], stream.values[i : i + 1])
    (finding,) = screen.findings("f", epoch_ns=bad.epoch_ns)
    since = stream.time[stream.time >= 20.0][0]
    assert finding.first_time > since + 5.0
    assert f"since {since:.3f} s although" in finding.message
    whole = StreamScreen("temperature/tank_oil", noise)
    whole.screen(stamps, stream.values)
    assert [str(f) for f in whole.findings("f", epoch_ns=bad.epoch_ns)] == [str(finding)]


def test_zeros_of_a_machine_that_was_off_stay_when_a_sensor_is_dead_later(paper, noise):
    values = paper.drive.values[:8000].copy()
    values[:3000] = 0.0
    values[:3000, 1] = np.random.default_rng(1).normal(0, 0.15, 3000)
    values[3000:, DRIVE_FIELDS.index("current")] = 0.0
    recording = paper.with_streams({DRIVE: drive_stream(paper.drive.time[:8000], values)})
    finding, screened = only(recording, noise)
    rejected = np.isnan(screened.drive.column("current"))
    assert not rejected[:3000].any()
    assert rejected[3000:].mean() > 0.5 and finding.count == rejected.sum()


def test_sensor_stuck_from_the_beginning(paper, noise):
    finding, _ = only(damage.with_stuck_sensor(paper, "temperature/tank_oil", "temperature", 0.0), noise)
    assert "is stuck" in finding.message
    finding, _ = only(damage.with_stuck_sensor(paper, HYDRAULIC, "pressure_rod_side", 0.0), noise)
    assert finding.first_time < 15


def test_sensor_dead_at_zero_while_the_machine_works(paper, noise):
    finding, _ = only(damage.with_value(paper, DRIVE, "current", 0.0, 100.0), noise)
    assert "current is stuck: it repeats exactly 0 A" in finding.message


def test_a_sensor_that_comes_loose_again_is_believed(paper, noise):
    finding, screened = only(damage.with_stuck_sensor(paper, HYDRAULIC, "pressure_rod_side", 50.0, 60.0), noise)
    late = screened.hydraulic.between(60.0, 1000.0)
    assert np.isfinite(late.values).all()
    assert finding.count == len(screened.hydraulic.between(50.0, 60.0))


def test_without_noise_nothing_is_stuck(paper):
    assert screen_recording(damage.with_stuck_sensor(paper, DRIVE, "speed", 50.0), {}).findings == []


# Stamps


def test_repeated_stamps(paper, noise):
    finding, screened = only(damage.with_repeated_stamps(paper, HYDRAULIC, every=100), noise)
    assert f"/ddh/{HYDRAULIC} repeats a stamp in 330 of 33325 messages, first at" in finding.message
    np.testing.assert_array_equal(screened.hydraulic.time, paper.hydraulic.time)


def test_late_repetition_is_a_repetition(paper, noise):
    stamps = paper.drive.stamps(paper.epoch_ns)[:100].copy()
    screen = StreamScreen(DRIVE, noise)
    order = [*range(100), 60, 99]
    screened = screen.screen(stamps[order], paper.drive.values[order])
    assert screened.kept.tolist() == [True] * 100 + [False] * 2
    assert screen.health()["repeated"] == 2


def test_out_of_order_is_sorted_in(paper, noise):
    finding, screened = only(damage.with_shuffled_arrival(paper, DRIVE, 0.4), noise)
    assert "messages out of order, the first is 0." in finding.message
    assert "they are sorted in" in finding.message
    np.testing.assert_array_equal(screened.drive.time, paper.drive.time)
    np.testing.assert_array_equal(screened.drive.values, paper.drive.values)


@pytest.mark.parametrize(("by", "then"), [(30.0, "begins anew"), (10.0, "goes on as warm as it is"), (3.0, "goes on as warm as it is")])
def test_clock_that_jumps_back(by, then, paper, noise):
    screened = screen_recording(damage.with_clock_jump(paper, 100.0, -by), noise)
    assert len(screened.findings) == 12  # each topic has its own clock
    for finding in screened.findings:
        assert "has a clock that jumped back once, first by " in finding.message and finding.message.endswith(f"; the twin {then} there")
        assert finding.value == pytest.approx(by, abs=0.01)  # whatever the step of the stream
    assert len(screened.drive) == len(paper.drive)
    assert int((np.diff(screened.drive.time) < 0).sum()) == 1


def test_clock_that_jumps_forward_is_a_gap(paper, noise):
    screened = screen_recording(damage.with_clock_jump(paper, 100.0, 3600.0), noise)
    for finding in screened.findings:
        assert "stopped once and came back, first after 3600." in finding.message


def test_stream_that_stops_and_comes_back(paper, noise):
    finding, _ = only(damage.without_samples(paper, HYDRAULIC, 50.0, 57.0), noise)
    assert f"/ddh/{HYDRAULIC} stopped once and came back, first after 7.0" in finding.message
    assert finding.value == pytest.approx(7.0, abs=0.02)


def test_how_long_a_stream_stopped_is_counted_from_its_newest_stamp():
    stamps = np.concatenate([np.arange(100) * 10_000_000, [990_000_000 - 395_000_000, 3_990_000_000]])
    screen = StreamScreen(DRIVE)
    screen.screen(stamps, np.zeros((stamps.size, 6)))
    assert list(screen.stops) == pytest.approx([3.0])
    screen.screen([3_700_000_000], np.zeros((1, 6)))
    screen.screen([3_800_000_000, 6_990_000_000], np.zeros((2, 6)))
    assert list(screen.stops) == pytest.approx([3.0, 3.0])


def test_some_lost_messages_are_no_gap(paper, noise):
    kept = np.random.default_rng(3).random(len(paper.drive)) > 0.3
    streams = dict(paper.streams())
    streams[DRIVE] = type(paper.drive)(paper.drive.time[kept], paper.drive.values[kept], paper.drive.fields)
    assert screen_recording(paper.with_streams(streams), noise).findings == []


# Streams beside each other


def moved(recording, topics, by):
    streams = dict(recording.streams())
    for topic in topics:
        old = streams[topic]
        streams[topic] = type(old)(old.time + by, old.values, old.fields)
    return recording.with_streams(streams)


def test_a_stream_of_another_time_is_said(paper, noise):
    finding, _ = only(moved(paper, [HYDRAULIC], 3600.0), noise)
    assert (finding.severity, finding.topic) == ("warning", f"/ddh/{HYDRAULIC}")
    assert f"/ddh/{HYDRAULIC} spans 3600.0 to 3929.9 s, /ddh/{DRIVE} 0.0 to 329.9 s" in finding.message
    assert "they have no time in common; do their clocks differ?" in finding.message
    finding, _ = only(moved(paper, [HYDRAULIC], 300.0), noise)
    assert "they have only 29." in finding.message


def test_temperatures_of_another_time_are_said(paper, noise):
    topics = [f"temperature/{sensor}" for sensor in TEMPERATURE_SENSORS]
    # against the topic that most others go with: here it is the temperatures'
    screened = screen_recording(moved(paper, topics, 1000.0), noise)
    assert {f.topic for f in screened.findings} == {f"/ddh/{DRIVE}", f"/ddh/{HYDRAULIC}"}
    assert all("temperature/ambient 1000." in f.message and "no time in common" in f.message for f in screened.findings)


def test_a_sensor_that_begins_late_or_ends_early_is_no_stranger_and_said(paper, noise):
    recording = damage.without_samples(paper, HYDRAULIC, -1.0, 300.0)
    recording = damage.without_samples(recording, "temperature/line_a", 20.0, 1e9)
    late, early = screen_recording(recording, noise).findings
    assert f"/ddh/{HYDRAULIC} begins at 300.0 s of the recording, 300.0 s after its begin" in late.message
    assert "/ddh/temperature/line_a ends at 19." in early.message and "before its end: nothing is known of it there" in early.message


def test_some_seconds_at_an_end_are_not_told(paper, noise):
    assert screen_recording(damage.without_samples(paper, HYDRAULIC, 326.0, 1e9), noise).findings == []


# One implementation


@pytest.mark.parametrize("chunk", [1, 7, 10, 1000])
def test_chunks_are_judged_like_the_whole(paper, noise, chunk):
    part = paper.between(0.0, 40.0)
    bad = damage.with_value(part, DRIVE, "torque", np.nan, 3.0, 3.5)
    bad = damage.with_stuck_sensor(bad, DRIVE, "speed", 10.0, 14.0)
    bad = damage.with_repeated_stamps(damage.with_shuffled_arrival(bad, DRIVE, 0.3), DRIVE, 50)
    stamps, values = bad.drive.stamps(bad.epoch_ns), bad.drive.values
    whole = StreamScreen(DRIVE, noise)
    expected = whole.screen(stamps, values)
    pieces = StreamScreen(DRIVE, noise)
    got = [pieces.screen(stamps[i : i + chunk], values[i : i + chunk]) for i in range(0, len(stamps), chunk)]
    np.testing.assert_array_equal(np.concatenate([g.flags for g in got]), expected.flags)
    np.testing.assert_array_equal(np.concatenate([g.values for g in got]), expected.values)
    assert pieces.health() == whole.health()
    assert [str(f) for f in pieces.findings("f")] == [str(f) for f in whole.findings("f")]
    assert {"not_a_number", "stuck", "repeated", "out_of_order"} <= {k for k, v in whole.health().items() if v}


def test_flags_and_counts_agree(paper, noise):
    bad = damage.with_value(paper.between(0.0, 20.0), HYDRAULIC, "rod_velocity", np.nan, 3.0, 3.5)
    screen = StreamScreen(HYDRAULIC, noise)
    _, values, flags = screen.screen(bad.hydraulic.stamps(bad.epoch_ns), bad.hydraulic.values)
    marked = (flags & Cause.NOT_A_NUMBER) > 0
    assert marked.sum() == screen.count(Cause.NOT_A_NUMBER) == screen.count(Cause.NOT_A_NUMBER, "rod_velocity")
    assert screen.count(Cause.NOT_A_NUMBER, "rod_position") == 0
    np.testing.assert_array_equal(marked, np.isnan(values))
    assert json.dumps(screen.health())
    assert screen.period == pytest.approx(0.01, rel=0.05)


def test_variance_passes_unchanged(noise):
    screen = StreamScreen("temperature/ambient", noise)
    screened = screen.screen([1, 2], [[296.0, 0.04], [296.1, 0.04]])
    assert screened.values[:, 1].tolist() == [0.04, 0.04]
    assert screened.flags.shape == (2, 1)


def test_input_is_not_changed(noise):
    values = np.array([[1.0, 2.0, 3.0, 4.0, 5.0, np.inf]])
    StreamScreen(DRIVE, noise).screen([1], values)
    assert np.isinf(values[0, 5])


def test_unknown_topic_is_named():
    with pytest.raises(KeyError, match="nearest is 'drive/telemetry'"):
        StreamScreen("drive/telemetri")


def test_every_signal_has_its_place(noise):
    assert len({s.name for s in SIGNALS}) == len(SIGNALS) == 20
    for signal in SIGNALS:
        assert signal.lowest < signal.highest
        assert signal.noise_key is None or signal.noise_key in noise
