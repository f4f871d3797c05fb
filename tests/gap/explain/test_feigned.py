"""A departure that the rig's own law may feign speaks less for its effect."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.explain.feigned import feigned
from scipy.stats import norm

STD = 0.02


def fitted(x, may_feign, std=STD):
    columns = [SimpleNamespace(effect=SimpleNamespace(feigned=one)) for one in may_feign]
    return SimpleNamespace(columns=columns, x=np.array(x), covariance=np.diag(np.full(len(x), std**2)))


def ratio(x, may_feign, wide=100.0):
    """Log evidence of any departure over none, where a law feigns one on top of it."""
    noise = np.hypot(STD, may_feign)
    return norm.logpdf(x, scale=np.hypot(noise, wide)) - norm.logpdf(x, scale=noise)


@pytest.mark.parametrize("x", [0.05, 0.08, -0.08, 0.4])
def test_evidence_falls_by_as_much_as_the_law_may_feign(x):
    assert feigned(fitted([x], [0.03])) == pytest.approx(ratio(x, 0.0) - ratio(x, 0.03), rel=1e-4)


def test_a_small_departure_gains_nothing_by_it_and_effects_of_exact_laws_lose_nothing():
    assert feigned(fitted([0.001], [0.03])) == 0.0
    assert feigned(fitted([0.4, 0.4], [0.0, 0.0])) == 0.0 and feigned(fitted([], [])) == 0.0
    assert feigned(fitted([0.08, 0.4], [0.03, 0.0])) == feigned(fitted([0.08], [0.03]))


@pytest.mark.parametrize("std", [0.0, np.nan, np.inf])
def test_a_departure_without_a_deviation_loses_nothing(std):
    assert feigned(fitted([0.08], [0.03], std)) == 0.0
