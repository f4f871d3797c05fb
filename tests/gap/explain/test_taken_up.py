"""What a parameter of the rig can do is not called an effect."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.explain.taken_up import not_shown, shown_since, taken_up
from support.first_order import DEVIATION, EFFECTS, FirstOrder

GAIN, _, OFFSET = EFFECTS


def test_a_parameter_does_what_an_effect_on_it_does():
    model, theta = FirstOrder([0.0, 0.0, 0.0]), np.array([0.5, -1.0, 0.3])
    instead = taken_up(model, theta, [(GAIN, 0, 0.05)])
    assert np.allclose(model.record(1, instead)["gain"], model.record(1, theta, [(GAIN, 0, 0.05)])["gain"])
    assert np.allclose(np.delete(instead - theta, 0), 0.0, atol=1e-9)
    assert np.isclose(instead[0] - theta[0], 0.05 * (1.0 + 0.5 * DEVIATION[0]) / DEVIATION[0])


def test_what_no_parameter_reaches_is_not_taken_up():
    model, theta = FirstOrder([0.0, 0.0, 0.0]), np.zeros(3)
    assert taken_up(model, theta, [(OFFSET, 0, 0.02)]) is None
    assert taken_up(model, theta, [(GAIN, 0, 0.05), (OFFSET, 0, 0.02)]) is None


def test_an_effect_of_no_size_is_not_taken_up():
    assert taken_up(FirstOrder([0.0, 0.0, 0.0]), np.zeros(3), [(GAIN, 0, 0.0)]) is None


def test_it_stays_within_tolerances():
    model = FirstOrder([0.0, 0.0, 0.0])
    assert taken_up(model, np.zeros(3), [(GAIN, 0, 0.9)])[0] == 4.0


@pytest.mark.parametrize(("shown", "effect", "altered", "unsaid"), [
    ((0.0, 9.0, 9.0), GAIN, [False, True], True),
    ((9.0, 0.0, 0.0), GAIN, [False, True], False),  # commissioning shows the gain as it was
    ((0.0, 0.0, 0.0), OFFSET, [False, True], False),  # no parameter does that
    ((0.0, 0.0, 0.0), GAIN, [True, True], False),  # nothing was recorded before
])  # fmt: skip
def test_what_commissioning_does_not_show_may_have_been_so_from_the_start(shown, effect, altered, unsaid):
    model = FirstOrder([0.0, 0.0, 0.0])
    model.altered = altered
    linearised = SimpleNamespace(model=model, power=1.0, sensitivities=[np.tile(shown, (5, 1)), np.full((5, 3), 9.0)])
    fitted = SimpleNamespace(theta=np.zeros(3), acting=[(effect, 0, 0.05)])
    assert not_shown(linearised, fitted) is unsaid


@pytest.mark.parametrize(("built", "theta", "altered", "told"), [
    ((0.0, 9.0, 9.0), (-0.9, 0.0, 0.0), [False, True], {"valve.gain": 0}),
    ((9.0, 9.0, 9.0), (-0.9, 0.0, 0.0), [False, True], {}),  # commissioning shows it, too
    ((0.0, 9.0, 9.0), (-0.1, 0.0, 0.0), [False, True], {}),  # the sheet may be right
    ((0.0, 9.0, 9.0), (-0.9, 0.0, 0.0), [True, True], {}),  # nothing was recorded before
])  # fmt: skip
def test_a_parameter_that_only_altered_recordings_show_stands_in_the_place_of_an_effect(built, theta, altered, told):
    model = FirstOrder([0.0, 0.0, 0.0])
    model.altered = altered
    columns = [SimpleNamespace(effect=effect, law=0, x=0.05) for effect in EFFECTS]
    linearised = SimpleNamespace(model=model, power=1.0, columns=columns, sensitivities=[np.tile(built, (5, 1)), np.full((5, 3), 9.0)])
    assert shown_since(linearised, np.array(theta), np.array([0.05, 0.05, 0.05])) == told
