"""Oils by grade: viscosity index, Walther constants, a rig with another oil."""

import pytest
from ddh_twin_py.rig import RigError, load_rig
from ddh_twin_py.rig.oil_grades import oil_grade, oil_grades, viscosity_at_100, viscosity_index


@pytest.mark.parametrize("at_40, at_100, index", [
    (73.30, 8.86, 92),  # ASTM D2270, example of procedure A
    (22.83, 5.05, 156),  # ASTM D2270, example of procedure B
])
def test_viscosity_index_of_the_standards_examples(at_40, at_100, index):
    assert viscosity_index(at_40, at_100) == pytest.approx(index, abs=0.6)


@pytest.mark.parametrize("name", list(oil_grades()))
def test_walther_goes_through_both_viscosities(name):
    grade = oil_grade(name)
    assert grade.viscosity(40.0) == pytest.approx(grade.viscosity_40C, rel=1e-9)
    assert grade.viscosity(100.0) == pytest.approx(grade.viscosity_100C, rel=1e-9)
    assert viscosity_index(grade.viscosity_40C, grade.viscosity_100C) == pytest.approx(grade.viscosity_index, abs=0.5)


def test_a_higher_index_is_thinner_in_the_cold_and_thicker_in_the_heat():
    plain, multigrade = oil_grade("32"), oil_grade("HVLP 32")
    assert multigrade.viscosity(-20.0) < 0.6 * plain.viscosity(-20.0)
    assert viscosity_at_100(32.0, 150.0) > viscosity_at_100(32.0, 100.0)


def test_vg_32_is_close_to_the_sheets_oil_and_keeps_the_reference_viscosity():
    sheet = load_rig()
    filled = sheet.with_oil("vg 32")
    a, b = sheet["oil.walther_a"], sheet["oil.walther_b"]
    for celsius in (0.0, 23.0, 60.0):
        import math

        of_sheet = 10.0 ** 10.0 ** (a - b * math.log10(celsius + 273.15)) - 0.7
        assert oil_grade("ISO VG 32").viscosity(celsius) == pytest.approx(of_sheet, rel=0.05)
    assert filled.parameters["oil_reference_viscosity"] == sheet.parameters["oil_reference_viscosity"]
    assert filled.quantities["oil.walther_a"].source == "oil_grades.yaml, ISO VG 32"


def test_an_unknown_grade_names_the_nearest():
    with pytest.raises(RigError, match="no oil grade 'VG 33'; the nearest is 'ISO VG 32', valid are ISO VG 15"):
        oil_grade("VG 33")


def test_a_rig_knows_the_name_of_its_oil():
    rig = load_rig()
    assert rig.oil_grade == "ISO VG 32" and rig.with_oil("46").oil_grade == "ISO VG 46"
    assert rig.with_values({"oil.walther_a": rig["oil.walther_a"] * 1.01}).oil_grade == ""
