"""The data sheet: what is read, what is refused, what is drawn."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ddh_twin_py.rig import RigError, load_rig
from ddh_twin_py.rig.bounds import bound_of, contradiction
from ddh_twin_py.rig.sheet import BOUNDS, SensorSpec


def test_reference_has_value_unit_tolerance_and_source():
    rig = load_rig()
    quantity = rig.quantities["pump_1.leakage"]
    assert (quantity.value, quantity.unit, quantity.tolerance) == (1.3e-12, "m3/(s*Pa)", 0.15)
    assert all(q.source for path, q in rig.quantities.items() if not path.startswith('sensors.')), 'no source'
    assert rig.parameters["motor_yoke_to_housing"][0] == rig["motor.thermal.yoke_to_housing"]


def test_a_partial_file_changes_only_what_it_names(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("rig_id: mine\npump_1:\n  leakage: {value: 2.0e-12, unit: m3/(s*Pa)}\n")
    rig = load_rig(file)
    assert rig.rig_id == "mine"
    assert rig["pump_1.leakage"] == 2.0e-12
    assert rig["pump_2.leakage"] == load_rig()["pump_2.leakage"]


def test_what_a_row_of_a_sensor_leaves_out_is_the_sheets_and_what_it_says_is_its_own(tmp_path):
    file, sheet = tmp_path / "mine.yaml", load_rig()
    file.write_text("sensors:\n  temperature: {noise: 0.2, unit: K}\n  pressure: {noise: 3.0e+4, unit: Pa}\n")
    rig = load_rig(file)
    assert rig.sensors["temperature"] == replace(sheet.sensors["temperature"], noise=0.2)
    assert rig.sensors["pressure"] == replace(sheet.sensors["pressure"], noise=3.0e4)
    assert rig.zero_error("tank_oil") == sheet.zero_error("tank_oil") == (0.0, 0.3)
    file.write_text("sensors:\n  pressure: {noise: 3.0e+4, unit: Pa, offset_tolerance: 0, full_scale: null}\n")
    assert load_rig(file).sensors["pressure"] == SensorSpec(3.0e4, "Pa")


@pytest.mark.parametrize("written, value", [("1.3e7", 1.3e7), ("13E+6", 1.3e7), ("1.3e+7", 1.3e7), ("13.e6", 1.3e7), ("13000000", 1.3e7)])
def test_a_number_is_understood_however_its_exponent_is_written(tmp_path, written, value):
    file = tmp_path / "mine.yaml"
    file.write_text(f"relief_valve:\n  opening_pressure: {{value: {written}, unit: Pa, tolerance: 3e-2}}\n")
    quantity = load_rig(file).quantities["relief_valve.opening_pressure"]
    assert (quantity.value, quantity.tolerance) == (value, 0.03)


def test_an_oil_may_be_named_by_its_grade(tmp_path):
    file, sheet = tmp_path / "mine.yaml", load_rig()
    for grade in ("ISO VG 46", "46", "vg 46"):
        file.write_text(f"oil:\n  grade: {grade}\n  air_fraction: {{value: 0.01}}\n")
        rig, filled = load_rig(file), sheet.with_oil("ISO VG 46")
        assert all(rig[path] == filled[path] for path in ("oil.walther_a", "oil.walther_b", "oil.density_15C"))
        assert rig["oil.air_fraction"] == 0.01 and rig["pump_1.leakage"] == sheet["pump_1.leakage"]
        assert rig.quantities["oil.walther_a"].tolerance == sheet.quantities["oil.walther_a"].tolerance
    file.write_text("oil:\n  grade: ISO VG 46\n  density_15C: {value: 880, unit: kg/m3}\n")
    assert load_rig(file)["oil.density_15C"] == 880.0  # the supplier's own number stands before the grade's


@pytest.mark.parametrize("row, changed", [
    ("{offset_tolerance: 0.5, unit: K}", {"offset_tolerance": 0.5}), ("{full_scale: 473.15, unit: K}", {"full_scale": 473.15}),
    ("{time_constant: {value: 9, unit: s}}", {}), ("{unit: K}", {}),
])
def test_a_sensor_row_without_noise_has_that_of_the_sheet(row, changed, tmp_path):
    (tmp_path / "rig.yaml").write_text(f"sensors:\n  temperature: {row}\n")
    rig = load_rig(tmp_path / "rig.yaml")
    assert rig.sensors["temperature"] == replace(load_rig().sensors["temperature"], **changed)
    assert rig["sensors.temperature.time_constant"] == (9.0 if "time_constant" in row else 6.0)


@pytest.mark.parametrize("text, expected", [
    ("pump_1:\n  leekage: {value: 1.0}\n", "pump_1.leekage: no such entry; the nearest is 'pump_1.leakage'"),
    ("pump_1:\n  leakage: {value: lots}\n", "pump_1.leakage: value is 'lots'"),
    ("pump_1:\n  leakage: {value: .nan}\n", "finite number"),
    ("oil:\n  bulk_modulus: {value: 1e999}\n", "value is '1e999', a finite number is needed"),
    ("oil:\n  bulk_modulus: {value: e9}\n", "value is 'e9', a finite number is needed"),
    ("oil:\n  grade: ISO VG 45\n", "oil.grade: no oil grade 'ISO VG 45'; the nearest is 'ISO VG 46'"),
    ("oil:\n  grade: [46]\n", "oil.grade: found [46], the name of a grade is needed"),
    ("pump_1:\n  leakage: {value: 1.0, unit: l/min}\n", "unit is 'l/min'"),
    ("pump_1:\n  leakage: {value: 1.3e-12}\n", "pump_1.leakage: unit is missing, this entry is in 'm3/(s*Pa)'"),
    ("sensors:\n  speed: {noise: 0.1}\n", "sensors.speed: unit is missing, this sensor is in 'rad/s'"),
    ("pump_1:\n  leakage: {unit: m3/(s*Pa), tolerance: 0.1}\n", "pump_1.leakage: value is missing beside unit"),
    ("cylinder: {stroke: {value: 0,45, unit: m}}\n",
     "cylinder.stroke.45: an entry has no key 45; valid are value, unit, tolerance, std, source; "
     "is it behind a decimal comma?"),
    ("cylinder:\n  - stroke: {value: 0.45, unit: m}\n", "cylinder: found a list, expected {value, unit, tolerance, source}"),
    ("pump_1: 3\n", "expected {value, unit, tolerance, source}"),
    ("[1, 2]\n", "mapping"),
    ("a: [\n", "is not YAML"),
    ("rig_id: 2026-13-45\n", "is not YAML (line 1): '2026-13-45' is no timestamp: month must be in 1..12"),
    ("sensors:\n  presure: {noise: 1.0, unit: Pa}\n", "nearest is 'sensors.pressure'"),
    ("motr: {}\n", "motr: no such entry; the nearest is 'motor'"),
    ("motr:\n  pole_pairs: {value: 4}\n", "motr: no such entry; the nearest is 'motor'"),
    ("sesors:\n  temperature: {noise: 0.1, unit: K}\n", "sesors: no such entry; the nearest is 'sensors'"),
    ("motor:\n  iron:\n    alfa: {}\n", "motor.iron.alfa: no such entry; the nearest is 'motor.iron.alpha'"),
    ("pump_1:\n  leakage: {}\n", "pump_1.leakage: value is missing; an entry is {value, unit, tolerance, source}"),
    ("pump_1:\n  leekage: {}\n", "pump_1.leekage: no such entry; the nearest is 'pump_1.leakage'"),
    ("pump_1:\n", "pump_1: value is missing; an entry is {value, unit, tolerance, source}"),
    ("pump_1:\n  leakage: {value: , unit: m3/(s*Pa)}\n", "pump_1.leakage: value is missing, a finite number is needed"),
    ("pump_1:\n  leakage: {value: 1.3e-12, unit: }\n", "pump_1.leakage: unit is missing, this entry is in 'm3/(s*Pa)'"),
    ("pump_1:\n  leakage: {value: 1.0, source: }\n", "pump_1.leakage.source: value is nothing, a text is needed"),
    ("rig_id:\n", "rig_id: found nothing, a name is needed"),
    ("sensors: {speed: }\n", "sensors.speed: found nothing, expected some of {noise, unit, offset_tolerance, full_scale, time_con"),
    ("sensors: {speed: {}}\n", "sensors.speed: found {}, expected some of {noise, unit, offset_tolerance, full_scale, time_constant, sour"),
    ("sensors: {speed: {noise: , unit: rad/s}}\n", "sensors.speed.noise: value is missing, a finite number is needed"),
    ("sensors: {temperature: {offset_tolerance: 0.5}}\n", "sensors.temperature: unit is missing, this sensor is in 'K'"),
    ("sensors:\n", "sensors: found nothing, a mapping of sensors is needed"),
    ("sensors: []\n", "sensors: found [], a mapping of sensors is needed"),
    ("sensors:\n  presure: 5\n", "sensors.presure: no such entry; the nearest is 'sensors.pressure'"),
    ("sensors:\n  tank_oill: {noise: {value: 0.1, unit: K}}\n", "sensors.tank_oill: no such entry; the nearest is 'sensors.torque'"),
    ("sensors:\n  temperatur: {noise: abc}\n", "sensors.temperatur: no such entry; the nearest is 'sensors.temperature'"),
    ("sensors:\n  speed: {noize: 0.1, unit: rad/s}\n", "sensors.speed.noize: a sensor has no key 'noize'; the nearest is 'noise'"),
    ("sensors:\n  temperature: {noise: 0.1, unit: K, offset_tolerence: 1.0}\n", "nearest is 'offset_tolerance', valid are noise, unit,"),
    ("sensors: [1]\n", "sensors: found [1], a mapping of sensors is needed"),
    ("sensors: abc\n", "sensors: found 'abc'"),
    ("sensors:\n  speed: {noise: -0.1}\n", "sensors.speed.noise: value is -0.1 rad/s, allowed are 0.00015 to 150 rad/s"),
    ("sensors:\n  speed: {noise: 0}\n", "sensors.speed.noise: value is 0"),
    ("sensors:\n  speed: {noise: 0.1, unit: rpm}\n", "sensors.speed: unit is 'rpm', this sensor is in 'rad/s'"),
    ("sensors:\n  pressure: {noise: 2.0e+4, unit: Pa, offset_tolerance: -1}\n", "sensors.pressure.offset_tolerance: value is -1"),
    ("sensors:\n  pressure: {noise: 2.0e+4, full_scale: wide}\n", "sensors.pressure.full_scale: value is 'wide'"),
    ("sensors:\n  pressure: {noise: 2.0e+4, unit: Pa, full_scale: -4.0}\n", "sensors.pressure.full_scale: value is -4"),
    ("sensors:\n  temperature: {unit: K, full_scale: 200}\n", "sensors.temperature.full_scale: value is 200 K; it is the largest"),
    ("sensors:\n  temperature: {noise: 0.1, time_constant: 6}\n", "sensors.temperature.time_constant: found 6"),
    ('rig_id: "\\ud800"\n', "rig_id: value is '\\ud800', it holds half a character (a lone surrogate)"),
    ('pump_1:\n  leakage: {value: 1.0, source: "x\\udfff"}\n', "pump_1.leakage.source: value is 'x\\udfff', it holds half"),
    ('pump_1: {"\\ud800": 1}\n', "pump_1: key is '\\ud800', it holds half"),
    ("rig_id: [1]\n", "rig_id: found [1], a name is needed"),
    ("rig_id: yes\n", "rig_id: found True, a name is needed; put it in quotes"),
    ("rig_id: 2026-05-01\n", "rig_id: found 2026-05-01, a name is needed; put it in quotes"),
    ("x" * 900_000, "bad.yaml: holds 'xxxxxxxx"),
    ("motor:\n  torque_constant: {value: " + 5000 * "9" + "}\n", "... is no int: it has 5000 digits"),
    ("motor:\n  torque_constant: {value: 0x" + 5000 * "f" + "}\n", "torque_constant: value is a number of thousands of digits, a finite"),
    ("motor:\n  torque_constant: {value: 1.6, unit: " + 900_000 * "u" + "}\n", "motor.torque_constant: unit is 'uuuuuuuu"),
    ("motor:\n  torque_constant: {value: 1:30, unit: N*m/A}\n",
     "(line 2): '1:30' is no int: YAML takes numbers with ':' between them as one to the base 60; put a time or a name in quotes"),
    ("motor:\n  torque_constant: {value: 1:30.5, unit: N*m/A}\n", "(line 2): '1:30.5' is no float: YAML takes numbers with ':'"),
    ("rig_id: 20:30:00\n", "(line 1): '20:30:00' is no int: YAML takes numbers with ':' between them as one to the base 60"),
    ("motor:\n  pole_pairs: {value: 2.5}\n", "motor.pole_pairs: value is 2.5, a whole number is needed"),
    ("motor:\n  pole_pairs: {value: 0}\n", "motor.pole_pairs: value is 0, allowed are 1 to 60"),
    ("rig_id: 007\n", "(line 1): '007' is no int: YAML takes a number that begins with 0 as octal; put a name in quotes, and"),
    ("pump_1:\n  leakage: {value: 010, unit: m3/(s*Pa)}\n", "(line 2): '010' is no int: YAML takes a number that begins with 0 as"),
    ("pump_1:\n  leakage: {value: 1.3e-12, tolerance: -0.1}\n", "pump_1.leakage.tolerance: value is -0.1, allowed are 0 to 1"),
    ("pump_1:\n  leakage: {value: 1.3e-12, std: -1.0e-13}\n", "pump_1.leakage.std: value is -1e-13"),
    ("pump_1:\n  leakage: {value: 1" + 400 * "0" + "}\n", "pump_1.leakage: value is 1000"),
    ("tank:\n  wall_capacity: {value: 0}\n", "tank.wall_capacity: value is 0 J/K, allowed are 23 to 2.3e+05 J/K"),
    ("cylinder:\n  bore: {value: 60}\n", "cylinder.bore: value is 60 m, allowed are"),
    ("cylinder:\n  rod: {value: 0.07, unit: m}\n", "cylinder.rod: value is 0.07 m, with cylinder.bore 0.06 m at most"),
    ("oil:\n  walther_b: {value: 3.0}\n", "cSt at 23 degC, allowed are 2 to 3000 cSt"),
    ("tank:\n  emissivity: {value: 1.2}\n", "tank.emissivity: value is 1.2, allowed are 0 to 1"),
    ("tank:\n  emissivity: {value: 0.9, sigma: 3}\n", "tank.emissivity.sigma: an entry has no key 'sigma'; valid are value"),
    ("tank:\n  emissivity: {value: 0.9, toleranc: 3}\n", "no key 'toleranc'; the nearest is 'tolerance', valid are"),
    ("tank:\n  emissivity: {value: 0.9, 7: 3}\n", "tank.emissivity.7: an entry has no key 7"),
    ("tank:\n  emissivity: {value: 0.9, source: 2024}\n", "tank.emissivity.source: value is 2024, a text is needed"),
    ("tank:\n  emissivity: {value: 0.9, value: 0.8}\n", "tank.emissivity.value: given twice, in lines 2 and 2"),
    ("tank:\n  emissivity: {value: 0.9}\nambient: {value: 20}\ntank:\n  area: {value: 1}\n", "tank: given twice, in lines 1 and 4"),
    ("cylinder: &a {bore: *a}\n", "cylinder.bore: is an alias to what it lies in itself, which begins in line 1"),
    ("cylinder: &a\n  bore: [{value: *a}]\n", "cylinder.bore.value: is an alias to what it lies in itself"),
    ("- &a [*a]\n", "bad.yaml: is an alias to what it lies in itself"),
    ("measurement:\n  pressure_rod_side_offset: {value: 0, unit: Pa, std: 1.0e+9}\n",
     "_offset.std: value is 1e+09 Pa, allowed are 0 to 2e+07 Pa"),
    ("pump_1:\n  leakage: {value: 2.0e-12, unit: m3/(s*Pa), std: 3.0e-12}\n",
     "pump_1.leakage.std: value is 3e-12 m3/(s*Pa), allowed are 0 to 2e-12"),
])
def test_what_cannot_be_used_is_named(tmp_path, text, expected):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(RigError) as error:
        load_rig(file)
    assert str(file) in str(error.value) and expected in str(error.value)
    assert "\n" not in str(error.value) and len(str(error.value)) < 1000


def test_a_name_in_quotes_may_look_like_a_time(tmp_path):
    file = tmp_path / "named.yaml"
    file.write_text("rig_id: '20:30:00'\nmotor:\n  pole_pairs: {value: 4, source: '12:45, of the name plate'}\n")
    assert load_rig(file).rig_id == "20:30:00" and load_rig(file)["motor.pole_pairs"] == 4.0


def test_a_file_that_is_nested_too_deep_is_named(tmp_path):
    file = tmp_path / "deep.yaml"
    file.write_text("tank: " + 4000 * "[" + 4000 * "]")
    with pytest.raises(RigError, match="deep.yaml: is nested too deep to be read"):
        load_rig(file)


def test_what_is_no_regular_file_or_too_large_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    (tmp_path / "large.yaml").write_text("x" * 1_000_001)
    for file, said in ((tmp_path / "pipe.yaml", "it is a named pipe, a regular file is needed"), (tmp_path, "Is a directory"),
                       (Path("/dev/zero"), "it is a character device, a regular file is needed"),
                       (tmp_path / "large.yaml", "it has 1000001 bytes, allowed are 1000000")):
        with pytest.raises(RigError) as error:
            load_rig(file)
        assert str(error.value) == f"{file}: cannot be read as a rig file: {said}"


def test_a_fitted_value_near_0_may_keep_its_priors_deviation(tmp_path):
    file = tmp_path / "fitted.yaml"
    file.write_text("pump_1:\n  leakage: {value: 0.0, unit: m3/(s*Pa), std: 1.0e-13}\n")
    assert load_rig(file).quantities["pump_1.leakage"].standard_deviation == 1.0e-13


def test_an_alias_and_a_merge_are_no_duplicates(tmp_path):
    file = tmp_path / "merged.yaml"
    file.write_text("pump_1:\n  leakage: &a {value: 2.0e-12, unit: m3/(s*Pa), source: bench}\n"
                    "pump_2:\n  leakage: {<<: *a, value: 1.0e-12}\n")
    rig = load_rig(file)
    assert (rig["pump_1.leakage"], rig["pump_2.leakage"], rig.quantities["pump_2.leakage"].source) == (2.0e-12, 1.0e-12, "bench")


def test_a_sheet_may_be_of_every_unit_and_a_rig_file_of_its_own(tmp_path):
    file = tmp_path / "rig.yaml"
    file.write_text("rig_id: crane_1\n", encoding="utf-8")
    assert all(load_rig().may_be_of(name) for name in ("crane_1", "crane_2", ""))
    assert [load_rig(file).may_be_of(name) for name in ("crane_1", "crane_2", "")] == [True, False, True]
    assert [load_rig(file).of_another(name) for name in ("crane_1", "crane_2", "")] == [
        "", "the rig file describes crane_1 and the recording is of crane_2", ""]


def test_missing_file_is_named():
    with pytest.raises(RigError, match="no/such.yaml: no such rig file"):
        load_rig("no/such.yaml")


def test_draws_have_the_sheets_spread_and_cut():
    sheet, rng = load_rig(), np.random.default_rng(0)
    drawn = np.array([sheet.draw(rng)["pump_1.leakage"] for _ in range(400)]) / sheet["pump_1.leakage"] - 1.0
    assert abs(drawn.mean()) < 4 * 0.15 / 20
    assert drawn.std() == pytest.approx(0.15, rel=0.15)
    assert np.abs(drawn).max() <= 2.5 * 0.15 + 1e-12
    assert sheet.draw(rng)["cylinder.bore"] == sheet["cylinder.bore"]


def test_every_quantity_of_the_reference_sheet_has_a_bound_and_keeps_it():
    rig = load_rig()
    assert BOUNDS.keys() == rig.quantities.keys()
    for path, quantity in rig.quantities.items():
        bound = BOUNDS[path]
        assert bound.lowest < bound.highest and bound.holds(quantity.value), path
        # also at the ends of its tolerance, so that draws are not cut
        for end in (-2.5, 2.5):
            assert bound.holds(quantity.value * (1.0 + end * quantity.tolerance)), path
    assert contradiction({path: q.value for path, q in rig.quantities.items()}) == ""
    with pytest.raises(KeyError, match="pump_3.bend"):
        bound_of("pump_3.bend", 1.0)


@pytest.mark.parametrize("path", BOUNDS)
def test_no_quantity_may_be_negative_or_a_billion_times_off(tmp_path, path):
    reference, file = load_rig().quantities[path], tmp_path / "bad.yaml"
    wrong = (-abs(reference.value) * 20.0 - 1.0, abs(reference.value) * 1e9 + 10.0, 1e300)
    for value in wrong if reference.value else (-1e300, 1e300):  # 0 is neutral, and says nothing of the size
        section, *rest = path.split(".")
        text = "".join(f"{'  ' * k}{part}:\n" for k, part in enumerate(path.split(".")))
        text += f"{'  ' * (len(rest) + 1)}{{value: {value!r}}}\n"
        if section == "sensors":
            text = text.replace("    time_constant:", "    noise: 0.1\n    unit: K\n    time_constant:")
        file.write_text(text)
        with pytest.raises(RigError, match="allowed are|finite") as error:
            load_rig(file)
        assert str(file) in str(error.value) and path in str(error.value)


def test_draws_stay_within_bounds(tmp_path):
    file = tmp_path / "vague.yaml"
    file.write_text(
        "tank:\n  emissivity: {value: 0.95, tolerance: 0.5}\npump_1:\n  leakage: {value: 1.0e-12, unit: m3/(s*Pa), tolerance: 1.0}\n"
        "cylinder:\n  rod: {value: 0.055, unit: m, tolerance: 0.2}\noil:\n  walther_b: {value: 3.747, tolerance: 0.1}\n"
    )
    sheet, rng = load_rig(file), np.random.default_rng(1)
    for _ in range(200):
        drawn = sheet.draw(rng)
        assert all(BOUNDS[path].holds(q.value) for path, q in drawn.quantities.items())
        assert contradiction({path: q.value for path, q in drawn.quantities.items()}) == ""
