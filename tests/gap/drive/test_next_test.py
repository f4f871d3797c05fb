"""The next test, on a short recording after which two frictions are still hard to tell apart."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.drive.candidate_tests import FASTEST, SLOWEST, candidate_tests
from ddh_twin_py.gap.drive.direct_drive import DirectDrive
from ddh_twin_py.gap.drive.next_test import next_test, trials
from ddh_twin_py.gap.drive.next_test_of_unknown import next_test_of_unknown
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.search import search
from ddh_twin_py.gap.next_test.beliefs import beliefs
from ddh_twin_py.gap.next_test.proposal import DECIDES, described
from ddh_twin_py.gap.next_test.separating import Remaining, root_of
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.rehearsal import rehearse
from support.simulated import DUTY

pytestmark = pytest.mark.long
NAMES = ("pump_1.friction", "motor.bearing_friction")
BEARING, PUMP = ("motor.bearing_friction",), ("pump_1.friction",)


@pytest.fixture(scope="module")
def case():
    """A model and what a search found: 0.45 N*m more in the bearings, 60 s, one temperature sensor."""
    rig, duty = load_rig(), load_duty(DUTY / "paper_cycle.yaml")
    worn = rig.with_values({"motor.friction_coulomb": rig["motor.friction_coulomb"] + 0.45})
    before, after = (Experiment(rehearse(r, duty, 60.0, ["tank_oil"]), rig) for r in (rig, worn))
    model = DirectDrive([before], [after], rig)
    with ThreadPoolExecutor(2) as pool:
        found = search(Question(model, [EFFECTS[name] for name in NAMES]), np.zeros(model.size), pool)
    return model, replace(found, probability={BEARING: 0.6, PUMP: 0.38, (): 0.02})


def test_it_is_of_the_contracts_form_and_beats_a_rest(case):
    model, found = case
    test = next_test(model, found)
    assert set(test) == {"description", "between", "expected_separation"}
    assert test["between"][0] == BEARING[0] and len(test["between"]) > 1
    assert " rpm" in test["description"] and " kg" in test["description"] and "degC" in test["description"]
    assert test["expected_separation"] > 1.0


def test_nothing_is_proposed_where_the_leader_is_settled(case):
    model, found = case
    assert next_test(model, replace(found, probability={BEARING: 0.97, PUMP: 0.03})) is None
    assert next_test(model, replace(found, probability={BEARING: 0.9, PUMP: 0.01})) is None


def test_what_is_open_is_taken_off_as_the_dense_formula_says(case):
    model, found = case
    leader, rival = (b for b, _ in beliefs(found)[:2])
    trial, options = next(iter(trials(model, found, leader)))
    remaining = Remaining(found.linearised, [leader, rival])
    difference = trial.features(leader.theta, leader.acting) - trial.features(rival.theta, rival.acting)
    there, every = trial.rows(options[0].sensors), np.ones(difference.size, dtype=bool)
    kept = there & (np.arange(difference.size) % 7 == 0)  # as if the others were of sensors that are not there
    free = trial.sensitivities(leader, remaining) @ root_of(remaining, trial.added)
    precision = trial.products(np.eye(difference.size)[:, kept], every)
    variance = np.linalg.inv(precision) + free[kept] @ free[kept].T
    expected = 0.5 * difference[kept] @ np.linalg.solve(variance, difference[kept])
    assert trial.apart(difference, free, kept) == pytest.approx(expected, rel=1e-4)
    assert expected < trial.apart(difference, np.zeros((difference.size, 1)), kept)
    assert trial.rows(options[1].sensors).sum() > there.sum()


def test_moves_of_all_unknowns_at_once_are_the_sum_of_single_ones(case):
    model, found = case
    leader, rival = (b for b, _ in beliefs(found)[:2])
    trial, _ = next(iter(trials(model, found, leader)))
    remaining = Remaining(found.linearised, [leader, rival])
    every = trial.sensitivities(leader, remaining)[:, : remaining.covariance.shape[0]]
    move = np.zeros((every.shape[1], 1))
    chosen = [model.paths.index("cylinder.friction_coulomb"), model.paths.index("motor.torque_constant"), model.size]
    move[chosen, 0] = 0.5, -0.4, 0.8
    together = trial.along(leader, remaining, move)
    assert np.all(np.sqrt(np.mean(every[:, chosen] ** 2, axis=0)) > 0.02)
    assert np.sqrt(np.mean((together - every @ move) ** 2)) < 0.05 * np.sqrt(np.mean((every @ move) ** 2))


def test_candidates_are_what_the_drive_can_hold():
    rig = load_rig()
    cold = np.full(N, 296.15)
    tests = candidate_tests(rig, 150.0, 296.15, cold)
    assert len(tests) >= 8
    assert {t.duty.payload for t in tests} == {75.0, 150.0, 240.0}
    for test in tests:
        speeds = [s.speed / RAD_PER_S_OF_RPM for s in test.duty.cycle if s.kind in ("lift", "lower")]
        assert all(SLOWEST - 1e-6 <= s <= FASTEST + 1e-6 for s in speeds)
    limit = rig["motor.current_limit"]
    weak = candidate_tests(rig.with_values({"motor.current_limit": 0.35 * limit}), 150.0, 296.15, cold)
    raised = [max(t.duty.cycle[1].speed for t in own if t.duty.payload == 240.0) for own in (weak, tests)]
    assert raised[0] < 0.5 * raised[1]
    assert candidate_tests(rig.with_values({"motor.current_limit": 0.1 * limit}), 150.0, 296.15, cold) == []
    frozen = candidate_tests(rig, 150.0, 253.15, np.full(N, 253.15))
    assert max(t.duty.cycle[1].speed for t in frozen) < raised[1] and len({t.words for t in frozen}) == len(frozen)
    warm = candidate_tests(rig, 150.0, 296.15, np.full(N, 320.0))
    assert len(warm) == len(tests) + 2 and any("47 degC" in t.words for t in warm)


def test_of_an_unknown_that_goes_with_speed_faster_tests_are_proposed(case):
    model, found = case
    test = next_test_of_unknown(model, found, BEARING, "pressure_piston_side", 2.0, ["phase", "speed"])
    assert "1200 rpm" in test["description"] and "speed" in test["between"][0]
    assert test["expected_separation"] > 3.0
    assert next_test_of_unknown(model, found, BEARING, "temperature/line_b", 2.0, ["speed"]) is None


def test_a_test_that_would_hardly_decide_says_so():
    assert described("Lift slowly.", DECIDES) == "Lift slowly."
    said = described("Lift slowly.", 0.99 * DECIDES)
    assert said.startswith("No test of the list would decide this; ") and said.endswith("of them this one tells most: Lift slowly.")
