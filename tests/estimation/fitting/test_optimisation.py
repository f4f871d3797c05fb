"""Levenberg-Marquardt of the calibration on functions whose lowest place is known otherwise."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.binning import one_by_one
from ddh_twin_py.estimation.fitting.comparison import MOVING, SMOOTH, STEADY, STROKES, Discrepancy
from ddh_twin_py.estimation.fitting.experiment import Signal
from ddh_twin_py.estimation.fitting.problem import Problem
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.sheet import FIELD_OF_PATH
from scipy.optimize import least_squares

PATHS = ["pump_1.leakage", "pump_2.leakage"]
EXACT = Discrepancy(scale=dict.fromkeys((STEADY, MOVING, SMOOTH, STROKES), 1.0e-6))
SAMPLES = 25


class Curved:
    """A recording of constant signals, each a function of the two deviations; what was measured is ``aim``."""

    open_begins = 0

    def __init__(self, laws, aim):
        self.rig, self.laws = load_rig(), laws
        time = np.arange(SAMPLES, dtype=float)
        binning = one_by_one(time, np.ones(SAMPLES, dtype=bool))
        self.signals = {name: Signal(time, np.full(SAMPLES, value), 1.0, "1", binning) for name, value in aim.items()}

    def parameters(self, rig):
        return rig.parameters

    def refine(self, parameters, step):
        """Its runs take no steps."""

    def predict(self, parameters, step, begin):
        u = [(parameters[0][FIELD_OF_PATH[p]] - self.rig[p]) / self.rig.quantities[p].standard_deviation for p in PATHS]
        return {name: np.full(SAMPLES, law(*u)) for name, law in self.laws.items()}


def fitted(laws, aim, restarts=0):
    problem = Problem([Curved(laws, aim)], load_rig(), PATHS, EXACT)
    with ThreadPoolExecutor(1) as pool:
        fit = problem.fit(pool, restarts=restarts)

    def cost(u):
        return np.append([np.sqrt(SAMPLES) * (aim[name] - law(*u)) for name, law in laws.items()], u)

    return fit, cost


@pytest.mark.parametrize("steep", [3.0, 10.0])
def test_a_narrow_bent_valley_is_followed_to_its_end(steep):
    laws = {"speed": lambda a, b: steep * (b - a * a), "current": lambda a, b: a}
    fit, cost = fitted(laws, {"speed": 0.0, "current": 1.4})
    best = least_squares(cost, fit.theta, xtol=1e-14, ftol=1e-14)
    assert fit.settled
    assert np.sum(cost(fit.theta) ** 2) < np.sum(cost(best.x) ** 2) + 0.3
    np.testing.assert_allclose(fit.theta, best.x, atol=0.1)
    assert best.x[0] > 1.0


def test_a_signal_that_is_far_off_is_not_given_up():
    """Two signals contradict each other far beyond noise: the optimum lies between them, not where one of them fits."""
    fit, _ = fitted({"speed": lambda a, b: 10.0 * a, "current": lambda a, b: 10.0 * a + b}, {"speed": 0.0, "current": 20.0})
    b = 2.5  # where its tolerance ends
    a = SAMPLES * 10.0 * (20.0 - b) / (SAMPLES * 200.0 + 1.0)
    np.testing.assert_allclose(fit.theta, [a, b], atol=0.01)


def test_steps_end_at_the_bounds():
    fit, _ = fitted({"speed": lambda a, b: a, "current": lambda a, b: b}, {"speed": 9.0, "current": -9.0})
    np.testing.assert_allclose(fit.theta, [2.5, -2.5], atol=1e-6)


TWO_VALLEYS = {"speed": lambda a, b: (a + 1.0) * (2.7 - a) - 1.5 * (2.0 - b) * a, "current": lambda a, b: 10.0 * b}
"""While b is unknown the way leads to where a's tolerance ends; with b known a lies at -1."""


def test_a_fit_that_ends_where_a_tolerance_ends_is_begun_again_and_the_better_one_counts():
    aim = {"speed": 0.0, "current": 20.0}
    once, _ = fitted(TWO_VALLEYS, aim)
    again, _ = fitted(TWO_VALLEYS, aim, restarts=1)
    np.testing.assert_allclose(once.theta, [2.5, 2.0], atol=0.05)
    np.testing.assert_allclose(again.theta, [-1.0, 2.0], atol=0.05)
    assert again.deviance < once.deviance - 10.0 and again.sweeps > once.sweeps


def test_beginning_again_does_not_give_up_the_better_fit():
    laws, aim = {"speed": lambda a, b: a, "current": lambda a, b: b}, {"speed": 9.0, "current": -1.0}
    once, _ = fitted(laws, aim)
    again, _ = fitted(laws, aim, restarts=2)
    np.testing.assert_allclose(again.theta, once.theta, atol=1e-6)
    assert again.deviance == pytest.approx(once.deviance)
