"""A departure that the rig's own law may feign speaks less for its effect."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.explain.feigned import feigned
from scipy.stats import norm

STD, FEIGNED = 0.02, 0.03
LEVEL, FAN = "tank.oil_level", "motor.cooling"


def fitted(log_evidence, *effects, std=STD, x=0.4):
    columns = [SimpleNamespace(effect=SimpleNamespace(id=name, feigned=FEIGNED * (name == LEVEL))) for name in effects]
    return SimpleNamespace(columns=columns, effects=effects, log_evidence=log_evidence, x=np.full(len(effects), x),
                           covariance=np.diag(np.full(len(effects), std**2)))


@pytest.mark.parametrize("x", [0.05, -0.08, 0.4])
def test_evidence_of_an_effect_falls_to_what_it_is_over_a_law_that_feigns_it(x):
    at_best = norm.logpdf(0.0, scale=STD) - norm.logpdf(x, scale=STD)
    over_the_law = norm.logpdf(0.0, scale=np.hypot(STD, FEIGNED)) - norm.logpdf(x, scale=np.hypot(STD, FEIGNED))
    one, none = fitted(at_best, LEVEL, x=x), fitted(0.0)
    assert at_best - feigned(one, {(): none, (LEVEL,): one}) == pytest.approx(over_the_law)


def test_of_two_it_is_held_against_the_best_without_it():
    both, fan, none = fitted(50.0, FAN, LEVEL, x=0.05), fitted(40.0, FAN), fitted(0.0)
    share = FEIGNED**2 / (FEIGNED**2 + STD**2)
    assert feigned(both, {(): none, (FAN,): fan, (FAN, LEVEL): both}) == pytest.approx(10.0 * share)
    assert feigned(both, {(): none, (FAN, LEVEL): both}) == pytest.approx(50.0 * share), "the other one alone was not fitted"


def test_a_departure_far_beyond_what_a_law_may_feign_stands_though_parameters_give_way_without_it():
    gained, x = 100.0, -0.34  # its deviation about the optimum, 0.005, would have it cost 2300 to go without
    one = fitted(gained, LEVEL, std=0.005, x=x)
    left = gained - feigned(one, {(): fitted(0.0), (LEVEL,): one})
    way = np.linspace(x, 0.0, 10001)  # a parabola that rises by what is gained
    assert left == pytest.approx(np.min(gained * (way / x - 1.0) ** 2 + 0.5 * (way / FEIGNED) ** 2), rel=1e-3)
    assert left > 35.0


def test_effects_of_exact_laws_those_that_gain_nothing_and_those_without_a_deviation_owe_nothing():
    none = fitted(0.0)
    assert feigned(fitted(9.0, FAN), {(): none}) == feigned(none, {(): none}) == feigned(fitted(-1.0, LEVEL), {(): none}) == 0.0
    assert all(feigned(fitted(9.0, LEVEL, std=std), {(): none}) == 0.0 for std in (0.0, np.nan, np.inf))
