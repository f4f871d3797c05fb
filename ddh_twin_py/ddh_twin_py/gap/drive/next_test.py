"""The test that would best tell the leading hypotheses apart, of duties that the unit can do and of sensors that it lacks.

Each candidate is rehearsed and predicted under every hypothesis. What the recordings leave open of the
rig's parameters (`separating`) is taken in full in the usual test; the others are compared by the few
combinations of parameters that showed most there, and the best of them is then judged in full too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.experiment import Experiment
from ddh_twin_py.gap.drive.candidate_tests import LENGTH, CandidateTest, candidate_tests
from ddh_twin_py.gap.drive.direct_drive import STEP, DirectDrive
from ddh_twin_py.gap.drive.rehearsed_trial import RehearsedTrial
from ddh_twin_py.gap.explain.classes import TELLS_APART
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.next_test.beliefs import beliefs
from ddh_twin_py.gap.next_test.separating import Believed, Remaining, root_of
from ddh_twin_py.twin.rehearsal import rehearse
from ddh_twin_py.twin.temperature_sensors import SENSORS

JOINED, NO_EFFECT = " + ", "no effect"
"""What stands between the effects of a set, and for the set of none."""
SETTLED = 0.95
"""Probability of the leading set from which nothing is left to tell apart."""
DECIDES = 1.0
"""Expected log Bayes factor below which a test leaves the odds nearly as they are."""
_SURE = 1000.0  # log Bayes factor beyond which none is told
_ENOUGH = 10.0  # log Bayes factor beyond which more is worth no more
_DIRECTIONS = 10  # combinations of parameters by which tests are compared at first
_NEGLIGIBLE = 0.02  # of the noise: what an unknown may move in the usual test without counting elsewhere
_TOO_LITTLE = 0.1  # log Bayes factor below which no test is proposed


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
class Choice:
    """The option that tells a leader from its rivals best.

    Attributes:
        option: what to do. leader, rivals: sets between which it decides. apart: expected log Bayes factor of the
            leader against each rival, (r,).
    """

    option: Option
    leader: Believed
    rivals: list[Believed]
    apart: np.ndarray


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


def next_test(model: DirectDrive, found: Found, progress: Callable[[float], None] | None = None) -> dict | None:
    """What to do next, by the contract: description, between, expected_separation.

    The expected separation is that from the nearest of the rivals named in ``between``.

    Args:
        model, found: of the case, as the search left them. progress: told the share done.

    Returns:
        None where the leading set is settled or no candidate would tell it from its rivals.
    """
    choice = choose(model, found, progress)
    if choice is None:
        return None
    told_apart = [i for i, value in enumerate(choice.apart) if value >= TELLS_APART] or [int(np.argmax(choice.apart))]
    alike = [_name(rival) for i, rival in enumerate(choice.rivals) if i not in told_apart]
    rest = f" It would not tell {_name(choice.leader)} from {', '.join(alike)}." if alike else ""
    separation = round(min(_SURE, *(float(choice.apart[i]) for i in told_apart)), 2)
    return {"description": described(choice.option.words, separation) + rest,
            "between": [_name(choice.leader), *(_name(choice.rivals[i]) for i in told_apart)],
            "expected_separation": separation}


def described(words: str, separation: float) -> str:
    """What is to be done, with a word of warning where no candidate would decide."""
    return words if separation >= DECIDES else f"No test of the list would decide this; the one that tells most of them: {words}"


def choose(model: DirectDrive, found: Found, progress: Callable[[float], None] | None = None) -> Choice | None:
    """The option that tells the leading sets apart best; see `next_test`."""
    held = beliefs(found)
    if len(held) < 2 or held[0][1] > SETTLED:
        return None
    told = progress or (lambda share: None)
    leader, rivals = held[0][0], [b for b, _ in held[1:]]
    weight = np.array([p for _, p in held[1:]]) / sum(p for _, p in held[1:])
    remaining = Remaining(found.linearised, [leader, *rivals])
    looks = _looks(model, found, leader, rivals, remaining, lambda share: told(0.25 * share))
    if not looks:
        return None
    usual, *others = looks
    every = usual.trial.sensitivities(leader, remaining)
    root = root_of(remaining, usual.trial.added)
    judged = [(option, usual.apart(every @ root, option)) for option in usual.options]
    told(0.5)
    if others:
        directions = root @ _directions(usual, every @ root)
        moves = directions[: remaining.covariance.shape[0]]
        promise = []
        for i, look in enumerate(others):
            free = look.trial.along(leader, remaining, moves)
            promise.append(max(_worth(look.apart(free, option), weight) for option in look.options))
            told(0.5 + 0.3 * (i + 1) / len(others))
        look = others[int(np.argmax(promise))]
        matters = np.diagonal(usual.trial.products(every, usual.trial.rows(usual.options[0].sensors)))[: moves.shape[0]] > _NEGLIGIBLE**2
        free = look.trial.sensitivities(leader, remaining, matters) @ root_of(remaining, look.trial.added)
        judged += [(option, look.apart(free, option)) for option in look.options]
    told(1.0)
    option, apart = max(judged, key=lambda row: _worth(row[1], weight))
    return Choice(option, leader, rivals, apart) if _worth(apart, weight) > _TOO_LITTLE else None


def _worth(apart: np.ndarray, weight: np.ndarray) -> float:
    """What a test is worth, from its expected log Bayes factors, (r,), and the rivals' weights, (r,)."""
    return float(weight @ np.minimum(apart, _ENOUGH))


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


def _name(belief: Believed) -> str:
    """A set by its effects; none is said so."""
    return JOINED.join(belief.effects) or NO_EFFECT


def _looks(model: DirectDrive, found: Found, leader: Believed, rivals: Sequence[Believed], remaining: Remaining,
           told: Callable[[float], None]) -> list[_Look]:
    """Every candidate predicted under leader and rivals; the usual one first."""
    out = []
    for done, trial, options in trials(model, found, leader):
        of_leader, *of_rivals = [trial.features(b.theta, b.acting) for b in (leader, *rivals)]
        of_slack = [trial.along(leader, remaining, remaining.move_of_slack(leader, r))[:, 0] for r in rivals]
        differences = [of_leader - f + s for f, s in zip(of_rivals, of_slack, strict=True)]
        out.append(_Look(trial, options, differences, [trial.of_departures(r) for r in rivals]))
        told(done)
    return out


def trials(model: DirectDrive, found: Found, leader: Believed) -> Iterator[tuple[float, RehearsedTrial, list[Option]]]:
    """Every candidate rehearsed, with its options, and which share of them it completes; the usual one, with added sensors, first."""
    number = model.altered.index(True)
    experiment = model.experiments[number]
    sensors = tuple(experiment.sensors)
    pressures = any(name.startswith("pressure_") for name in experiment.signals)
    _, temperatures = experiment.operating(model.record(number, leader.theta, leader.acting), STEP)
    tests = candidate_tests(model.rig, round(float(experiment.payload), 1), float(np.mean(experiment.air)), temperatures[-1])
    for i, test in enumerate(tests):
        options = [Option(test, sensors, "")]
        if i == 0:
            options += [Option(test, (*sensors, name), name) for name in SENSORS if name not in sensors]
        read = [name for name in SENSORS if any(name in o.sensors for o in options)]
        recording = rehearse(model.rig, test.duty, LENGTH, read, pressures, test.start, "candidate test")
        yield (i + 1) / len(tests), RehearsedTrial(model, found.linearised, Experiment(recording, model.rig)), options
