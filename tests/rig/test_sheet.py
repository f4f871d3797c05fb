"""The data sheet: what is read, what is refused, what is drawn."""

import numpy as np
import pytest
from ddh_twin_py.rig import RigError, load_rig


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


@pytest.mark.parametrize("text, expected", [
    ("pump_1:\n  leekage: {value: 1.0}\n", "pump_1.leekage: no such entry; the nearest is 'pump_1.leakage'"),
    ("pump_1:\n  leakage: {value: lots}\n", "pump_1.leakage: value is 'lots'"),
    ("pump_1:\n  leakage: {value: .nan}\n", "finite number"),
    ("pump_1:\n  leakage: {value: 1.0, unit: l/min}\n", "unit is 'l/min'"),
    ("pump_1: 3\n", "expected {value, unit, tolerance, source}"),
    ("[1, 2]\n", "mapping"),
    ("a: [\n", "is not YAML"),
    ("sensors:\n  presure: {noise: 1.0, unit: Pa}\n", "nearest is 'sensors.pressure'"),
])
def test_what_cannot_be_used_is_named(tmp_path, text, expected):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(RigError) as error:
        load_rig(file)
    assert str(file) in str(error.value) and expected in str(error.value)
    assert "\n" not in str(error.value)


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
