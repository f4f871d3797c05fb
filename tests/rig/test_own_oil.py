"""A rig's coefficients are stated at its own oil's viscosity; another oil filled in later does not move them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.physics.oil import viscosity_ratio
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.own_oil import REFERENCE, of_own_oil, refer_to_own_oil, viscosity_at_reference
from ddh_twin_py.rig.writer import rig_text


def ratio_at_reference(rig):
    return viscosity_ratio(296.15, rig.parameters[0])


def test_the_sheets_number_is_its_oils_viscosity():
    sheet = load_rig()
    by_law = viscosity_at_reference(*(sheet[f"oil.{name}"] for name in ("walther_a", "walther_b", "density_15C", "thermal_expansion")))
    assert sheet[REFERENCE] == pytest.approx(by_law, rel=1e-12)


def test_coefficients_of_every_drawn_rig_hold_at_23_degrees_with_its_own_oil():
    sheet, rng = load_rig(), np.random.default_rng(4)
    drawn = [sheet.draw(rng) for _ in range(20)]
    assert np.ptp([rig[REFERENCE] for rig in drawn]) > 0.2 * sheet[REFERENCE]  # the oil does differ
    assert [ratio_at_reference(rig) for rig in drawn] == pytest.approx([1.0] * 20, rel=1e-9)


def test_another_oil_is_thinner_or_thicker_than_the_one_the_coefficients_were_found_with():
    own = load_rig().built_as({"oil.walther_b": 3.74}, "built so")
    assert ratio_at_reference(own) == pytest.approx(1.0, rel=1e-9)
    filled = own.with_oil("ISO VG 46")
    assert filled[REFERENCE] == own[REFERENCE] > load_rig()[REFERENCE]
    assert 1.0 < ratio_at_reference(filled) < 1.5


def test_what_leaves_the_oil_alone_leaves_the_number_alone():
    sheet = load_rig()
    assert sheet.built_as({"pump_1.leakage": 1.0e-12}, "built so").quantities[REFERENCE] == sheet.quantities[REFERENCE]
    assert REFERENCE.split(".")[1] not in rig_text(sheet.built_as({"pump_1.leakage": 1.0e-12}, "built so"))
    assert "reference_viscosity" in rig_text(sheet.built_as({"oil.walther_b": 3.74}, "built so"))


def test_records_and_rigs_agree():
    sheet = load_rig()
    record = sheet.parameters
    record["oil_walther_b"] -= 0.007
    refer_to_own_oil(record, sheet.parameters)
    quantities = dict(sheet.quantities)
    quantities["oil.walther_b"] = replace(quantities["oil.walther_b"], value=sheet["oil.walther_b"] - 0.007)
    own = float(record["oil_reference_viscosity"][0])
    assert of_own_oil(quantities, sheet.quantities)[REFERENCE].value == pytest.approx(own, rel=1e-12)
    assert math.log(own / sheet[REFERENCE]) > 0.1
