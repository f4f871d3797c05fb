"""A quadratic within bounds: its lowest place and its volume, against general solvers and direct integration."""

import math

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.box import Normal, lowest_point
from scipy.integrate import dblquad, quad
from scipy.optimize import lsq_linear


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("n", [1, 4, 60])
def test_lowest_point_is_that_of_a_general_solver(seed, n):
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(2 * n, n)) * 10.0 ** rng.uniform(-2.0, 2.0, n)
    matrix = rows.T @ rows + np.eye(n)
    slope = matrix @ (3.0 * rng.normal(size=n))
    lowest, highest = np.full(n, -2.5), np.where(rng.random(n) < 0.2, np.inf, 2.5)
    found = lowest_point(matrix, slope, rng.normal(size=n), lowest, highest)
    factor = np.linalg.cholesky(matrix)
    expected = lsq_linear(factor.T, np.linalg.solve(factor, slope), bounds=(lowest, highest), method="bvls", max_iter=1000).x

    def height(u):
        return 0.5 * u @ matrix @ u - slope @ u

    assert np.all((found >= lowest) & (found <= highest))
    assert height(found) <= height(expected) + 1e-9 * abs(height(expected))


def one(information, score, lowest, highest):
    return Normal(np.array([[information]]), np.array([score]), np.zeros((1, 0)), np.zeros((0, 0)), np.zeros(0), 0.0,
                  np.array([lowest]), np.array([highest]))


@pytest.mark.parametrize("score", [0.0, 3.0, 10.0, 24.9, 25.1, 60.0, -400.0])
def test_volume_of_one_unknown_is_its_integral(score):
    held = one(10.0, score, -2.5, 2.5).held(np.zeros(0, np.int64), np.zeros(0), 1.0)
    top = -0.5 * held.lowest
    expected, _ = quad(lambda t: math.exp(-0.5 * (10.0 * t * t - 2.0 * score * t) - top), -2.5, 2.5, points=[held.shared[0]], limit=200)
    assert held.log_volume - 0.5 * held.chi_square == pytest.approx(top + math.log(expected / math.sqrt(2.0 * math.pi)), abs=0.02)


def test_volume_with_one_of_two_at_its_bound():
    information, score = np.array([[10.0, 4.0], [4.0, 8.0]]), np.array([60.0, 5.0])
    ends = np.full(2, 2.5)
    held = Normal(information, score, np.zeros((2, 0)), np.zeros((0, 0)), np.zeros(0), 0.0, -ends, ends).held(
        np.zeros(0, np.int64), np.zeros(0), 1.0)
    assert held.shared[0] == 2.5 and abs(held.shared[1]) < 2.5
    top = -0.5 * held.lowest

    def density(b, a):
        t = np.array([a, b])
        return math.exp(-0.5 * (t @ information @ t - 2.0 * score @ t) - top)

    expected, _ = dblquad(density, 1.0, 2.5, -2.5, 2.5)
    assert held.log_volume - 0.5 * held.chi_square == pytest.approx(top + math.log(expected / (2.0 * math.pi)), abs=0.05)


def test_a_parameter_at_its_end_lets_the_effect_speak():
    """The same data: where the tolerance ends, the effect has to take the rest."""
    cross, own = np.array([[9.5]]), np.array([[10.0]])
    free, held = (Normal(np.array([[11.0]]), np.array([60.0]), cross, own, np.array([60.0]), 400.0, np.array([-end]), np.array([end])).held(
        np.array([0]), np.array([np.inf]), 1.0) for end in (100.0, 0.5))
    assert held.departure[0] > 1.5 * free.departure[0]
