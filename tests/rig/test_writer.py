"""A rig as a file: what is written is what is read."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.rig import Quantity, RigError, load_rig
from ddh_twin_py.rig.numbers import finite_number
from ddh_twin_py.rig.writer import rig_text, write_rig


def _same(a, b):
    assert a.rig_id == b.rig_id
    assert dict(a.quantities) == dict(b.quantities)
    assert dict(a.sensors) == dict(b.sensors)


def test_a_drawn_rig_is_read_back_exactly(tmp_path):
    rig = replace(load_rig().draw(np.random.default_rng(3)), rig_id="on")  # a name that YAML would take for true
    _same(load_rig(write_rig(tmp_path / "new" / "rig.yaml", rig)), rig)


def test_deviations_sources_zero_errors_and_sensors_are_read_back_exactly(tmp_path):
    rig = load_rig()
    quantities = dict(rig.quantities)
    odd = 'fitted to "a: b", {c} # d, lifted – ° \'e\''
    quantities["pump_1.leakage"] = replace(quantities["pump_1.leakage"], value=1.0e-12 / 3.0, std=1.0e-14 / 7.0, source=odd)
    quantities["oil.bulk_modulus"] = replace(quantities["oil.bulk_modulus"], value=1e9, std=1e-5)
    for path, unit, value in (("measurement.pressure_rod_side_offset", "Pa", -31234.5), ("measurement.tank_oil_offset", "K", 0.123)):
        quantities[path] = Quantity(value, unit, 0.0, "fitted", abs(value) * 3.0)
    lag = "sensors.temperature.time_constant"
    quantities[lag] = replace(quantities[lag], value=7.25, std=0.5)
    sensors = {**rig.sensors, "pressure": replace(rig.sensors["pressure"], noise=3.0e4, full_scale=None)}
    rig = replace(rig, quantities=quantities, sensors=sensors)
    read = load_rig(write_rig(tmp_path / "rig.yaml", rig, "first line\nsecond line"))
    _same(read, rig)
    assert read.zero_error("pressure_rod_side") == (-31234.5, 3.0 * 31234.5)
    assert read.zero_error("tank_wall") == (0.0, rig.sensors["temperature"].offset_tolerance)
    assert read.zero_error("ambient") == (0.0, rig.sensors["temperature"].offset_tolerance)


def test_only_what_differs_is_written():
    assert rig_text(load_rig()) == "rig_id: ddh_reference\n"
    text = rig_text(load_rig().with_values({"pump_1.leakage": 2e-12}), "why")
    assert text.splitlines()[0] == "# why" and "leakage" in text and "pump_2" not in text


def test_a_heading_with_what_no_comment_may_hold_is_spelled_out_and_read_back(tmp_path):
    rig = load_rig().with_values({"pump_1.leakage": 2e-12})
    path = write_rig(tmp_path / "rig.yaml", rig, "of \x1b[31mred\x00 \udcff\x7f – °\nrig_id: second\x85rig_id: third")
    _same(load_rig(path), rig)
    assert path.read_text("utf8").startswith("# of \\x1b[31mred\\x00 \\udcff\\x7f – °\n# rig_id: second\n# rig_id: third\n")


@pytest.mark.parametrize("path, value, said", [
    ("tank.wall_capacity", 1.0, "tank.wall_capacity: value is 1 J/K, allowed are 23 to"),
    ("tank.wall_capacity", float("nan"), "tank.wall_capacity: value is nan"),
    ("cylinder.rod", 0.0599, "with cylinder.bore"),
])
def test_what_could_not_be_read_is_not_written(tmp_path, path, value, said):
    with pytest.raises(RigError, match=said):
        write_rig(tmp_path / "rig.yaml", load_rig().with_values({path: value}))
    assert not list(tmp_path.iterdir())


def test_a_fitted_rig_is_drawn_within_its_fitted_deviation():
    rig = load_rig()
    path = "pump_1.leakage"
    rig = replace(rig, quantities={**rig.quantities, path: replace(rig.quantities[path], std=1.0e-14)})
    drawn = np.array([rig.draw(np.random.default_rng(i))[path] for i in range(60)])
    assert 0.5e-14 < drawn.std() < 1.5e-14


@pytest.mark.parametrize("value", [True, "3", None, float("inf"), float("nan"), 10**400])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(RigError, match="^rig.yaml: here: value is .*, a finite number is needed$"):
        finite_number("rig.yaml: here", value, RigError)
    assert finite_number("there", 3, RigError) == 3.0
