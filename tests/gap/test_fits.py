"""Which hypotheses are fitted in full."""

from concurrent.futures import ThreadPoolExecutor

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
