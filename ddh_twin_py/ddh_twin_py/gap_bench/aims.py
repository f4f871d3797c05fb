"""What a bench is to reach: a metric over some of its cases, and the bound on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ddh_twin_py.gap_bench.answers import Answer
from ddh_twin_py.gap_bench.intervals import Estimate

LISTED = ("single", "two")
"""Suites whose hidden effects are in the catalogue."""


@dataclass(frozen=True)
class Aim:
    """One bound.

    Attributes:
        words: for people. metric: of `scoring.METRICS`. bound: to be reached. most: whether it is the largest allowed.
        counts: whether a case belongs to it.
    """

    words: str
    metric: str
    bound: float
    most: bool
    counts: Callable[[Answer], bool]

    def row(self, answers: Sequence[Answer], score: Callable[[Sequence[Answer]], dict[str, Estimate]]) -> dict:
        """As plain data: words, metric, bound, most, and the estimate over the cases that belong to it."""
        estimate = score([a for a in answers if self.counts(a)])[self.metric]
        return {"words": self.words, "metric": self.metric, "bound": self.bound, "most": self.most, "score": estimate.as_json()}


def _listed(*levels: str) -> Callable[[Answer], bool]:
    return lambda a: a.suite in LISTED and a.level in levels


AIMS = (
    Aim("a gap is found, clear and moderate effects", "detected", 0.98, False, lambda a: a.level in ("clear", "moderate")),
    Aim("false alarms, nothing hidden or parameters off", "false_alarm", 0.05, True, lambda a: a.suite in ("none", "tolerance")),
    Aim("true effect, or its class of at most three, first: clear", "first", 0.95, False, _listed("clear")),
    Aim("the same: moderate", "first", 0.85, False, _listed("moderate")),
    Aim("the same: faint", "first", 0.50, False, _listed("faint")),
    Aim("right component first, listed effects, clear and moderate", "component", 0.90, False, _listed("clear", "moderate")),
    Aim("both of two effects found", "both", 0.75, False, lambda a: a.suite == "two"),
    Aim("`unknown` where the effect is outside the catalogue or left out of it", "unknown_found", 0.85, False,
        lambda a: a.suite in ("left_out", "outside")),
    Aim("`unknown` though it is in the catalogue", "false_unknown", 0.05, True, lambda a: a.suite in LISTED),
    Aim("gap closed on validation data, over the oracle's", "closed", 0.95, False, lambda a: a.suite in LISTED),
    Aim("true parameter inside its 95 % interval", "coverage", 0.90, False, lambda a: a.suite in LISTED),
)
"""All of them, in the order in which they are shown."""
