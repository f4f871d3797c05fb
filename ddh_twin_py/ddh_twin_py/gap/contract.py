"""The report of a diagnosis as its contract names it, ready for JSON: who writes it and who reads it ask for these keys.

`Check` and the intervals of `Shrunk` are said beside the contract.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NotRequired, TypedDict


class Gap(TypedDict):
    """RMS over signals of residual over floor on data not used for fitting, 1 is the floor; None where nothing is told or runs go astray.

    Of the twin as it was given, with its parameters fitted, and with the leading hypothesis added; (before - after) / (before - 1).
    """

    as_is: float | None
    before: float | None
    after: float | None
    closed_fraction: float | None


class Place(TypedDict):
    """Where the gap lies: ``share`` of the explained chi-square, and what the twin lacks there, ``missing`` with ``std``, in ``unit``."""

    component: str
    domain: str
    phase: str
    share: float
    missing: float
    unit: str
    std: float


class Parameter(TypedDict):
    """Size of an effect."""

    value: float
    std: float
    unit: str
    nominal: float | None


class Why(TypedDict):
    """An effect, or ``unknown``, with its marginal probability; its size where it was fitted."""

    effect: str
    probability: float
    parameters: NotRequired[Mapping[str, Parameter]]


class Hypothesis(TypedDict):
    """A set of effects, empty for none; ``gap_after`` None where it was not fitted."""

    effects: list[str]
    probability: float
    gap_after: float | None


class Shrunk(TypedDict):
    """Residual RMS of a signal before and after, each with its interval, and its floor, in ``unit``."""

    unit: str
    before: float
    after: float
    noise: float
    before_interval: NotRequired[list[float] | None]
    after_interval: NotRequired[list[float] | None]


class Beyond(TypedDict):
    """What is left that no listed effect explains; ``depends_on``: variables, strongest first."""

    component: str
    domain: str
    size: float
    unit: str
    depends_on: list[str]


class NextTest(TypedDict):
    """The duty that would best tell the hypotheses ``between`` apart; the separation is a log Bayes factor."""

    description: str
    between: list[str]
    expected_separation: float


class Check(TypedDict):
    """What one rule measured beside a set of effects, and the number at which something unknown is as likely as not."""

    effects: list[str]
    check: str
    measured: float
    limit: float


class Report(TypedDict):
    """The whole report: ``shrink`` by signal, ``held_out`` in words."""

    verdict: Literal["no_gap", "explained", "ambiguous", "unknown", "insufficient"]
    gap: Gap
    where: list[Place]
    why: list[Why]
    classes: list[list[str]]
    hypotheses: list[Hypothesis]
    shrink: Mapping[str, Shrunk]
    unknown: Beyond | None
    next_test: NextTest | None
    held_out: str
    checks: list[Check]
    notes: list[str]
