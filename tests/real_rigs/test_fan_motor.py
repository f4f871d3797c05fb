"""The example of the documents from which an engineer begins: it finds what was put into it, and nothing where nothing was."""

import importlib
from pathlib import Path

import numpy as np
import pytest
from ddh_twin_py.real_rigs.diagnose import found_by
from ddh_twin_py.real_rigs.rig_model import RigModel


@pytest.fixture(scope="module")
def fan():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(Path(__file__).parents[2] / "docs")
        yield importlib.import_module("fan_motor")


def test_neutral_values_are_the_baseline_exactly(fan):
    model = RigModel(fan.DESCRIPTION, [fan.recorded()])
    plain = model.run(np.zeros(model.size))[0]
    for effect in fan.EFFECTS:
        for name, values in model.run(np.zeros(model.size), [(effect, 0, 0.0)])[0].items():
            np.testing.assert_array_equal(values, plain[name])


@pytest.mark.parametrize("number, x", [(0, 0.02), (1, 1.0), (2, 0.1), (3, 0.5)])
def test_what_acts_is_found(fan, number, x):
    effect = fan.EFFECTS[number]
    outcomes = fan.diagnosed(fan.recorded([(effect, 0, x)]))
    assert found_by(outcomes) == [effect.id] and outcomes[-1].verdict == "no_gap"
    own = outcomes[-1].plain.theta
    value = outcomes[-1].model.fitted_parameters(own, np.ones(own.size))[-1].value - effect.reference(fan.DESCRIPTION.record())
    assert value == pytest.approx(x, rel=0.3)


def test_nothing_is_found_where_nothing_acts(fan):
    assert [o.verdict for o in fan.diagnosed(fan.recorded())] == ["no_gap"]
