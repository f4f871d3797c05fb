"""Laws that are free: a right cause gains nothing by it, one whose law is bent does; what is beyond it is a second effect."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.law_freedom import LawFreedom, gain_of_freedom
from ddh_twin_py.gap.explain.partners import beside, partners
from ddh_twin_py.gap.explain.refit import Refit
from support.first_order import EFFECTS, FirstOrder

TRUE = np.array([1.0, -0.8, 0.5])
GAIN, LAG, OFFSET = (replace(effect, law_error=0.1) for effect in EFFECTS)


def fitted(model, *effects):
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, (GAIN, LAG, OFFSET)), np.zeros(3), pool)
    columns = [next(c for c in linearised.columns if c.effect.id == effect.id and c.x > 0.0) for effect in effects]
    return linearised, Refit(linearised).of(columns, TRUE, np.ones(len(columns)))


def test_a_right_cause_gains_next_to_nothing_and_one_whose_law_is_bent_much():
    model = FirstOrder(TRUE, [(GAIN, 0, 0.6)], seed=5)
    straight = gain_of_freedom(*fitted(model, GAIN), 3.0)
    doing = model.run_one(1, TRUE, [(GAIN, 0, 0.6)])["other_flow"] - model.run_one(1, TRUE)["other_flow"]
    read = model.signals[1]["other_flow"]
    model.signals[1]["other_flow"] = replace(read, measured=read.measured + 0.5 * np.maximum(doing, 0.0))
    assert straight < 5.0 and gain_of_freedom(*fitted(model, GAIN), 3.0) > 5.0 * max(straight, 3.0)


def test_a_law_without_error_has_no_freedom():
    linearised, first = fitted(FirstOrder(TRUE, [(GAIN, 0, 0.6)], seed=5), GAIN)
    freedom = LawFreedom(linearised, first, {"valve.gain": 0.0})
    assert freedom.none and freedom.log_evidence(first) == first.log_evidence


def test_what_lies_beyond_the_freedom_of_the_first_is_left_to_the_second():
    model = FirstOrder(TRUE, [(GAIN, 0, 0.6), (OFFSET, 0, 0.15)], seed=5)
    (linearised, first), (_, both) = fitted(model, GAIN), fitted(model, GAIN, OFFSET)
    freedom = LawFreedom(linearised, first, {"valve.gain": 0.1})
    beyond = freedom.log_evidence(both) - freedom.log_evidence(first)
    assert 0.5 * (both.log_evidence - first.log_evidence) < beyond


def test_partners_are_weighed_beside_the_first_as_it_acts():
    """As a full fit would, where the law of the first bends: a lag that is doubled."""
    model = FirstOrder(TRUE, [(LAG, 0, 0.9), (OFFSET, 0, 0.15)], seed=7)
    linearised, first = fitted(model, LAG)
    with ThreadPoolExecutor(2) as pool:
        found = partners(linearised, Refit(linearised), first, beside(linearised, first, pool))
    log, pair = found[("meter.offset", "valve.lag")]
    full = Refit(linearised).of([linearised.columns[i] for i in pair.columns], pair.shared, pair.departure)
    assert full.effects == ("meter.offset", "valve.lag") and log == pytest.approx(full.log_evidence, abs=3.0)
    assert set(found) == {("meter.offset", "valve.lag"), ("valve.gain", "valve.lag")}
    assert max(found, key=lambda ids: found[ids][0]) == ("meter.offset", "valve.lag")


def test_what_no_step_of_the_first_found_is_no_merit_of_a_partner():
    model = FirstOrder(TRUE, [(GAIN, 0, 0.6), (OFFSET, 0, 0.15)], seed=5)
    linearised, first = fitted(model, GAIN)
    with ThreadPoolExecutor(2) as pool:
        there = beside(linearised, first, pool)
    found, stuck = (partners(linearised, Refit(linearised), fit, there)
                    for fit in (first, replace(first, log_evidence=first.log_evidence - 20.0)))
    for ids, (log, _) in found.items():
        assert stuck[ids][0] == pytest.approx(log - 20.0, abs=0.5), ids


def test_what_others_do_beside_the_first_holds_for_as_long_as_that_hardly_moves():
    model = FirstOrder(TRUE, [(LAG, 0, 0.9), (OFFSET, 0, 0.15)], seed=7)
    (linearised, first), (_, other) = fitted(model, LAG), fitted(model, OFFSET)
    with ThreadPoolExecutor(2) as pool:
        there = beside(linearised, first, pool)
    assert there.holds(replace(first, x=1.05 * first.x, theta=first.theta + 0.2))
    assert not there.holds(replace(first, x=1.2 * first.x))
    assert not there.holds(replace(first, theta=first.theta + 0.6)) and not there.holds(replace(first, beside=first.beside + 0.6))
    assert not there.holds(other)


def test_what_others_do_beside_the_first_is_told_in_the_deviations_of_any_comparison():
    """Of rows twice as uncertain half as many; sums of pairs are then those of columns taken anew."""
    model = FirstOrder(TRUE, [(LAG, 0, 0.9), (OFFSET, 0, 0.15)], seed=7)
    linearised, first = fitted(model, LAG)
    doubled = linearised.scattering(dict.fromkeys(linearised.scatter_beside(first.predictions), 2.0))
    with ThreadPoolExecutor(2) as pool:
        kept, anew = beside(linearised, first, pool).of(doubled.comparisons), beside(doubled, first, pool).of(doubled.comparisons)
    for mine, other in zip(kept, anew, strict=True):
        assert mine.way == other.way and all(np.allclose(a, b, rtol=1e-9) for a, b in zip(mine.change, other.change, strict=True))
    assert any(np.any(np.abs(new.spread / old.spread - 1.0) > 0.1)
               for new, old in zip(doubled.comparisons, linearised.comparisons, strict=True))
