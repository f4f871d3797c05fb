"""Columns of effects."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from ddh_twin_py.estimation.comparison import Comparison, Discrepancy
from ddh_twin_py.gap.sensitivity import TYPICAL, columns_of
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


def test_rough_runs_that_go_astray_hide_no_effect():
    plain, astray = columns(FirstOrder(np.zeros(3))), columns(Astray(np.zeros(3)))
    assert [(c.effect.id, c.law, np.sign(c.x)) for c in astray] == [(c.effect.id, c.law, np.sign(c.x)) for c in plain]
    assert all(0.4 * TYPICAL <= c.rise <= 2.5 * TYPICAL for c in astray)
