"""Two effects that explain a recording together."""

from dataclasses import replace

import pytest
from ddh_twin_py.gap.verdict.two_effects import CANCEL, cancelling, doubted, leans, proportioned
from ddh_twin_py.gap.verdict.unknown import Unknown
from support.three_signals import fitted, linearised

NOTHING = Unknown(0.01, [], 0.0, "1")


@pytest.mark.parametrize("likeness, share", [(0.0, 0.0), (0.5, 0.0), (-0.5, 0.5), (-0.9, 0.9)])
def test_share_of_two_that_cancels(likeness, share):
    assert cancelling(linearised(likeness), fitted(1.0, 1.0)) == pytest.approx(share)


SHARED = ((0.7, 0.6), (0.3, 0.4), (0.0, 0.0))


@pytest.mark.parametrize(("told", "departures", "least", "most"), [
    (SHARED, (1.0, 0.3), 0.4, 0.55),  # one traces what the other's law lacks
    (SHARED, (1.0, 0.8), 0.1, 0.25),
    (((1.0, 0.0), (0.0, 1.0), (0.0, 0.0)), (1.0, 0.3), 0.04, 0.15),
    (((1.0, 0.0), (0.0, 1.0), (0.0, 0.0)), (1.0, 0.8), 0.0, 0.05),  # each speaks for itself
    (SHARED, (8.0, 0.8), 0.1, 0.25),  # the lesser may be what the greater one's law is off by
])  # fmt: skip
def test_two_that_share_their_signals_are_doubted_the_more_if_one_is_slight(told, departures, least, most):
    doubt = doubted(NOTHING, linearised(0.1, told), fitted(*departures))
    assert least < doubt.probability < most
    assert ("one cause that no catalogue has" in "".join(doubt.notes)) == (doubt.probability >= 0.5)


@pytest.mark.parametrize(("told", "departures", "could"), [
    (SHARED, (1.0, 0.8), True), (((1.0, 0.0), (0.0, 1.0), (0.0, 0.0)), (1.0, 0.8), False), (SHARED, (1.0,), False)])
def test_two_mimic_a_third_in_a_proportion_only_if_they_share_their_signals(told, departures, could):
    assert proportioned(linearised(0.1, told), fitted(*departures)) is could


def test_the_lesser_of_two_is_no_flaw_of_the_greater_once_it_is_beyond_its_law_error():
    slight, owed = (doubted(NOTHING, linearised(0.1, SHARED), fitted(greater, 0.3)).probability for greater in (1.0, 2.1))
    assert slight > 0.4 > owed


@pytest.mark.parametrize(("alone", "both", "needed"), [
    (44.0, 86.0, True), (44.0, 46.0, False), (1298.0, 1303.0, False), (1298.0, 1330.0, True)])
def test_an_effect_leans_on_a_slight_one_that_adds_more_than_its_law_may_be_off_by(alone, both, needed):
    of = [replace(fitted(*x), log_evidence=log) for x, log in (((1.0,), alone), ((1.0, 0.19), both), ((), 0.0))]
    assert leans(*of) is needed


def test_one_effect_is_not_doubted_by_this():
    assert doubted(NOTHING, linearised(-0.9), fitted(1.0)) is NOTHING


@pytest.mark.parametrize(("share", "least", "most"), [(0.2, 0.0, 0.1), (0.4, 0.2, 0.35), (CANCEL, 0.49, 0.51), (0.7, 0.8, 0.95)])
def test_the_more_two_effects_take_from_each_other_the_likelier_is_something_else(share, least, most):
    apart = ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))
    against = doubted(NOTHING, linearised(-share, apart), fitted(1.0, 1.0))
    assert least <= against.probability <= most
    assert (f"cancel {100.0 * share:.0f} %" in "".join(against.notes)) is (against.probability >= 0.5)
