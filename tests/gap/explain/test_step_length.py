"""Lengths of a step whose direction may lead nowhere."""

import math

import pytest
from ddh_twin_py.gap.explain.step_length import Lengths


def tried(cost, promised, most=20):
    """Lengths until one gains, and what it gained."""
    lengths, seen = Lengths(promised), []
    while lengths.next and len(seen) < most:
        seen.append(lengths.next)
        risen = cost(lengths.next)
        if risen < 0.0:
            return seen, -risen
        lengths.lost(risen)
    return seen, 0.0


def test_a_parabola_that_bends_more_than_promised_is_met_at_its_lowest_point():
    seen, gained = tried(lambda s: -2.0 * s + 4.0 * s * s, 1.0)
    assert seen == pytest.approx([1.0, 0.25]) and gained == pytest.approx(0.25)


def test_a_direction_that_leads_upward_is_left_after_two_lengths():
    seen, gained = tried(lambda s: 0.7 * s + 0.3 * s * s, 1.0)
    assert len(seen) == 2 and gained == 0.0


def test_where_much_is_promised_a_kink_is_looked_behind():
    seen, gained = tried(lambda s: -s if s < 0.05 else 0.5 + s, 100.0)
    assert seen[-1] < 0.05 and gained > 0.0


def test_a_slope_less_steep_than_promised_is_learnt_from_two_lengths():
    seen, gained = tried(lambda s: -0.2 * s + s * s, 1.0)
    assert len(seen) == 3 and seen[-1] == pytest.approx(0.1) and gained == pytest.approx(0.01)


def test_a_run_that_went_astray_asks_for_a_tenth():
    seen, gained = tried(lambda s: math.inf if s > 0.15 else -s, 1.0)
    assert seen == pytest.approx([1.0, 0.1]) and gained == pytest.approx(0.1)


def test_what_never_gains_ends():
    seen, gained = tried(lambda s: math.inf, 1.0)
    assert 1 < len(seen) < 5 and gained == 0.0
