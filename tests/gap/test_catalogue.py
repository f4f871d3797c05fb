"""The catalogue: names by the contract, neutral values exact, every effect seen somewhere."""

import numpy as np
import pytest
import yaml
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.drive_learned import terms
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
