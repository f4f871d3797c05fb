"""What is true helps with data that took no part."""

import math
from types import SimpleNamespace

import pytest
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.verdict.unknown import LISTED, Unknown
from ddh_twin_py.gap.verdict.verdict import (
    NO_HELP,
    explains_a_signal,
    judge,
    less_believed,
    marginal_of,
    nothing_to_explain,
    something_acting,
)

FAN, PAIR = ("motor.cooling",), ("motor.cooling", "oil.viscosity_temperature")


def found(*probability):
    return Found(None, dict(zip([FAN, PAIR, ()], probability, strict=True)), {})


def test_an_effect_that_does_not_help_must_be_spoken_for_the_louder():
    weak, strong = (less_believed(found(*p), {FAN: NO_HELP}) for p in ((0.55, 0.05, 0.4), (0.999, 0.0009999, 1e-7)))
    assert weak.leader == () and weak.probability[()] > 0.95
    assert strong.leader == FAN and strong.probability[FAN] > 0.95


@pytest.mark.parametrize(("lost", "odds"), [({FAN: 2.0}, 6.0), ({FAN: 2.0, PAIR: 0.0}, 6.0 * math.exp(-2.0))])
def test_odds_among_effects_stay_but_for_those_that_were_heard_and_all_sum_to_one(lost, odds):
    after = less_believed(found(0.6, 0.1, 0.3), lost).probability
    assert after[FAN] / after[PAIR] == pytest.approx(odds) and sum(after.values()) == pytest.approx(1.0)


def test_what_spoke_for_no_effect_speaks_for_nothing_listed_where_something_acts():
    after, unknown = something_acting(found(0.3, 0.1, 0.6), Unknown(0.1, [], 0.0, "1"), 0.95, "why")
    sets = judge(after, unknown).sets
    assert sets[FAN] == pytest.approx(0.9 * 0.3) and sets[PAIR] == pytest.approx(0.9 * 0.1)
    assert sets[("unknown",)] == pytest.approx(0.1 + 0.9 * 0.57) and sum(sets.values()) == pytest.approx(1.0)
    assert unknown.notes == ["why"]


def test_the_probability_of_an_effect_is_that_of_all_sets_with_it_the_largest_first():
    assert list(marginal_of({("b",): 0.0, (): 0.2, ("a",): 0.5, ("a", "b"): 0.3}).items()) == [("a", 0.8), ("b", 0.3)]


def test_where_nothing_surprises_nothing_changes():
    was, unknown = found(0.3, 0.1, 0.6), Unknown(0.1, [], 0.0, "1")
    assert something_acting(was, unknown, 0.0, "") == (was, unknown)
    assert something_acting(found(0.9, 0.1, 0.0), unknown, 1.0, "why")[1] is unknown, "no effect was out of the question anyway"


def test_where_nothing_but_no_effect_was_asked_and_something_surely_acts_it_is_unknown():
    after, unknown = something_acting(Found(None, {(): 1.0}, {}), Unknown(0.0, [], 0.0, "1"), 1.0, "why")
    assert judge(after, unknown).word == "unknown" and unknown.probability == 1.0


def test_however_sure_the_rules_are_something_listed_keeps_its_share():
    verdict = judge(found(0.3, 0.1, 0.6), Unknown(0.9999, [], 0.0, "1"))
    assert verdict.word == "unknown" and verdict.sets[("unknown",)] == 1.0 - LISTED
    assert verdict.sets[FAN] == pytest.approx(0.3 * LISTED) and sum(verdict.sets.values()) == pytest.approx(1.0)


def test_one_effect_of_a_class_does_not_stand_for_two_of_it(monkeypatch):
    monkeypatch.setattr("ddh_twin_py.gap.verdict.verdict.classes_of", lambda *_: ([list(PAIR)], {}))
    case = SimpleNamespace(leader=PAIR, probability={PAIR: 0.4, FAN: 0.35, (): 0.25}, linearised=None, fitted={})
    assert judge(case, Unknown(0.0, [], 0.0, "1")).word == "ambiguous"
    case.leader, case.probability = FAN, {FAN: 0.4, (PAIR[1],): 0.35, (): 0.25}
    judged = judge(case, Unknown(0.0, [], 0.0, "1"))
    assert judged.word == "explained" and judged.together == pytest.approx(0.75), "either stands for the other"


@pytest.mark.parametrize("gaps, speaks, relieved, nothing", [
    ([(0.8, 0.8)], 9.0, 2.0, True),  # flaws of the laws gain as much
    ([(1.2, 1.0)], 9.0, 2.0, False),  # it shrinks what there is
    ([(0.8, 0.7)], 9.0, 2.0, True),  # of which nothing is beyond the floor
    ([(1.7, 1.5), (0.9, 0.87)], 17.0, 5.0, True),  # all but what sums up the flaws of laws is within it
    ([(1.5, 1.5)], 9.0, 2.0, False),  # a gap that nobody shrinks is one all the same
    ([(1.5, 1.5), (0.8, 0.8)], 9.0, 2.0, True),  # a rig within its tolerances does as well
    ([(0.8, 0.8)], 40.0, 2.0, False),
    ([(0.8, 0.8)], 11.0, 12.0, False),  # parameters had taken it up, far from the sheet
    ([(0.8, 0.8)], 6.0, 12.0, True),  # what relieves them and is gained little by costs elsewhere
])
def test_without_commissioning_a_small_gap_is_none_unless_an_effect_is_loud_or_relieves_the_rig(gaps, speaks, relieved, nothing):
    assert nothing_to_explain(gaps, speaks, relieved) is nothing


@pytest.mark.parametrize("without, beside, explained", [
    ({"winding": 2.8, "strokes": 2.3}, {"winding": 1.7, "strokes": 1.9}, True),  # lost among what is within the floor
    ({"winding": 2.5, "strokes": 5.4}, {"winding": 2.4, "strokes": 4.7}, False),  # off with it as without
    ({"winding": 1.8}, {"winding": 0.9}, False),  # not far off
    ({}, {}, False),
])
def test_what_brings_a_signal_much_nearer_that_is_far_off_explains_something(without, beside, explained):
    assert explains_a_signal(without, beside) is explained
