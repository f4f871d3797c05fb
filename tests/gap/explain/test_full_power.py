"""Where the leading hypotheses stand once the likelihood counts in full."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.effect import divided
from ddh_twin_py.gap.evidence.hypotheses import POWER
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.full_power import at_full_power
from ddh_twin_py.gap.explain.refit import Refit
from support.first_order import EFFECTS, FirstOrder

TRUE, ACTS = (EFFECTS[1].id,), 1.5


class Folded(FirstOrder):
    """The loop with a gain that falls again beyond two deviations: one at 3 shows what one at 1 does."""

    def record(self, number, theta, acting=()):
        return super().record(number, np.array([2.0 - abs(theta[0] - 2.0), *theta[1:]]), acting)


def fitted_at(model, pool, place, theta, x=ACTS):
    """A linearisation about ``place`` (3,), and fits of no effect and of the true one from parameters (3,) and departure ``x``."""
    linearised = linearise(Question(model, EFFECTS), np.array(place), pool)
    refit, column = Refit(linearised), next(c for c in linearised.columns if c.effect is EFFECTS[1])
    fits = [refit.of([], np.array(theta), np.zeros(0)), refit.of([column], np.array(theta), np.array([x / column.x]))]
    return linearised, {fit.effects: fit for fit in fits}


def test_the_leader_stands_at_its_own_lowest_point_and_keeps_its_evidence():
    """Sensitivities of a place far off, where no effect acts, stop a fit elsewhere."""
    model = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[1], 0, ACTS)], seed=1)
    with ThreadPoolExecutor(2) as pool:
        linearised, fitted = fitted_at(model, pool, [-4.0, 4.0, -4.0], [-4.0, 4.0, -4.0])
        was, now = fitted[TRUE], at_full_power(linearised, fitted, [TRUE], None, pool)[TRUE]
    basis = linearised.basis.otherwise(1.0, 1.0)

    def cost(theta, x):
        runs = model.run(theta, [(EFFECTS[1], 0, float(x))])
        return basis.misfit([c.residual(p) for c, p in zip(linearised.comparisons, runs, strict=True)]) + theta @ theta

    assert now.log_evidence == was.log_evidence
    least = cost(now.theta, now.x[0])
    assert least < cost(was.theta, was.x[0])
    for i in range(3):
        for step in (-0.01, 0.01):
            assert cost(now.theta + step * np.eye(3)[i], now.x[0]) > least - 0.02


def test_a_fit_that_stopped_on_the_way_goes_on_from_the_rig_as_built():
    as_built = np.array([1.0, -0.8, 0.5])
    model = Folded(as_built, [(EFFECTS[1], 0, ACTS)], seed=1)
    with ThreadPoolExecutor(2) as pool:
        linearised, fitted = fitted_at(model, pool, [3.0, -0.8, 0.5], [3.0, -0.8, 0.5])
        alone, both = (at_full_power(linearised, fitted, [TRUE], start, pool)[TRUE] for start in (None, as_built))
    assert alone.theta[0] == pytest.approx(3.0, abs=0.3)
    assert both.theta == pytest.approx(as_built, abs=0.3) and both.x[0] == pytest.approx(ACTS, rel=0.1)
    assert both.log_evidence == fitted[TRUE].log_evidence


def test_a_rig_as_built_that_leads_nowhere_better_is_not_followed():
    model = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[1], 0, ACTS)], seed=1)
    with ThreadPoolExecutor(2) as pool:
        linearised, fitted = fitted_at(model, pool, [1.0, -0.8, 0.5], [1.0, -0.8, 0.5])
        alone, both = (at_full_power(linearised, fitted, [TRUE], start, pool)[TRUE] for start in (None, np.array([0.5, -0.5, 0.0])))
    assert np.array_equal(both.theta, alone.theta) and np.array_equal(both.x, alone.x)


def test_the_size_of_a_leader_is_as_uncertain_as_where_it_acts_and_not_as_where_it_does_not():
    """A gain of which a quarter is left: the rig's own gain moves the altered recording a quarter as far as it did as built."""
    throttled, x = replace(EFFECTS[0], laws=(divided("gain"),), highest=10.0), 3.0
    model = FirstOrder(np.array([0.5, 0.0, 0.0]), [(throttled, 0, x)], seed=1)
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, [throttled], slack=0.0), np.zeros(3), pool)
        column = next(c for c in linearised.columns if c.x > 0.0)
        fits = [Refit(linearised).of(own, np.zeros(3), np.full(len(own), x / column.x)) for own in ([], [column])]
        fitted = {fit.effects: fit for fit in fits}
        leader = at_full_power(linearised, fitted, [(throttled.id,)], None, pool)[(throttled.id,)]

    def features(at):
        runs = model.run(at[:3], [(throttled, 0, float(at[3]))])
        return [c.features(p) for c, p in zip(linearised.comparisons, runs, strict=True)]

    at = np.array([*leader.theta, leader.x[0]])
    moved = [(features(at + step), features(at - step), 2.0 * step.sum()) for step in np.diag([1e-3, 1e-3, 1e-3, 1e-2])]
    slopes = [np.column_stack([(more[i] - less[i]) / by for more, less, by in moved]) for i in range(2)]
    told = POWER * linearised.basis.weighting.products(slopes, slopes) + np.diag([1.0, 1.0, 1.0, 0.0])
    np.testing.assert_allclose(np.sqrt(np.diagonal(leader.joint)), np.sqrt(np.diagonal(np.linalg.inv(told))), rtol=0.05)
    assert abs(math.log(leader.joint[3, 3] / fitted[(throttled.id,)].joint[3, 3])) > 0.1
