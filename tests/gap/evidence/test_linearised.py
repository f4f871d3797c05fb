"""A case about one place and about places nearby."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from support.first_order import EFFECTS, FirstOrder


def test_a_place_nearby_runs_each_recording_once_and_answers_as_if_it_had_been_linearised_there():
    model = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[0], 0, 0.2)], seed=3)
    there = np.array([0.3, -0.2, 0.1])
    with ThreadPoolExecutor(2) as pool:
        taken = linearise(Question(model, EFFECTS), np.zeros(3), pool)
        anew = linearise(Question(model, EFFECTS), there, pool)
    ran, run_one = [], model.run_one
    model.run_one = lambda number, theta, acting=(), roughly=False: ran.append(number) or run_one(number, theta, acting, roughly)
    nearby = taken.nearby(there)
    assert ran == [0, 1] and np.array_equal(nearby.theta, there) and np.array_equal(nearby.taken, np.zeros(3))
    for name in model.signals[1]:
        assert np.array_equal(nearby.predictions[1][name], anew.predictions[1][name])
    of_taken, of_anew, of_nearby = (case.evidence.none.shared for case in (taken, anew, nearby))
    assert of_nearby == pytest.approx(of_anew, abs=0.1) and not np.array_equal(of_nearby, of_taken)
    best = [max(case.evidence.singles(), key=lambda h: h.log_evidence) for case in (anew, nearby)]
    assert best[0].columns == best[1].columns
    assert best[1].log_evidence == pytest.approx(best[0].log_evidence, rel=0.1)


def test_sensitivities_follow_the_deviations_of_a_place_nearby():
    model = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[0], 0, 0.2)], seed=3)
    with ThreadPoolExecutor(2) as pool:
        taken = linearise(Question(model, EFFECTS), np.zeros(3), pool)
    nearby = taken.nearby(np.array([0.4, 0.4, 0.0]))
    for before, after, old, new in zip(taken.sensitivities, nearby.sensitivities, taken.comparisons, nearby.comparisons, strict=True):
        assert after * new.spread[:, None] == pytest.approx(before * old.spread[:, None])


def test_a_rig_that_is_held_takes_nothing_up():
    built = np.array([1.0, -0.8, 0.5])
    model = FirstOrder(built, [(EFFECTS[0], 0, 0.2)], seed=3)
    with ThreadPoolExecutor(2) as pool:
        taken = linearise(Question(model, EFFECTS), np.zeros(3), pool)
    held, nearby = taken.held_at(built), taken.nearby(built)
    for value, comparison, prediction in zip(held.values(), nearby.comparisons, nearby.predictions, strict=True):
        assert value == pytest.approx(comparison.residual(prediction))
    best = [max(case.evidence.singles(), key=lambda h: h.log_evidence) for case in (held, nearby)]
    assert best[0].log_evidence > best[1].log_evidence + 3.0, "what parameters took up is the effect's"
