"""Which hypotheses are fitted in full."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.comparison import Discrepancy
from ddh_twin_py.gap.fits import Fits
from ddh_twin_py.gap.hypotheses import POWER, SLACK, weighted
from ddh_twin_py.gap.linearised import linearise
from support.first_order import EFFECTS, FirstOrder


class Elsewhere:
    """Fits of another linearisation, in which effects fell far short."""

    def __init__(self, *names):
        self._names = names

    def short(self):
        return dict.fromkeys(self._names, -1000.0)


@pytest.mark.parametrize("index, departure", [(0, 0.15), (2, 0.12)])
def test_what_fell_short_elsewhere_is_fitted_before_it_is_dismissed(index, departure):
    model, true = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[index], 0, departure)], seed=index), (EFFECTS[index].id,)
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(model, EFFECTS, np.zeros(3), Discrepancy(), SLACK, POWER, pool)
        singles = linearised.evidence.singles()
        weights = weighted(singles + linearised.evidence.pairs(singles), linearised.columns, linearised.effects)
        fits = Fits(linearised, weights, pool, Elsewhere(EFFECTS[index].id))
        fits.leaders()
    assert true in fits.fitted and next(iter(fits.probability())) == true


def test_a_fit_that_lost_its_way_is_found_again_with_sensitivities_of_its_own():
    model, true = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[1], 0, 1.5)], seed=1), (EFFECTS[1].id,)
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(model, EFFECTS, np.zeros(3), Discrepancy(), SLACK, POWER, pool)
        singles = linearised.evidence.singles()
        fits = Fits(linearised, weighted(singles + linearised.evidence.pairs(singles), linearised.columns, linearised.effects), pool)
        fits.leaders()
        found = fits.fitted[true]
        promised = fits.linear(true)
        fitted = fits.fitted
        fits.fitted = {**fitted, (): replace(fitted[()], log_evidence=fitted[()].log_evidence + 2.0 * max(10.0, 0.05 * promised))}
        assert not fits.fell_short(), "that no effect does better than the linear model knows is no fault of the fit"
        fits.fitted = fitted
        lost = min(found.log_evidence, linearised.evidence.log_of_none + promised) - 2.0 * max(10.0, 0.05 * promised)
        fits.fitted = {(): fits.fitted[()], true: replace(found, x=0.5 * found.x, theta=found.theta + 1.0, log_evidence=lost)}
        assert fits.fell_short()
        fits.sharpen()
    assert fits.fitted[true].log_evidence > found.log_evidence - 0.5
    np.testing.assert_allclose(fits.fitted[true].x, found.x, rtol=0.05)
