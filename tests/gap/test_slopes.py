"""Sensitivities to parameters: which are taken anew at another place, and which still hold."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ddh_twin_py.estimation.comparison import Comparison, Discrepancy
from ddh_twin_py.gap.hypotheses import POWER, SLACK
from ddh_twin_py.gap.linearised import linearise
from ddh_twin_py.gap.slopes import NEARBY, Taken, slopes_of
from support.first_order import EFFECTS, FirstOrder

TRUE = np.array([1.0, -0.8, 0.5])


@pytest.fixture
def model():
    return FirstOrder(TRUE, [(EFFECTS[0], 0, 0.2)], seed=3)


def compared(model, theta):
    return [Comparison(s, p, Discrepancy()) for s, p in zip(model.signals, model.run(theta, ()), strict=True)]


def counted(model):
    """Recordings that are run from now on."""
    ran, run_one = [], model.run_one
    model.run_one = lambda number, theta, acting=(), roughly=False: ran.append(number) or run_one(number, theta, acting, roughly)
    return ran


def test_what_is_not_wanted_is_kept_and_not_run(model):
    theta = np.full(3, 0.4)
    comparisons = compared(model, theta)
    with ThreadPoolExecutor(2) as pool:
        all_anew = slopes_of(model, pool, theta, comparisons, [0, 1])
        other = [np.full_like(rows, 7.0) for rows in all_anew]
        ran = counted(model)
        told = []
        some = slopes_of(model, pool, theta, comparisons, [0, 1], told.append, beside=[None, other[1]],
                         wanted=np.array([True, False, False]))
    assert np.array_equal(some[0], all_anew[0]), "of a recording with nothing known all is taken"
    assert np.array_equal(some[1][:, 0], all_anew[1][:, 0]) and (some[1][:, 1:] == 7.0).all() and (other[1] == 7.0).all()
    assert sorted(ran) == [0] * 4 + [1] * 2 and told[-1] == 1.0


def test_a_parameter_that_moves_nothing_is_kept_unless_it_is_one_of_a_threshold(model):
    comparisons = compared(model, np.zeros(3))
    taken = Taken(np.zeros(3), comparisons, [np.zeros((c.size, 3)) for c in comparisons], np.array([5.0, 0.2, 0.0]))
    assert taken.strong(model).tolist() == [True, False, False]
    model.thresholds = [2]
    assert taken.strong(model).tolist() == [True, False, True]
    assert taken.near(np.full(3, 0.9 * NEARBY)) and not taken.near(np.array([0.0, 0.0, 1.1 * NEARBY]))
    assert taken.beside(2, comparisons[1]) is None


def test_a_case_is_linearised_with_what_a_fit_has_taken(model):
    """Where it was taken near nothing is run for parameters; far off what no effect alters is kept, and what is strong is taken."""
    def runs_of_parameters(theta, near):
        with ThreadPoolExecutor(2) as pool:
            ran = counted(model)
            found = linearise(model, (), theta, Discrepancy(), SLACK, POWER, pool, near=near)
        return found, [ran.count(number) for number in (0, 1)]

    plain, ran = runs_of_parameters(np.zeros(3), None)
    assert ran == [1 + 4, 1 + 4]
    assert np.isfinite(plain.slopes().information).all() and plain.slopes().information.min() > 1.0
    near, ran = runs_of_parameters(np.full(3, 0.3), plain.slopes())
    assert ran == [1, 1]
    for own, rows, old, new in zip(plain.sensitivities, near.sensitivities, plain.comparisons, near.comparisons, strict=True):
        np.testing.assert_allclose(rows * new.spread[:, None], own * old.spread[:, None])
    far, ran = runs_of_parameters(np.full(3, 0.8), plain.slopes())
    assert ran == [1, 1 + 4]
    anew, _ = runs_of_parameters(np.full(3, 0.8), None)
    assert np.array_equal(far.sensitivities[1], anew.sensitivities[1]) and not np.array_equal(far.sensitivities[0], anew.sensitivities[0])
