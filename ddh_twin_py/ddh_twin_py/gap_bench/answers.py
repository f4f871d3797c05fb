"""What one report answers, read against the truth of its case."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import permutations

from ddh_twin_py.gap.contract import Report

LARGEST_CLASS = 3
"""A class of at most so many effects that contains the true one counts as it."""
NO_ANSWER = ("no_gap", "insufficient")
UNKNOWN = "unknown"


@dataclass(frozen=True)
class Group:
    """One effect, or a class of effects that could not be told apart: ids and their probability together."""

    effects: tuple[str, ...]
    probability: float


@dataclass(frozen=True)
class Answer:
    """How one case was answered; None where a question does not apply to it.

    Attributes:
        name, suite, level, expected, commissioning: of the case. crashed: what went wrong, '' where nothing did.
        verdict: of the report. detected: something was said to be there. ranks: place of each true effect among the groups,
            from 1; infinite where it is not named. probability: of each true effect, with its class.
        named: the leading group's first effect. pairs: (probability, right) of every group named. none: probability of no gap; None in
            answers of before it was kept.
        component_first: the true component leads `where`. both: both of two are in the leading hypothesis.
        said_unknown: verdict or leading cause is unknown. unknown_component: and the component of it is right.
        closed: fraction closed over the oracle's. errors: of parameters, relative to the effect's size. covered: whether the
            truth lies in their 95 % intervals. seconds, megabytes: of the blind diagnosis. checks: of the report that is scored, name,
            measured, limit.
    """

    name: str
    suite: str
    level: str
    expected: str
    commissioning: bool
    true: tuple[str, ...]
    crashed: str = ""
    verdict: str = ""
    detected: bool = False
    ranks: tuple[float, ...] = ()
    probability: tuple[float, ...] = ()
    named: str = ""
    pairs: tuple[tuple[float, bool], ...] = ()
    none: float | None = None
    component_first: bool | None = None
    both: bool | None = None
    said_unknown: bool = False
    unknown_component: bool | None = None
    closed: float | None = None
    errors: tuple[float, ...] = ()
    covered: tuple[bool, ...] = ()
    seconds: float = math.nan
    megabytes: float = math.nan
    right: bool = field(default=False)
    checks: tuple[tuple[str, float, float], ...] = ()

    @property
    def stated(self) -> tuple[tuple[float, bool], ...]:
        """(probability, right) of all that was stated: of every group named and of no gap."""
        return self.pairs if self.none is None else (*self.pairs, (self.none, self.expected == "no_gap"))


def groups_of(report: Report) -> list[Group]:
    """Effects of `why`, largest probability first; those of a class of at most `LARGEST_CLASS` together."""
    probability = {row["effect"]: float(row["probability"]) for row in report["why"]}
    taken: set[str] = set()
    found = []
    for effect in probability:
        if effect in taken:
            continue
        group = next((tuple(g) for g in report.get("classes", []) if effect in g and len(g) <= LARGEST_CLASS), (effect,))
        members = tuple(m for m in group if m not in taken)
        taken |= set(members)
        found.append(Group(members, min(1.0, sum(probability.get(m, 0.0) for m in members))))
    return sorted(found, key=lambda g: -g.probability)


def answer_of(truth: Mapping, results: Mapping[str, Mapping]) -> Answer:
    """The answer of one case.

    Args:
        truth: as sealed. results: question to what its process wrote (`running.questions`).
    """
    left_out = truth["suite"] == "left_out"
    true = tuple(e["effect"] for e in truth["effects"] if e["listed"] and not left_out)
    base = {"name": truth["name"], "suite": truth["suite"], "level": truth["level"], "expected": truth["expected"],
            "commissioning": truth["commissioning"], "true": true}
    blind = results.get("blind", {"error": "was not run"})
    scored = results.get("left_out", {"error": "was not run"}) if left_out else blind
    hidden = len(truth["effects"])
    if "error" in blind or "error" in scored:
        wrong = blind.get("error") or scored.get("error")
        return Answer(**base, crashed=str(wrong), ranks=(math.inf,) * len(true), probability=(0.0,) * len(true),
                      component_first=False if hidden else None, both=False if truth["suite"] == "two" else None,
                      unknown_component=False if truth["expected"] == "unknown" else None, seconds=blind.get("seconds", math.nan))
    report = scored["report"]
    groups = groups_of(report)
    ranks = tuple(next((i + 1.0 for i, g in enumerate(groups) if effect in g.effects), math.inf) for effect in true)
    probability = tuple(next((g.probability for g in groups if effect in g.effects), 0.0) for effect in true)
    detected = report["verdict"] not in NO_ANSWER
    said_unknown = report["verdict"] == UNKNOWN or (detected and bool(groups) and groups[0].effects == (UNKNOWN,))
    components = {e["component"] for e in truth["effects"]}
    where = report.get("where") or []
    errors, covered = _parameters(truth["effects"], report) if true else ((), ())
    about = report.get("unknown") or {}
    answer = Answer(
        **base, verdict=report["verdict"], detected=detected, ranks=ranks, probability=probability,
        named=groups[0].effects[0] if groups and detected else "", pairs=_pairs(groups, truth, true),
        none=next((float(h["probability"]) for h in report.get("hypotheses", []) if not h["effects"]), 0.0),
        component_first=(bool(where) and where[0]["component"] in components) if hidden else None,
        both=_both(report, true) if truth["suite"] == "two" else None, said_unknown=said_unknown,
        unknown_component=(said_unknown and about.get("component") in components) if truth["expected"] == UNKNOWN else None,
        closed=_closed(report, results.get("oracle")), errors=errors, covered=covered,
        seconds=float(blind["seconds"]), megabytes=float(blind["megabytes"]),
        checks=tuple((row["check"], float(row["measured"]), float(row["limit"])) for row in report.get("checks", [])),
    )
    return Answer(**{**vars(answer), "right": _right(answer)})


def _right(a: Answer) -> bool:
    """Whether the case as a whole was answered rightly."""
    if a.expected == "no_gap":
        return a.verdict == "no_gap"
    if a.expected == UNKNOWN:
        return a.said_unknown
    return a.both if a.both is not None else bool(a.ranks) and a.ranks[0] == 1.0 and a.detected


def _pairs(groups: Sequence[Group], truth: Mapping, true: tuple[str, ...]) -> tuple[tuple[float, bool], ...]:
    rightly_unknown = truth["expected"] == UNKNOWN
    return tuple(
        (g.probability, rightly_unknown if g.effects == (UNKNOWN,) else bool(set(g.effects) & set(true))) for g in groups)


def _both(report: Report, true: tuple[str, ...]) -> bool:
    """Whether each true effect is in the leading hypothesis, or in a class with a member of it that stands for no other true effect."""
    leading = report["hypotheses"][0]["effects"] if report.get("hypotheses") else []
    small = [set(g) for g in report.get("classes", []) if len(g) <= LARGEST_CLASS]

    def stands_for(named: str, effect: str) -> bool:
        return named == effect or any({named, effect} <= members for members in small)

    return any(all(map(stands_for, chosen, true)) for chosen in permutations(leading, len(true)))


def _closed(report: Report, oracle: Mapping | None) -> float | None:
    """Fraction of the gap closed, over what the oracle closes."""
    if oracle is None or "report" not in oracle:
        return None
    own, best = report["gap"]["closed_fraction"], oracle["report"]["gap"]["closed_fraction"]
    return None if own is None or not best or best < 0.1 else own / best


def _parameters(effects: Sequence[Mapping], report: Report) -> tuple[tuple[float, ...], tuple[bool, ...]]:
    rows = {row["effect"]: row.get("parameters") or {} for row in report["why"]}
    errors, covered = [], []
    for effect in effects:
        said = rows.get(effect["effect"], {}).get(effect["parameter"])
        if said is None:
            continue
        off = float(said["value"]) - effect["value"]
        errors.append(abs(off) / abs(effect["value"] - effect["nominal"]))
        covered.append(abs(off) <= 1.96 * float(said["std"]))
    return tuple(errors), tuple(covered)
