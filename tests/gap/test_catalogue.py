"""The catalogue: names by the contract, neutral values exact, every effect seen somewhere."""

import math

import numpy as np
import pytest
import yaml
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.drive.learned_terms import terms
from ddh_twin_py.gap.effect import DOMAINS
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.rig import load_rig


def test_names_parameters_and_units_are_those_of_the_contract(shared_dir):
    contract = yaml.safe_load((shared_dir / "effects.yaml").read_text())
    assert set(EFFECTS) == set(contract["effects"])
    for name, row in contract["effects"].items():
        assert (EFFECTS[name].parameter, EFFECTS[name].unit) == (row["parameter"], row["unit"])
        assert EFFECTS[name].component in contract["components"]
        if row["nominal"] != "rig":
            assert EFFECTS[name].reference(load_rig().parameters) == row["nominal"]


@pytest.mark.parametrize("name", EFFECTS)
def test_nothing_changes_at_the_neutral_value_and_something_beyond(name):
    effect = EFFECTS[name]
    assert effect.domain in DOMAINS and effect.directions
    for law in effect.laws:
        record = load_rig().parameters
        law(record, 0.0)
        laws_own = [f for f in record.dtype.names if record[f] != load_rig().parameters[f]]
        assert all("exponent" in f or "reported" in f for f in laws_own)  # which way, of a loss that is zero
        law(record, effect.limit(effect.step))
        assert any(record[f] != load_rig().parameters[f] for f in record.dtype.names if f not in laws_own)
        assert all(np.isfinite(record[f]) for f in record.dtype.names)


@pytest.mark.parametrize("deviations", [-math.sqrt(3.0), 0.6, math.sqrt(3.0)])
def test_another_oil_of_the_grade_is_as_steep_and_within_a_tenth_as_viscous_at_40_degc(deviations):
    """ISO 3448: plus or minus 10 % of the grade's number."""
    effect, celsius = EFFECTS["oil.viscosity_temperature"], 273.15
    alone, along = load_rig().parameters, load_rig().parameters
    effect.laws[0](alone, 0.2)
    effect.along_with(deviations).laws[0](along, 0.2)

    def viscosity(record, degrees):
        return 10.0 ** 10.0 ** float((record["oil_walther_a"] - record["oil_walther_b"] * np.log10(celsius + degrees))[0]) - 0.7

    assert along["oil_walther_b"] == alone["oil_walther_b"]
    assert viscosity(along, 40.0) == pytest.approx(viscosity(load_rig().parameters, 40.0) * (1.0 + 0.1 * deviations / math.sqrt(3.0)))
    said = effect.beside.said(along, alone)
    assert f"{abs(100.0 * 0.1 * deviations / math.sqrt(3.0)):.1f} % {'more' if deviations > 0.0 else 'less'} viscous" in said


@pytest.mark.parametrize("name", EFFECTS)
def test_what_is_confused_goes_both_ways(name):
    others = EFFECTS[name].confused_with
    assert others and name not in others and len(set(others)) == len(others)
    for other in others:
        assert other in EFFECTS and name in EFFECTS[other].confused_with, (name, other)


def test_what_says_the_lack_is_a_quantity_of_the_free_run_and_alike_for_the_effect_and_what_is_learned_in_its_stead():
    said = {effect.id: effect.lacked for effect in [*EFFECTS.values(), *terms()] if effect.lacked}
    assert said["learned.line_b_pressure_drop_quadratic"] == said["line_b.pressure_drop"]
    assert {name for name, _ in said.values()} <= set(OPERATING_DTYPE.names)
