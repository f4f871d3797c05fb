"""The test that would best tell the leading hypotheses apart, of duties that the unit can do and of sensors that it lacks.

Each candidate is rehearsed and predicted under every hypothesis. What the recordings leave open of the
rig's parameters (`separating`) is taken in full in the usual test; the others are compared by the few
combinations of parameters that showed most there, and the best of them is then judged in full too.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.gap.contract import NextTest
from ddh_twin_py.gap.drive.candidate_tests import LENGTH, CandidateTest, candidate_tests
from ddh_twin_py.gap.drive.direct_drive import STEP, DirectDrive
from ddh_twin_py.gap.drive.rehearsed_trial import RehearsedTrial
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.explain.side_by_side import side_by_side
from ddh_twin_py.gap.next_test.proposal import Contest
from ddh_twin_py.gap.next_test.separating import Believed, Remaining, root_of
from ddh_twin_py.twin.rehearsal import rehearse
from ddh_twin_py.twin.temperature_sensors import SENSORS

_SURE = 1000.0  # log Bayes factor beyond which none is told
_DIRECTIONS = 10  # combinations of parameters by which tests are compared at first
_NEGLIGIBLE = 0.02  # of the noise: what an unknown may move in the usual test without counting elsewhere


@dataclass(frozen=True)
class Option:
    """A candidate with the temperature sensors that are read in it, and which of them the recordings lack ('' none)."""

    test: CandidateTest
    sensors: tuple[str, ...]
    added: str

    @property
    def words(self) -> str:
        """What is to be done."""
        if not self.added:
            return self.test.words[:1].upper() + self.test.words[1:] + "."
        return f"Put a temperature sensor on the {_PLACE[self.added]}, then {self.test.words}."


_PLACE = {"motor_winding": "motor's end winding", "motor_housing": "motor housing", "pump_1_case": "case of pump 1",
          "pump_2_case": "case of pump 2", "tank_oil": "tank's oil", "tank_wall": "tank wall", "cylinder_barrel": "cylinder barrel",
          "line_a": "line A", "line_b": "line B"}


@dataclass(frozen=True)
class _Look:
    """A candidate, with the differences of leader and rivals, (rows,) each, and what is open of each rival's departures, (rows, m)."""

    trial: RehearsedTrial
    options: list[Option]
    differences: list[np.ndarray]
    departures: list[np.ndarray]

    def apart(self, free: np.ndarray, option: Option) -> np.ndarray:
        """Expected log Bayes factors of the leader against each rival, (r,), with what else is open, (rows, q)."""
        kept = self.trial.rows(option.sensors)
        return np.array([self.trial.apart(d, np.hstack([free, own]), kept)
                         for d, own in zip(self.differences, self.departures, strict=True)])


def next_test(model: DirectDrive, found: Found) -> NextTest | None:
    """What to do next, by the contract, see `Contest.proposal`.

    Args:
        model, found: of the case, as the search left them.

    Returns:
        None where the leading set is settled or no candidate would tell it from its rivals.
    """
    contest = Contest.of(found)
    if contest is None:
        return None
    leader = contest.leader
    remaining = Remaining(found.linearised, [leader, *contest.rivals])
    looks = _looks(model, found, contest, remaining)
    if not looks:
        return None
    usual, *others = looks
    every = usual.trial.sensitivities(leader, remaining)
    root = root_of(remaining, usual.trial.added)
    judged = [(option, usual.apart(every @ root, option)) for option in usual.options]
    if others:
        directions = root @ _directions(usual, every @ root)
        moves = directions[: remaining.covariance.shape[0]]
        promise = []
        for look in others:
            free = look.trial.along(leader, remaining, moves)
            promise.append(max(contest.worth(look.apart(free, option)) for option in look.options))
        look = others[int(np.argmax(promise))]
        matters = np.diagonal(usual.trial.products(every, usual.trial.rows(usual.options[0].sensors)))[: moves.shape[0]] > _NEGLIGIBLE**2
        free = look.trial.sensitivities(leader, remaining, matters) @ root_of(remaining, look.trial.added)
        judged += [(option, look.apart(free, option)) for option in look.options]
    best = contest.best(judged)
    return contest.proposal(best[0].words, best[1], _SURE) if best else None


def _directions(look: _Look, free: np.ndarray) -> np.ndarray:
    """The few combinations of the unknowns that show most in a test, and those that take up its differences, (q, r).

    Args:
        free: what is open, as independent columns, (rows, q).
    """
    kept = look.trial.rows(look.options[0].sensors)
    products = look.trial.products(np.column_stack([free, *look.differences]), kept)
    q = free.shape[1]
    taken = np.linalg.solve(np.eye(q) + products[:q, :q], products[:q, q:])
    _, vector = np.linalg.eigh(products[:q, :q])
    out, _ = np.linalg.qr(np.column_stack([taken, vector[:, -_DIRECTIONS:]]))
    return out


def _looks(model: DirectDrive, found: Found, contest: Contest, remaining: Remaining) -> list[_Look]:
    """Every candidate predicted under leader and rivals; the usual one first."""
    leader, rivals = contest.leader, contest.rivals
    out = []
    for trial, options in trials(model, found, leader):
        of_leader, *of_rivals = [trial.features(b.theta, b.acting) for b in (leader, *rivals)]
        of_slack = [trial.along(leader, remaining, remaining.move_of_slack(leader, r))[:, 0] for r in rivals]
        differences = [of_leader - f + s for f, s in zip(of_rivals, of_slack, strict=True)]
        out.append(_Look(trial, options, differences, [trial.of_departures(r) for r in rivals]))
    return out


def trials(model: DirectDrive, found: Found, leader: Believed) -> list[tuple[RehearsedTrial, list[Option]]]:
    """Every candidate rehearsed, with its options; the usual one, with added sensors, first."""
    experiment = model.field[0]
    sensors = tuple(experiment.sensors)
    pressures = any(name.startswith("pressure_") for name in experiment.signals)
    _, temperatures = experiment.operating(model.record(model.first, leader.theta, leader.acting), STEP)
    tests = candidate_tests(model.rig, round(float(experiment.payload), 1), float(np.mean(experiment.air)), temperatures[-1])

    def candidate(test: CandidateTest) -> tuple[RehearsedTrial, list[Option]]:
        options = [Option(test, sensors, "")]
        if test is tests[0]:
            options += [Option(test, (*sensors, name), name) for name in SENSORS if name not in sensors]
        read = [name for name in SENSORS if any(name in o.sensors for o in options)]
        recording = rehearse(model.rig, test.duty, LENGTH, read, pressures, test.start, "candidate test")
        return RehearsedTrial(model, found.linearised, Experiment(recording, model.rig)), options

    return side_by_side([partial(candidate, test) for test in tests])
