"""Sensitivities to a rig's parameters as differences of its free runs."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy
from ddh_twin_py.gap.evidence.slopes import slopes_of
from support.first_order import EFFECTS, FirstOrder


def test_they_are_differences_towards_the_sheet_of_the_runs_that_are_asked_for():
    model, theta = FirstOrder(np.array([1.0, -0.8, 0.5]), seed=3), np.array([0.4, -0.4, 0.0])
    comparisons = [Comparison(s, p, Discrepancy()) for s, p in zip(model.signals, model.run(theta, ()), strict=True)]
    acting, told, ran, run_one = [(EFFECTS[0], 0, 0.3)], [], [], model.run_one
    model.run_one = lambda number, at, acting=(), roughly=False: ran.append((number, tuple(at))) or run_one(number, at, acting, roughly)
    with ThreadPoolExecutor(2) as pool:
        (rows,) = slopes_of(model, pool, theta, comparisons, [1], told.append, acting)
    assert rows.shape == (comparisons[1].size, 3) and told[-1] == 1.0 and len(ran) == 4 and {number for number, _ in ran} == {1}
    for i, step in enumerate((-0.01, 0.01, 0.01)):
        moved = theta + step * np.eye(3)[i]
        change = comparisons[1].features(run_one(1, moved, acting)) - comparisons[1].features(run_one(1, theta, acting))
        np.testing.assert_allclose(rows[:, i], change / step, rtol=1e-6, atol=1e-9)
