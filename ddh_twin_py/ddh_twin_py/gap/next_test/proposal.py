"""Which of the tests that can be made is proposed, and how it is told, whatever the rig."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ddh_twin_py.gap.explain.classes import TELLS_APART
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.next_test.beliefs import beliefs
from ddh_twin_py.gap.next_test.separating import Believed

SETTLED = 0.95
"""Probability of the leading set from which nothing is left to tell apart."""
DECIDES = 1.0
"""Expected log Bayes factor below which a test leaves the odds nearly as they are."""
TOO_LITTLE = 0.1
"""Log Bayes factor below which no test is proposed."""
T = TypeVar("T")
_ENOUGH = 10.0  # log Bayes factor beyond which more is worth no more


@dataclass(frozen=True)
class Contest:
    """The sets between which a test decides.

    Attributes:
        leader, rivals: the most probable set, and the (r,) others. weight: of the rivals, by their probabilities, (r,).
    """

    leader: Believed
    rivals: list[Believed]
    weight: np.ndarray

    @staticmethod
    def of(found: Found) -> Contest | None:
        """What a search has left; None where the leading set is settled."""
        held = beliefs(found)
        if len(held) < 2 or held[0][1] > SETTLED:
            return None
        weight = np.array([p for _, p in held[1:]]) / sum(p for _, p in held[1:])
        return Contest(held[0][0], [b for b, _ in held[1:]], weight)

    def worth(self, apart: np.ndarray) -> float:
        """What a test is worth, from its expected log Bayes factors of the leader against each rival, (r,)."""
        return float(self.weight @ np.minimum(apart, _ENOUGH))

    def best(self, judged: Iterable[tuple[T, np.ndarray]]) -> tuple[T, np.ndarray] | None:
        """Of tests with their factors, see `worth`, the one that is worth most; None where none is worth `TOO_LITTLE`."""
        best, most = None, TOO_LITTLE
        for test, apart in judged:
            if (worth := self.worth(apart)) > most:
                best, most = (test, apart), worth
        return best

    def proposal(self, words: str, apart: np.ndarray, most: float = math.inf) -> dict:
        """A test by the contract: description, between, expected_separation, which is that from the nearest of those named.

        Args:
            words: what is to be done, sentences. apart: see `worth`. most: factor beyond which none is told.
        """
        told = [i for i, value in enumerate(apart) if value >= TELLS_APART] or [int(np.argmax(apart))]
        alike = [name_of(rival) for i, rival in enumerate(self.rivals) if i not in told]
        rest = f" It would not tell {name_of(self.leader)} from {', '.join(alike)}." if alike else ""
        separation = round(min(most, *(float(apart[i]) for i in told)), 2)
        return {"description": described(words, separation) + rest,
                "between": [name_of(self.leader), *(name_of(self.rivals[i]) for i in told)], "expected_separation": separation}


def name_of(belief: Believed) -> str:
    """A set by its effects; none is said so."""
    return " + ".join(belief.effects) or "no effect"


def described(words: str, separation: float) -> str:
    """What is to be done, with a word of warning where no candidate would decide."""
    return words if separation >= DECIDES else f"No test of the list would decide this; of them this one tells most: {words}"
