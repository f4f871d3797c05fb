"""Fits of hypotheses in full."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ddh_twin_py.estimation.comparison import Discrepancy
from ddh_twin_py.gap.hypotheses import POWER, SLACK
from ddh_twin_py.gap.linearised import linearise
from ddh_twin_py.gap.refit import Refit
from support.first_order import EFFECTS, FirstOrder


@pytest.mark.parametrize("value", [np.nan, 1.0e200])
def test_a_start_from_which_runs_go_astray_does_not_dismiss_the_hypothesis(value):
    """Whether they end in what is no number or in what is too large for its square."""
    true = 0.15
    model = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[0], 0, true)])
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(model, EFFECTS, np.zeros(3), Discrepancy(), SLACK, POWER, pool)
    start, run_one = np.array([2.0, 2.0, 2.0]), model.run_one

    def astray(number, theta, acting=()):
        found = run_one(number, theta, acting)
        return {name: np.full_like(values, value) for name, values in found.items()} if np.array_equal(theta, start) else found

    model.run_one = astray
    column = next(c for c in linearised.columns if c.effect is EFFECTS[0])
    fitted = Refit(linearised).of([column], start, np.array([1.0]))
    assert np.isfinite(fitted.log_evidence) and fitted.x[0] == pytest.approx(true, abs=0.05)
