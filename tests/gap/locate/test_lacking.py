"""What the twin lacks at a place, by phase and by regime."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.locate.lacking import ActingEffect, Course, chi_square_by_phase, lacks
from support.made_comparison import comparisons

LEAK, SEAL = EFFECTS["pump_1.leakage"], EFFECTS["cylinder.seal_friction"]


def course(value, unit, phase, **regimes):
    return Course(np.array(value), unit, np.array(phase), {(name, "K"): np.array(v) for name, v in regimes.items()})


def test_rows_by_phase_and_regime():
    warmth = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    leak = ActingEffect(LEAK, course([1.0, 3.0, 5.0, 7.0, 9.0, 11.0], "m3/s", [0, 0, 1, 1, 2, 2], warmth=warmth), 0.7,
                        {"lifting": 0.8, "lowering": 0.2}, 0.1)
    seal = ActingEffect(SEAL, course([-4.0, -4.0], "N", [0, 1], warmth=[2.0, 2.0]), 0.3, {"all": 1.0}, 0.5)
    rows = lacks([seal, leak])
    named = [(r.component, r.phase, r.value, r.unit) for r in rows if r.regime == ""]
    assert named == [("pump_1", "lifting", 2.0, "m3/s"), ("cylinder", "all", -4.0, "N"), ("pump_1", "lowering", 6.0, "m3/s")]
    assert [r.share for r in rows[:3]] == pytest.approx([0.56, 0.3, 0.14]) and sum(r.share for r in rows) == pytest.approx(1.0)
    assert [r.std for r in rows[:3]] == pytest.approx([0.2, 2.0, 0.6])
    regimes = [r for r in rows if r.regime]
    assert [r.component for r in regimes] == ["pump_1"] * 3  # one that does not vary has no regimes
    assert regimes[0].value < regimes[1].value < regimes[2].value and regimes[0].regime.startswith("warmth 1 to 2.667 K")


@pytest.mark.parametrize(("warmth", "read"), [
    ([0.0, 300.0, 387.0, 387.0, 387.0, 387.00001], ["warmth 0 to 358 K", "warmth 358 to 387 K"]),
    ([0.0, 387.0, 387.0, 387.0, 387.00001, 387.00002], []),
])  # fmt: skip
def test_regimes_read_as_parts(warmth, read):
    rows = lacks([ActingEffect(LEAK, course([1.0] * 6, "m3/s", [0] * 6, warmth=warmth), 1.0, {"lifting": 1.0}, 0.1)])
    assert [row.regime for row in rows if row.regime] == read


@pytest.mark.parametrize(("speeds", "means"), [
    ([100.0, 100.00001, 200.0], [29.5, 74.5]), ([50.0, 100.0, 100.00001], [14.5, 59.5]), ([0.0, 100.0, 200.0], [14.5, 44.5, 74.5]),
])  # fmt: skip
def test_regimes_whose_edges_read_alike_lose_no_sample(speeds, means):
    value = np.arange(90.0)
    rows = lacks([ActingEffect(LEAK, course(value, "m3/s", [0] * 90, speed=np.repeat(speeds, 30)), 1.0, {"lifting": 1.0}, 0.1)])
    assert [row.value for row in rows if row.regime] == pytest.approx(means)


def test_a_phase_that_never_was_lacks_nothing():
    (row,) = lacks([ActingEffect(LEAK, course([1.0, 1.0], "m3/s", [0, 0]), 1.0, {"lowering": 1.0}, 0.1)])
    assert row.value == row.std == 0.0


def test_chi_square_by_phase():
    made = comparisons()
    changes = []
    for comparison in made:
        change = np.zeros(comparison.size)
        for block in comparison.blocks:
            change[block.rows] = np.where(block.binning.phase == 3, 2.0, 1.0)
        changes.append(change)
    parts = chi_square_by_phase(changes, made)
    assert sum(parts.values()) == pytest.approx(1.0) and list(parts.values()) == sorted(parts.values(), reverse=True)
    phases = np.concatenate([b.binning.phase for c in made for b in c.blocks])
    weights = {"lifting": 1.0, "transient": 4.0, "all": 1.0}
    counts = {"lifting": (phases == 0).sum(), "transient": (phases == 3).sum(), "all": (phases < 0).sum()}
    total = sum(weights[k] * counts[k] for k in counts)
    assert parts == {k: pytest.approx(weights[k] * counts[k] / total) for k in counts}


def test_an_effect_that_changes_nothing_has_no_parts():
    comparison = SimpleNamespace(blocks=[SimpleNamespace(rows=slice(0, 2), binning=SimpleNamespace(phase=np.array([0, 1])))])
    assert chi_square_by_phase([np.zeros(2)], [comparison]) == {"lifting": 0.0, "lowering": 0.0}
