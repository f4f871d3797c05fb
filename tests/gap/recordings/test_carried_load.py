"""A recording that carries another load than it declares is told, and what may be the effect is not."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.recordings.carried_load import carried, undeclared_loads
from ddh_twin_py.rig import load_rig
from support.simulated import simulated


@pytest.fixture(scope="module")
def recording():
    return simulated(1, "mixed", 120.0)[0]


def declaring(recording, mass):
    return replace(recording, rig=replace(recording.rig, payload_mass=mass))


def test_pressures_tell_about_the_payload(recording):
    assert carried(recording, load_rig()) == pytest.approx(recording.rig.payload_mass, abs=30.0)  # its transducers have zero errors
    blind = recording.hydraulic.values.copy()
    blind[:, recording.hydraulic.fields.index("pressure_piston_side")] = np.nan
    assert np.isnan(carried(replace(recording, hydraulic=replace(recording.hydraulic, values=blind)), load_rig()))
    assert np.isnan(carried(replace(recording, hydraulic=None), load_rig()))


@pytest.mark.parametrize("role", ["commissioning", "validation"])
def test_one_that_is_odd_beside_the_field_is_named(role, recording):
    mass = recording.rig.payload_mass
    rig, roles = load_rig(), {"commissioning": [recording], "validation": [recording]}
    assert undeclared_loads([recording], roles["commissioning"], roles["validation"], rig) == []
    roles[role] = [declaring(recording, mass + 100.0)]
    (said,) = undeclared_loads([recording], roles["commissioning"], roles["validation"], rig)
    assert said.startswith(f"{recording.path}: by its pressures the rod carries about {carried(recording, rig):.0f} kg")
    assert f"{recording.namespace}/rig payload_mass declares {mass + 100.0:g} kg" in said


def test_a_load_that_field_and_validation_share_may_be_the_effect(recording):
    heavier = declaring(recording, recording.rig.payload_mass + 100.0)
    assert undeclared_loads([heavier], [recording], [heavier], load_rig()) == []
