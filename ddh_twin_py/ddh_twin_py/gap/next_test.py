"""The test that would best tell the leading hypotheses apart, of duties that the unit can do and of sensors that it lacks.

Each candidate is rehearsed and predicted under every hypothesis. A first look takes the parameters as
known; the few that promise most are then judged with what the recordings leave open of them
(`separating`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.experiment import Experiment
from ddh_twin_py.gap.beliefs import beliefs
from ddh_twin_py.gap.candidate_tests import LENGTH, CandidateTest, candidate_tests
from ddh_twin_py.gap.classes import TELLS_APART
from ddh_twin_py.gap.direct_drive import STEP, DirectDrive
from ddh_twin_py.gap.search import Found
from ddh_twin_py.gap.separating import Believed, Remaining, Trial
from ddh_twin_py.twin.rehearsal import NODE_READ, rehearse

JOINED, NO_EFFECT = " + ", "no effect"
"""What stands between the effects of a set, and for the set of none."""
SETTLED = 0.95
"""Probability of the leading set from which nothing is left to tell apart."""
_ENOUGH = 10.0  # log Bayes factor beyond which more is worth no more
_LOOKED_AT = 2  # tests that are judged with their parameters free
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


def next_test(model: DirectDrive, found: Found, progress: Callable[[float], None] | None = None) -> dict | None:
    """What to do next, by the contract: description, between, expected_separation.

    Args:
        model, found: of the case, as the search left them. progress: told the share done.

    Returns:
        None where the leading set is settled or no candidate would tell it from its rivals.
    """
    held = beliefs(found)
    if len(held) < 2 or held[0][1] > SETTLED:
        return None
    told = progress or (lambda share: None)
    leader, rivals = held[0][0], [b for b, _ in held[1:]]
    weight = np.array([p for _, p in held[1:]]) / sum(p for _, p in held[1:])
    remaining = Remaining(found.linearised)
    looks = _first_looks(model, found, leader, rivals, weight, lambda share: told(0.4 * share))
    best: tuple[float, Option, np.ndarray] | None = None
    for number, (trial, options, differences) in enumerate(looks[:_LOOKED_AT]):
        sensitivities = trial.sensitivities(leader, remaining)
        k, g = leader.theta.size, len(remaining.laws)
        for option in options:
            kept = trial.rows(option.sensors)
            apart = np.array([
                trial.apart(d + sensitivities[:, k : k + g] @ (remaining.slack(leader) - remaining.slack(rival)), sensitivities,
                            remaining.freedom(rival), kept) for d, rival in zip(differences, rivals, strict=True)])
            worth = float(weight @ np.minimum(apart, _ENOUGH))
            if best is None or worth > best[0]:
                best = worth, option, apart
        told(0.4 + 0.6 * (number + 1) / _LOOKED_AT)
    if best is None or best[0] < _TOO_LITTLE:
        return None
    _, option, apart = best
    told_apart = [i for i in range(len(rivals)) if apart[i] >= TELLS_APART] or [int(np.argmax(apart))]
    alike = [_name(rival) for i, rival in enumerate(rivals) if i not in told_apart]
    rest = f" It would not tell {_name(leader)} from {', '.join(alike)}." if alike else ""
    return {"description": option.words + rest, "between": [_name(leader), *(_name(rivals[i]) for i in told_apart)],
            "expected_separation": round(float(min(apart[i] for i in told_apart)), 2)}


def _name(belief: Believed) -> str:
    """A set by its effects; none is said so."""
    return JOINED.join(belief.effects) or NO_EFFECT


def _first_looks(model: DirectDrive, found: Found, leader: Believed, rivals: Sequence[Believed], weight: np.ndarray,
                 told: Callable[[float], None]) -> list[tuple[Trial, list[Option], list[np.ndarray]]]:
    """Candidates with their options and the differences of leader and rivals, most promising first, parameters taken as known."""
    number = model.altered.index(True)
    experiment = model.experiments[number]
    sensors = tuple(experiment.sensors)
    pressures = any(name.startswith("pressure_") for name in experiment.signals)
    _, temperatures = experiment.operating(model.record(number, leader.theta, leader.acting), STEP)
    tests = candidate_tests(model.rig, round(float(experiment.payload), 1), float(np.mean(experiment.air)), temperatures[-1])
    found_looks = []
    for i, test in enumerate(tests):
        options = [Option(test, sensors, "")]
        if i == 0:
            options += [Option(test, (*sensors, name), name) for name in NODE_READ if name not in sensors]
        read = [name for name in NODE_READ if any(name in o.sensors for o in options)]
        recording = rehearse(model.rig, test.duty, LENGTH, read, pressures, test.start, "candidate test")
        trial = Trial(model, found.linearised, Experiment(recording, model.rig))
        of_leader = trial.features(trial.predict(leader.theta, leader.acting))
        differences = [of_leader - trial.features(trial.predict(r.theta, r.acting)) for r in rivals]
        promise = max(float(weight @ [min(trial.crude(d, trial.rows(o.sensors)), 10.0 * _ENOUGH) for d in differences]) for o in options)
        found_looks.append((promise, i, (trial, options, differences)))
        told((i + 1) / len(tests))
    return [look for _, _, look in sorted(found_looks, key=lambda row: (-row[0], row[1]))]
