"""The test that would best tell the leading hypotheses of a described rig apart, among those that its engineer says can be made.

Each test is predicted under every leading set; what the recordings leave open of parameters and laws is taken in full
(`gap.next_test.separating`), and the log Bayes factor counts by the engine's power of the likelihood, as that of the recordings does. A
test may have other inputs than the recordings or sensors that they lack: it is a `run.Run` of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.gap.contract import NextTest
from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.next_test.proposal import Contest
from ddh_twin_py.gap.next_test.separating import Remaining, Trial, root_of
from ddh_twin_py.real_rigs.run import Run

Record = Callable[[np.ndarray, Acting], np.ndarray]


@dataclass(frozen=True)
class DescribedTest:
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


def next_test(tests: Sequence[DescribedTest], record: Record, found: Found) -> NextTest | None:
    """What to do next, by the contract: description, between, expected_separation.

    Args:
        tests: that can be made. record: parameter record (1,) of the recordings in question, of deviations (k,) and of what acts.

    Returns:
        None where the leading listed set is settled, no candidate is described or none would tell it from its rivals.
    """
    contest = Contest.of(found)
    if contest is None:
        return None
    remaining = Remaining(found.linearised, [contest.leader, *contest.rivals])
    power = found.linearised.power
    best = contest.best((test, power * _apart(_Trial(record, found, test.run), contest, remaining)) for test in tests)
    return contest.proposal(best[0].words, best[1]) if best else None


def why_none(tests: Sequence[DescribedTest], found: Found) -> str:
    """Why no test is proposed, one sentence."""
    if Contest.of(found) is None:
        return "Among the listed effects nothing is left to tell apart; no next test is computed."
    if not tests:
        return "No next test is computed: the description of this rig names no test that can be made."
    return f"None of the {len(tests)} tests that this rig's description names would tell the leading hypotheses apart."


def _apart(trial: Trial, contest: Contest, remaining: Remaining) -> np.ndarray:
    """Expected log Bayes factors of the leader against each rival, (r,)."""
    leader = contest.leader
    own = trial.features(leader.theta, leader.acting)
    free = trial.sensitivities(leader, remaining) @ root_of(remaining, 0)
    every = np.ones(own.size, dtype=bool)
    out = []
    for rival in contest.rivals:
        slack = trial.along(leader, remaining, remaining.move_of_slack(leader, rival))[:, 0]
        difference = own - trial.features(rival.theta, rival.acting) + slack
        out.append(trial.apart(difference, np.hstack([free, trial.of_departures(rival)]), every))
    return np.array(out)
