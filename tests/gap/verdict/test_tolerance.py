"""What is called no effect: what moves no signal by its noise."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.hypotheses import LEAST
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.verdict.tolerance import without_parameters
from support.first_order import EFFECTS

VALVE, LAG, _ = EFFECTS


def fitted(*departures):
    columns = tuple(Column(effect, 0, x, 5.0, "flow", []) for effect, x in zip((VALVE, LAG), (0.1, -0.2), strict=False))
    x = np.array([d * c.x for d, c in zip(departures, columns, strict=False)])
    return Refitted(columns[: x.size], x, np.eye(x.size), np.eye(x.size + 3), np.zeros(3), [], 0.0, 0.0, np.zeros(x.size))


@pytest.mark.parametrize(("departures", "small"), [
    ((0.9 * LEAST,), {"valve.gain"}), ((1.1 * LEAST,), set()), ((2.0, 0.5 * LEAST), {"valve.lag"}), ((2.0, 2.0), set()), ((), set())])
def test_it_has_to_be_seen(departures, small):
    assert fitted(*departures).slight == small


def test_a_column_that_moves_little_is_no_measure():
    """Half of a column that moves the worst signal by two of its noise, instead of five, moves it by one."""
    found = fitted(0.45)
    little = replace(found, columns=(replace(found.columns[0], rise=2.0),))
    assert found.slight == set() and little.slight == {"valve.gain"}


COMMISSIONED = SimpleNamespace(altered=[False, True])
NONE, GAIN, STEPS, BOTH = (), ("valve.gain",), ("valve.lag",), ("valve.gain", "valve.lag")


def alone(name, departure):
    """The hypothesis of one effect, so many columns large."""
    found = fitted(departure, departure)
    which = [column.effect.id for column in found.columns].index(name)
    return replace(found, columns=(found.columns[which],), x=found.x[[which]])


@pytest.mark.parametrize(("times", "least", "most"), [
    (0.5, 0.99, 1.0), (0.98, 0.5, 0.6), (1.02, 0.4, 0.5), (1.3, 0.02, 0.06), (2.2, 0.0, 0.001)])
def test_what_is_hardly_seen_gives_no_effect_a_share_that_a_slightly_other_fit_does_not_turn_over(times, least, most):
    found = Found(None, {GAIN: 0.7, NONE: 0.3}, {GAIN: alone("valve.gain", times * LEAST), NONE: fitted()})
    left = without_parameters(COMMISSIONED, found).probability
    assert sum(left.values()) == pytest.approx(1.0)
    assert least <= (left[NONE] - 0.3) / 0.7 <= most


def test_of_two_each_may_be_none_by_itself():
    pair = fitted(3.0, 1.0 * LEAST)
    found = Found(None, {BOTH: 0.8, GAIN: 0.1, NONE: 0.1},
                  {BOTH: pair, GAIN: alone("valve.gain", 3.0), STEPS: alone("valve.lag", 1.0), NONE: fitted()})
    left = without_parameters(COMMISSIONED, found).probability
    assert left == pytest.approx({BOTH: 0.4, GAIN: 0.5, NONE: 0.1}, abs=1e-3)


def test_what_nobody_fitted_keeps_its_probability_in_the_set_that_was():
    found = Found(None, {BOTH: 0.8, NONE: 0.2}, {BOTH: fitted(3.0, 0.5 * LEAST), NONE: fitted()})
    assert without_parameters(COMMISSIONED, found).probability == pytest.approx({BOTH: 0.8, NONE: 0.2}, abs=1e-3)
