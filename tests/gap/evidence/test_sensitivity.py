"""Columns of effects."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy
from ddh_twin_py.gap.evidence.sensitivity import TYPICAL, columns_of, reaching, rise_of, taken_at, typical
from support.first_order import EFFECTS, FirstOrder


class Astray(FirstOrder):
    """Its rough runs go astray by whatever acts."""

    def run_one(self, number, theta, acting=(), roughly=False):
        found = super().run_one(number, theta, acting)
        far = 1.0e3 * bool(len(acting)) if roughly else 0.0
        return {name: y + far for name, y in found.items()}


def columns(model):
    comparisons = [Comparison(s, p, Discrepancy()) for s, p in zip(model.signals, model.run(np.zeros(3)), strict=True)]
    with ThreadPoolExecutor(2) as pool:
        return columns_of(EFFECTS, model, np.zeros(3), comparisons, pool)


def test_a_column_moves_the_worst_signal_by_a_typical_rise():
    found = columns(FirstOrder(np.zeros(3)))
    assert {c.effect.id for c in found} == {e.id for e in EFFECTS}
    assert all(0.4 * TYPICAL <= c.rise <= 2.5 * TYPICAL for c in found)


@pytest.mark.parametrize(("times", "before", "sought"), [
    (0.1, TYPICAL, True), (4.0, TYPICAL, True), (0.8, TYPICAL, False), (0.1, 0.1 * TYPICAL, False)])
def test_a_column_that_is_no_longer_typical_elsewhere_is_sought_anew(times, before, sought):
    """One that never rose as it should stays what it was, as one does that still rises so, and every one that is to be kept."""
    model, theta = FirstOrder(np.zeros(3)), np.zeros(3)
    comparisons = [Comparison(s, p, Discrepancy()) for s, p in zip(model.signals, model.run(theta), strict=True)]
    near = [replace(c, x=times * c.x, taken=times * c.x, rise=before) for c in columns(model) if c.x > 0.0]
    with ThreadPoolExecutor(2) as pool:
        kept, found = ({c.way: c for c in taken_at(EFFECTS, model, theta, comparisons, pool, near=near, keep=keep)[0]}
                       for keep in (True, False))
    assert all(kept[c.way].x == c.x for c in near)
    assert all(typical(found[c.way].rise) if sought else found[c.way].x == c.x for c in near)
    assert any(found[c.way].x != c.x for c in near) == sought


def test_rough_runs_that_go_astray_hide_no_effect():
    plain, astray = columns(FirstOrder(np.zeros(3))), columns(Astray(np.zeros(3)))
    assert [(c.effect.id, c.law, np.sign(c.x)) for c in astray] == [(c.effect.id, c.law, np.sign(c.x)) for c in plain]
    assert all(0.1 * TYPICAL <= c.rise <= 10.0 * TYPICAL for c in astray)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_run_that_went_astray_rises_beyond_all_bounds(wrong):
    model = FirstOrder(np.zeros(3))
    without = model.run(np.zeros(3))
    lost = [{name: np.full_like(values, wrong) for name, values in run.items()} for run in without]
    assert rise_of(model.signals, lost, without)[0] == np.inf


@pytest.mark.parametrize("threshold", [2.8e6, 4.0e5, 1.1e7])
def test_a_law_with_a_threshold_is_met_behind_it(threshold):
    def rise(x):
        return 3.0e-6 * max(0.0, -x - threshold)

    x = reaching(rise, lambda x: max(x, -1.4e7), -5.0e5)
    assert 0.4 * TYPICAL <= rise(x) <= 2.5 * TYPICAL


def test_what_no_departure_allowed_moves_far_is_taken_as_far_as_it_goes():
    assert reaching(lambda x: 0.1 * x, lambda x: min(x, 3.0), 0.5) == 3.0


def test_a_departure_that_sends_the_run_astray_is_drawn_back():
    x = reaching(lambda x: x if x < 8.0 else np.nan, lambda x: x, 50.0)
    assert 0.4 * TYPICAL <= x <= 2.5 * TYPICAL
