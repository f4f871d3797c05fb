"""How far a hypothesis lets the rig drift from what it was when it was commissioned."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.refit import Refit
from ddh_twin_py.gap.verdict.drift import Drift
from support.first_order import EFFECTS, FirstOrder

BUILT = np.array([1.0, -0.8, 0.5])


def drifts(acting):
    """Drifts asked for by no effect and by the first effect, and the degrees of freedom, where ``acting`` has acted since commissioning."""
    model = FirstOrder(BUILT, acting, seed=4)
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, EFFECTS), BUILT, pool)
    drift, refit = Drift(linearised, BUILT), Refit(linearised)
    column = next(c for c in linearised.columns if c.effect is EFFECTS[0])
    return drift.of(refit.of([], BUILT, np.zeros(0))), drift.of(refit.of([column], BUILT, np.array([1.0]))), drift.expected


def test_no_effect_asks_for_another_rig_where_one_acts_and_the_effect_does_not():
    none, effect, expected = drifts([(EFFECTS[0], 0, 0.6)])
    assert none > 8.0 and effect < 3.0 and 0.0 < expected <= 3.0


def test_nothing_asks_for_another_rig_where_nothing_has_changed():
    none, effect, _ = drifts([])
    assert none < 3.0 and effect < 3.0


def test_what_commissioning_tells_is_not_expected_to_move():
    """Two recordings of about one length tell each parameter about equally: the second halves what the first left open."""
    assert drifts([])[2] == pytest.approx(2.0, abs=1.0)
