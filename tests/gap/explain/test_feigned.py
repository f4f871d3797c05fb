"""A departure that the rig's own law may feign is no longer as unlikely without its effect."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.explain.feigned import made_good
from scipy.stats import norm

STD, FEIGNED = 0.02, 0.03
LEVEL, FAN = "tank.oil_level", "motor.cooling"


def fitted(log_evidence, *effects, std=STD, x=0.4):
    columns = [SimpleNamespace(effect=SimpleNamespace(id=name, feigned=FEIGNED * (name == LEVEL))) for name in effects]
    return SimpleNamespace(columns=columns, effects=effects, log_evidence=log_evidence, x=np.full(len(effects), x),
                           covariance=np.diag(np.full(len(effects), std**2)))


@pytest.mark.parametrize("x", [0.05, -0.08, 0.4])
def test_without_an_effect_its_departure_costs_what_it_does_under_a_law_that_feigns_it(x):
    at_best = norm.logpdf(0.0, scale=STD) - norm.logpdf(x, scale=STD)
    over_the_law = norm.logpdf(0.0, scale=np.hypot(STD, FEIGNED)) - norm.logpdf(x, scale=np.hypot(STD, FEIGNED))
    one, none = fitted(at_best, LEVEL, x=x), fitted(0.0)
    assert at_best - made_good({(): none, (LEVEL,): one})[()] == pytest.approx(over_the_law)


def test_each_set_without_it_stands_against_the_same_set_with_it():
    both, fan, level, none = fitted(50.0, FAN, LEVEL, x=0.05), fitted(40.0, FAN), fitted(4.0, LEVEL, x=0.01), fitted(0.0)
    share = FEIGNED**2 / (FEIGNED**2 + STD**2)
    good = made_good({(): none, (FAN,): fan, (LEVEL,): level, (FAN, LEVEL): both})
    assert good == {(): pytest.approx(4.0 * share), (FAN,): pytest.approx(10.0 * share)}, "sets with the effect owe it nothing"
    assert made_good({(): none, (FAN, LEVEL): both}) == {}, "neither was fitted without the other"


def test_a_departure_far_beyond_what_a_law_may_feign_stands_though_parameters_give_way_without_it():
    gained, x = 100.0, -0.34  # its deviation about the optimum, 0.005, would have it cost 2300 to go without
    left = gained - made_good({(): fitted(0.0), (LEVEL,): fitted(gained, LEVEL, std=0.005, x=x)})[()]
    way = np.linspace(x, 0.0, 10001)  # a parabola that rises by what is gained
    assert left == pytest.approx(np.min(gained * (way / x - 1.0) ** 2 + 0.5 * (way / FEIGNED) ** 2), rel=1e-3)
    assert left > 35.0


def test_effects_of_exact_laws_those_that_gain_nothing_and_those_without_a_deviation_make_nothing_good():
    none = fitted(0.0)
    assert made_good({(): none, (FAN,): fitted(9.0, FAN)}) == made_good({(): none, (LEVEL,): fitted(-1.0, LEVEL)}) == {}
    assert all(made_good({(): none, (LEVEL,): fitted(9.0, LEVEL, std=std)}) == {} for std in (0.0, np.nan, np.inf))
