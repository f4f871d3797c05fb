"""Whether the free inputs of one place explain more than the hypothesis that leads."""

import numpy as np
import pytest
from ddh_twin_py.gap.explain.refit import Refit
from ddh_twin_py.gap.verdict.outdone import OUTDONE, outdone
from ddh_twin_py.gap.verdict.unknown import UNLISTED, Unknown
from support.first_order import EFFECTS, FirstOrder
from support.free_inputs import linearised_with, misread, places_in

GAIN, LAG, _ = EFFECTS


def judged(model, effect=GAIN):
    """What is unknown beside an effect, by this rule alone."""
    linearised = linearised_with(model, [GAIN, LAG])
    place = places_in(linearised)[0]
    column = next(c for c in linearised.columns if c.effect is effect and c.x > 0.0)
    refit = Refit(linearised)
    none, leader = refit.of([], np.zeros(3), np.zeros(0)), refit.of([column], np.zeros(3), np.ones(1))
    return outdone(Unknown(UNLISTED, [], 0.0, "1"), place, linearised, leader, none)


@pytest.mark.parametrize("gain", [0.05, 0.2, 0.6])
def test_what_is_true_explains_more_than_any_place(gain):
    unknown = judged(FirstOrder(np.zeros(3), [(GAIN, 0, gain)]))
    (check,) = unknown.checks
    assert check.name == "outdone" and check.measured < 0.1 * OUTDONE and OUTDONE <= check.limit
    assert unknown.probability == UNLISTED and unknown.notes == []


@pytest.mark.parametrize("theta", [(-3.0, 3.0, 0.0), (3.0, 3.0, 3.0)])
def test_where_the_linear_model_bends_places_are_not_held_for_better_than_what_is_true(theta):
    """Far from a rig that is off by itself no effect looks worse than it is, and what places explain over that is no more of it."""
    unknown = judged(FirstOrder(np.array(theta), [(LAG, 0, 0.3)]), LAG)
    (check,) = unknown.checks
    assert check.measured < 0.0 and unknown.probability == UNLISTED and unknown.notes == []


def differing(forward, backward):
    """A rig whose gain is larger by one share while the flow is positive, and by another where it is negative."""
    model = FirstOrder(np.zeros(3))
    plain = model.run_one(1, np.zeros(3))
    one, other = (model.run_one(1, np.zeros(3), [(GAIN, 0, gain)]) for gain in (forward, backward))
    for name, flow in plain.items():
        misread(model, name, lambda share, more=one[name], less=other[name], flow=flow: np.where(flow > 0.0, more, less) - flow)
    return model


def test_what_acts_in_one_direction_alone_is_not_the_law_that_acts_in_both():
    unknown = judged(differing(0.4, 0.0))
    (check,) = unknown.checks
    assert check.measured > check.limit > OUTDONE and unknown.probability > 0.9
    assert "at valve" in unknown.notes[0] and f"{check.measured:.0f} nats" in unknown.notes[0]


def test_a_law_that_errs_by_a_share_is_not_outdone():
    unknown = judged(differing(0.6, 0.4))
    (check,) = unknown.checks
    assert OUTDONE < check.measured < check.limit and unknown.probability < 0.5


def test_what_a_meter_reads_wrong_alone_is_named_by_it():
    model = FirstOrder(np.zeros(3))
    misread(model, "other_flow", lambda share: 0.3 * share)
    unknown = judged(model)
    assert unknown.probability > 0.9 and "at other_flow, freely" in unknown.notes[0]
