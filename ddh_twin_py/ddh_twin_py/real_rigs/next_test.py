"""The test that would best tell the leading hypotheses of a described rig apart, among those that its engineer says can be made.

Each test is predicted under every leading set; what the recordings leave open of parameters and laws is taken in full
(`gap.separating`), and the log Bayes factor counts by the engine's power of the likelihood, as that of the recordings does. A
test may have other inputs than the recordings or sensors that they lack: it is a `run.Run` of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.gap.drive.next_test import JOINED, NO_EFFECT, SETTLED, described
from ddh_twin_py.gap.explain.classes import TELLS_APART
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.model import Acting
from ddh_twin_py.gap.next_test.beliefs import beliefs
from ddh_twin_py.gap.next_test.separating import Believed, Remaining, Trial, root_of
from ddh_twin_py.real_rigs.run import Run

Record = Callable[[np.ndarray, Acting], np.ndarray]

_ENOUGH = 10.0  # log Bayes factor beyond which more is worth no more
_TOO_LITTLE = 0.1  # log Bayes factor below which no test is proposed


@dataclass(frozen=True)
class CandidateTest:
    """A test that can be made.

    Attributes:
        words: what is to be done, a sentence. run: predicts it; what its signals have as measured is not looked at, but must be finite
            where a sample would be read.
    """

    words: str
    run: Run


class _Trial(Trial):
    """A candidate as `separating` asks for it."""

    def __init__(self, record: Record, found: Found, run: Run) -> None:
        super().__init__(run.signals, found.linearised.discrepancy)
        self._record, self._run = record, run

    def predict(self, theta: np.ndarray, acting: Acting) -> dict[str, np.ndarray]:
        return self._run.predict(self._record(theta, acting))


def next_test(tests: Sequence[CandidateTest], record: Record, found: Found) -> dict | None:
    """What to do next, by the contract: description, between, expected_separation.

    Args:
        tests: that can be made. record: parameter record (1,) of the recordings in question, of deviations (k,) and of what acts.

    Returns:
        None where the leading listed set is settled, no candidate is described or none would tell it from its rivals.
    """
    held = beliefs(found)
    if len(held) < 2 or held[0][1] > SETTLED:
        return None
    leader, rivals = held[0][0], [b for b, _ in held[1:]]
    weight = np.array([p for _, p in held[1:]]) / sum(p for _, p in held[1:])
    remaining = Remaining(found.linearised, [leader, *rivals])
    best, worth, separated = None, _TOO_LITTLE, np.zeros(0)
    for candidate in tests:
        apart = found.linearised.power * _apart(_Trial(record, found, candidate.run), leader, rivals, remaining)
        own = float(weight @ np.minimum(apart, _ENOUGH))
        if own > worth:
            best, worth, separated = candidate, own, apart
    if best is None:
        return None
    told = [i for i, value in enumerate(separated) if value >= TELLS_APART] or [int(np.argmax(separated))]
    alike = [_name(rival) for i, rival in enumerate(rivals) if i not in told]
    rest = f" It would not tell {_name(leader)} from {', '.join(alike)}." if alike else ""
    separation = round(float(min(separated[i] for i in told)), 2)
    return {"description": described(best.words, separation) + rest, "between": [_name(leader), *(_name(rivals[i]) for i in told)],
            "expected_separation": separation}


def why_none(tests: Sequence[CandidateTest], found: Found) -> str:
    """Why no test is proposed, one sentence."""
    held = beliefs(found)
    if len(held) < 2 or held[0][1] > SETTLED:
        return "Among the listed effects nothing is left to tell apart; no next test is computed."
    if not tests:
        return "No next test is computed: the description of this rig names no test that can be made."
    return f"None of the {len(tests)} tests that this rig's description names would tell the leading hypotheses apart."


def _apart(trial: Trial, leader: Believed, rivals: list[Believed], remaining: Remaining) -> np.ndarray:
    """Expected log Bayes factors of the leader against each rival, (r,)."""
    own = trial.features(leader.theta, leader.acting)
    free = trial.sensitivities(leader, remaining) @ root_of(remaining, 0)
    every = np.ones(own.size, dtype=bool)
    out = []
    for rival in rivals:
        slack = trial.along(leader, remaining, remaining.move_of_slack(leader, rival))[:, 0]
        difference = own - trial.features(rival.theta, rival.acting) + slack
        out.append(trial.apart(difference, np.hstack([free, trial.of_departures(rival)]), every))
    return np.array(out)


def _name(belief: Believed) -> str:
    """A set by its effects; none is said so."""
    return JOINED.join(belief.effects) or NO_EFFECT
