"""No gap leaves to causes that hardly show what they had before any data."""

import math

import pytest
from ddh_twin_py.gap.evidence.hypotheses import log_prior
from ddh_twin_py.gap.explain.detection import SIZES, Detection
from ddh_twin_py.gap.verdict.hidden_causes import UNLISTED_TOO, WITHOUT_COMMISSIONING, Hidden, hidden_causes, with_hidden
from ddh_twin_py.gap.verdict.verdict import Verdict, marginal_of

FAN, LEAK, PAIR, OUTSIDE = ("motor.cooling",), ("pump_1.leakage",), ("motor.cooling", "pump_1.leakage"), ("unknown",)
SETS = {(): 0.9, OUTSIDE: 0.05, FAN: 0.03, PAIR: 0.02}
ASKED = 40


def detection(effect, *gains):
    return Detection(effect, "1", None, None, "", dict(zip(SIZES, gains, strict=True)))


def odds_before_data():
    return math.exp(log_prior(("",), ASKED) - log_prior((), ASKED))


def test_what_nothing_shows_is_as_likely_as_before_data_and_what_all_sizes_show_is_out():
    hidden = hidden_causes([detection("a", -9.0, -9.0, -9.0), detection("b", 40.0, 200.0, 900.0)], ["c"], ASKED, True)
    assert hidden.listed["a"] == pytest.approx(odds_before_data(), rel=1e-3) and hidden.listed["c"] == pytest.approx(odds_before_data())
    assert hidden.listed["b"] < 1e-9 and hidden.unlisted == pytest.approx(UNLISTED_TOO * sum(hidden.listed.values()))


def test_a_faint_effect_hides_where_larger_ones_show_and_sizes_that_bounds_forbid_do_not_count_while_others_show():
    hidden = hidden_causes([detection("a", -9.0, 90.0, 900.0), detection("b", -9.0, None, None), detection("c", None, None, None)],
                           [], ASKED, True)
    assert hidden.listed["a"] == pytest.approx(odds_before_data() / 3.0, rel=1e-3)
    assert hidden.listed["b"] == pytest.approx(odds_before_data(), rel=1e-3) and hidden.listed["c"] == pytest.approx(odds_before_data())


def test_without_commissioning_the_odds_of_all_are_the_same_for_all_recordings():
    few = hidden_causes([detection("a", 0.0, 90.0, 900.0), detection("b", 0.0, 0.0, 0.0)], [], ASKED, False)
    assert sum(few.listed.values()) == pytest.approx(WITHOUT_COMMISSIONING) and few.unlisted == 0.0
    assert few.listed["b"] == pytest.approx(3.0 * few.listed["a"], rel=1e-6)
    assert hidden_causes([], [], ASKED, False) == Hidden({}, 0.0)


@pytest.mark.parametrize("asked, untold", [(1, ["a"]), (0, [])])
@pytest.mark.parametrize("commissioned", [True, False])
def test_no_effect_stays_ahead_where_hardly_any_is_asked_about(asked, untold, commissioned):
    hidden = hidden_causes([], untold, asked, commissioned)
    assert set(hidden.listed) == set(untold)
    assert next(iter(with_hidden(Verdict("no_gap", (), SETS, marginal_of(SETS)), hidden).sets)) == ()


def test_hidden_causes_stand_beside_what_evidence_says_by_their_odds_against_no_effect():
    before = Verdict("no_gap", (), SETS, marginal_of(SETS))
    after = with_hidden(before, Hidden({FAN[0]: 0.15, LEAK[0]: 0.05}, 0.05))
    whole = 1.0 + 0.9 * 0.25
    assert after.word == "no_gap" and after.sets[()] == pytest.approx(0.9 / whole) and sum(after.sets.values()) == pytest.approx(1.0)
    assert after.sets[FAN] == pytest.approx((0.03 + 0.9 * 0.15) / whole) and after.sets[LEAK] == pytest.approx(0.9 * 0.05 / whole)
    assert after.sets[PAIR] == pytest.approx(0.02 / whole) and after.effects[FAN[0]] == pytest.approx(after.sets[FAN] + after.sets[PAIR])
    assert list(after.sets.values()) == sorted(after.sets.values(), reverse=True)


@pytest.mark.parametrize("rival", [FAN, OUTSIDE])
def test_no_effect_stays_ahead_of_a_near_rival(rival):
    sets = {(): 0.51, rival: 0.49}
    after = with_hidden(Verdict("no_gap", (), sets, marginal_of(sets)), Hidden({LEAK[0]: 0.3}, 0.4))
    assert next(iter(after.sets)) == () and sum(after.sets.values()) == pytest.approx(1.0)


def test_where_nothing_hides_nothing_changes():
    before = Verdict("no_gap", (), SETS, marginal_of(SETS))
    assert with_hidden(before, Hidden({}, 0.0)).sets == SETS
