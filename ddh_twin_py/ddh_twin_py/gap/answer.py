"""What a search found, as the answer to a case: verdict, sizes on held-out data, places, parameters, words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fitting.calibration import FittedParameter
from ddh_twin_py.gap.contract import Report, Shrunk, Why
from ddh_twin_py.gap.diagnosable import Diagnosable
from ddh_twin_py.gap.diagnosis import Diagnosis, Weighed
from ddh_twin_py.gap.evidence.hypotheses import PRIOR_NONE
from ddh_twin_py.gap.explain.classes import classes_of
from ddh_twin_py.gap.explain.departure import departure_of
from ddh_twin_py.gap.explain.learned import described, learn
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.gap.not_excluded import NotExcluded, not_excluded
from ddh_twin_py.gap.report_notes import at_the_end, not_held, not_seen, pressed_ones
from ddh_twin_py.gap.shrink import size
from ddh_twin_py.gap.shrink.at_odds import at_odds
from ddh_twin_py.gap.shrink.held_best import AtBest
from ddh_twin_py.gap.shrink.held_runs import HeldRuns, first_of_each, ratios_of, recorded, traces
from ddh_twin_py.gap.shrink.open_rig import asked_of_rig, told
from ddh_twin_py.gap.verdict.conclusion import Conclusion, conclude
from ddh_twin_py.gap.verdict.hidden_causes import hidden_causes, with_hidden
from ddh_twin_py.gap.verdict.places import alone, entry_of, places, sized, unknown_places
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.verdict import Verdict
from ddh_twin_py.gap.words import BesideReport, careful, sentence
from ddh_twin_py.rig.files import finite

LISTED = 0.01
"""Probability from which an effect or a set is listed."""
_RUN, _HEARD, _PLACED = 0.1, 0.7, 0.85  # shares of the work that are done when held-out data were run, and heard, and places are known
_MOST = 12  # sets and effects listed
_EXPLAINED = ("explained", "ambiguous")  # verdicts by which listed effects act


def diagnosis(model: Diagnosable, found: Found, commissioned: np.ndarray, hidden: Sequence[str], seconds: Mapping[str, float],
              progress: Callable[[float], None] | None = None) -> Diagnosis:
    """The whole answer.

    Args:
        model, found: of the case. commissioned: parameters fitted to the commissioning recording, (k,).
        hidden: effects asked about that no signal would show. seconds: by stage so far. progress: told the share done.
    """
    progress = progress or (lambda share: None)
    before = _before(model, found, commissioned)
    progress(_RUN)
    concluded = conclude(model, found, before.plain, before.runs, before.off, lambda share: progress(_RUN + (_HEARD - _RUN) * share))
    progress(_HEARD)
    spread = np.sqrt(np.diagonal(concluded.found.linearised.basis.covariance()))
    concluded, left_open = _with_left_open(model, concluded, hidden, spread, before.commissioned)
    held, runs = before.runs.held, before.runs
    found, verdict, best = concluded.found, concluded.verdict, concluded.best
    no_gap, is_unknown = verdict.word == "no_gap", verdict.word == "unknown"
    after = _after(model, concluded, before)
    leader, unknown = after.leader, after.unknown
    progress(_PLACED)
    gap_after = runs.gap(leader)
    classes, confusable = classes_of(found.linearised, verdict.effects, found.fitted)
    weighed = _all_weighed(model, found, verdict, runs)
    shrink, astray = _shrink(before, leader)
    rig = _with_which(model, concluded, spread, before, after)
    odd = _odd(model, concluded, before) if is_unknown else []
    report: Report = {
        "verdict": verdict.word,
        "gap": {"as_is": before.gap_as_is, "before": before.gap, "after": gap_after,
                "closed_fraction": size.closed(before.gap, gap_after)},
        "where": [entry_of(row) for row in after.rows if row.regime == ""] if not no_gap else [],
        "why": _why(model, found, verdict),
        "classes": classes,
        "hypotheses": [{"effects": list(w.effects), "probability": w.probability, "gap_after": w.gap_after} for w in weighed],
        "shrink": shrink,
        "unknown": unknown.entry() if is_unknown else None, "next_test": model.next_test(found, verdict, unknown),
        "held_out": held.words,
        "checks": [{"effects": list(best.effects), "check": check.name, "measured": check.measured, "limit": check.limit}
                   for check in unknown.checks],
        "notes": [*odd, *unknown.notes, *concluded.notes, *_of_what_is_added(model, concluded, before, after, rig, gap_after),
                  *model.notes(), *not_held(model, before.off), *astray, *not_seen(hidden), *left_open.notes(model.cut),
                  *at_the_end(rig.pressed, rig.nameless and leader.theta is not before.plain, model.cut)],
    }
    believed = leader.acting if after.learned or verdict.word in _EXPLAINED else []
    beside = BesideReport([*(d.effect for d in left_open.missed), *hidden], unknown.reading, rig.at_best.over if rig.at_best else None,
                          rig.asked_for, rig.pressed, before.commissioned, left_open.since, verdict.together, model.cut,
                          model.witnesses.amplified)
    return Diagnosis(
        report=finite(report), recordings=model.recordings, sentence=careful(odd) + sentence(report, model.catalogue, beside),
        traces=traces(held, before.run[0], runs.of(leader)[0], runs.floor), axes=held.axes(leader.theta, leader.acting),
        lacking=after.rows, alone=alone(model, found), inputs=model.unknown_inputs(before.plain, spread) if not no_gap else [],
        weighed=weighed, confusable=confusable, parameters=rig.parameters, shapes=unknown.shapes,
        rig=model.rig_with(before.plain if rig.nameless else leader.theta, believed, spread,
                           joint=leader.joint if believed else None, as_built=rig.nameless and before.commissioned),
        added=leader.effects, nameless=rig.nameless, detectable=left_open.detectable, untold=left_open.untold(),
        assumptions=model.assumptions, seconds=dict(seconds), catalogue=model.catalogue, cut=model.cut)


@dataclass(frozen=True)
class _Before:
    """How far held-out data are off before anything is added.

    Attributes:
        plain: parameters that are known without any effect, (k,). commissioned: whether a commissioning recording told them.
        runs: of held-out data. run: those with ``plain``. off: by signal, over its noise. gap, gap_as_is: over the floor, fitted and
            at the sheet's values.
    """

    plain: np.ndarray
    commissioned: bool
    runs: HeldRuns
    run: list[dict[str, np.ndarray]]
    off: dict[str, float]
    gap: float
    gap_as_is: float


def _before(model: Diagnosable, found: Found, commissioned: np.ndarray) -> _Before:
    """See `_Before`; parameters (k,) fitted to the commissioning recording."""
    uncommissioned = all(model.altered)
    plain = found.fitted[()].theta if uncommissioned else commissioned
    held = model.held_data()
    names = list(dict.fromkeys(name for own in held.signals() for name in own))
    floor = size.floors(recorded(model, model.run(plain, ()), acts=False), names)
    runs = HeldRuns(held, floor)
    run = runs.of(found.fitted[()]) if uncommissioned else held.run(plain, ())
    off, as_is = ratios_of(held, run), ratios_of(held, held.run(np.zeros(model.size), ()))
    return _Before(plain, not uncommissioned, runs, run, off, size.gap(off, floor), size.gap(as_is, floor))


@dataclass(frozen=True)
class _After:
    """With what the gap "after" is taken, and what is said of it.

    Attributes:
        leader: a hypothesis as it was fitted, or terms learned where something unknown acts, which are ``learned`` then.
        rows: what the twin lacks by place. unknown: beside the leader, its places sized where it is the verdict.
    """

    leader: Refitted
    rows: list[Lack]
    unknown: Unknown
    learned: Refitted | None = None


def _after(model: Diagnosable, concluded: Conclusion, before: _Before) -> _After:
    """See `_After`."""
    found, verdict, best = concluded.found, concluded.verdict, concluded.best
    if verdict.word != "unknown":
        return _After(found.fitted[()] if verdict.word == "no_gap" else best, places(model, found, verdict), concluded.unknown)
    first, gap = concluded.unknown.places[0], before.runs.gap
    terms = model.learned_terms(first.component, first.domain)
    learned = concluded.law.fitted if concluded.law else learn(model, found, terms, gap, before.gap) if terms else None
    rows = unknown_places(model, concluded.sought, concluded.unknown, best)
    return _After(learned or min((found.fitted[()], best), key=gap), rows, sized(concluded.unknown, rows), learned)


@dataclass(frozen=True)
class _Rig:
    """The rig with which the gap "after" is taken.

    Attributes:
        parameters: with prior and posterior. pressed: those at the end of their tolerance. at_best: held-out data at best beside it,
            None where these were not sought. asked_for: what of the rig they then ask for, empty where it is nothing.
        nameless: whether what acts is in no rig file, and parameters that were fitted beside it took it up.
    """

    parameters: list[FittedParameter]
    pressed: list[str]
    at_best: AtBest | None
    asked_for: str
    nameless: bool


def _with_left_open(model: Diagnosable, concluded: Conclusion, unshown: Sequence[str], spread: np.ndarray,
                    commissioned: bool) -> tuple[Conclusion, NotExcluded]:
    """The conclusion, of no gap with the share of causes that may hide, and what that does not exclude.

    Args:
        unshown: effects that no signal would show. spread: standard deviations of the rig's parameters, (k,).
        commissioned: whether a commissioning recording showed the rig.
    """
    if concluded.verdict.word != "no_gap":
        return concluded, NotExcluded({}, [], [])
    found = concluded.found
    theta = found.fitted[()].theta
    left_open = not_excluded(found, theta, spread, model.fitted_parameters(theta, spread))
    hidden = hidden_causes(left_open.detectable, [*left_open.unsure, *unshown], len(found.linearised.question.effects), commissioned)
    return replace(concluded, verdict=with_hidden(concluded.verdict, hidden)), left_open


def _with_which(model: Diagnosable, concluded: Conclusion, spread: np.ndarray, before: _Before, after: _After) -> _Rig:
    """See `_Rig`; standard deviations of its parameters (k,)."""
    leader = after.leader
    parameters = model.fitted_parameters(leader.theta, spread)
    at_best = concluded.at_best.get(leader.effects)
    asked_for = asked_of_rig(model, leader, at_best, before.runs) if at_best else ""
    return _Rig(parameters, pressed_ones(parameters), at_best, asked_for,
                concluded.verdict.word == "unknown" and not after.learned)


def _of_what_is_added(model: Diagnosable, concluded: Conclusion, before: _Before, after: _After, rig: _Rig, gap: float) -> list[str]:
    """Notes on what is added to the twin: the rig that held-out data ask for beside it, terms learned, what changed along with effects."""
    other_rig = [told(gap, rig.at_best.gap, rig.asked_for, "validation" in model.recordings)] if rig.asked_for else []
    learned = [described(after.learned, before.gap, gap)] if after.learned else []
    return [*other_rig, *learned, *(_along_with(model, after.leader) if concluded.verdict.word in _EXPLAINED else [])]


def _shrink(before: _Before, leader: Refitted) -> tuple[dict[str, Shrunk], list[str]]:
    """How far each signal of held-out data was off and is beside the leader, and a note on those in which runs went astray, if any."""
    runs, first = before.runs, first_of_each(before.runs.held)
    off = runs.ratios(leader)
    both = [name for name in runs.floor if name in before.off and name in off and name in first]
    astray = [name for name in both if not math.isfinite(before.off[name] + off[name])]
    rows = {name: {"unit": first[name].unit, "before": before.off[name] * first[name].noise, "after": off[name] * first[name].noise,
                   "noise": runs.floor[name] * first[name].noise, "before_interval": runs.interval(name, before.run),
                   "after_interval": runs.interval(name, runs.of(leader))}
            for name in both if name not in astray}
    return rows, [f"free runs of held-out data go astray in {', '.join(astray)}"] if astray else []


def _odd(model: Diagnosable, concluded: Conclusion, before: _Before) -> list[str]:
    """What is odd about recordings in which something unknown is found: sensors exchanged, recordings that do not go together."""
    crossed = [concluded.crossed.said] if concluded.crossed else []
    return [*crossed, *at_odds(model, concluded.best, before.runs, before.gap_as_is, before.gap)]


def insufficient(model: Diagnosable, reason: str) -> Diagnosis:
    """The answer where the recordings allow none: no effect keeps the probability that it had before."""
    none = {"effects": [], "probability": PRIOR_NONE, "gap_after": None}
    report: Report = {
        "verdict": "insufficient", "gap": dict.fromkeys(("as_is", "before", "after", "closed_fraction")), "where": [], "why": [],
        "classes": [], "hypotheses": [none], "shrink": {}, "unknown": None, "next_test": None, "held_out": model.held_data().words,
        "checks": [], "notes": [reason, *model.notes()],
    }
    return Diagnosis(report=report, sentence=sentence(report, model.catalogue), recordings=model.recordings, traces={}, axes={}, lacking=[],
                     alone=[], weighed=[], confusable={}, parameters=[], shapes=[], rig=model.rig, assumptions=model.assumptions,
                     catalogue=model.catalogue, cut=model.cut)


def _along_with(model: Diagnosable, fitted: Refitted) -> list[str]:
    """What changed along with effects of a hypothesis, one sentence each."""
    said, number = [], model.altered.index(True)
    for i, (column, deviations) in enumerate(zip(fitted.columns, fitted.beside, strict=True)):
        if deviations:
            alone = fitted.acting
            alone[i] = (column.effect, column.law, float(fitted.x[i]))
            with_it, without = model.record(number, fitted.theta, fitted.acting), model.record(number, fitted.theta, alone)
            said.append(column.effect.beside.said(with_it, without))
    return said


def _why(model: Diagnosable, found: Found, verdict: Verdict) -> list[Why]:
    rows = []
    for name, probability in list(verdict.effects.items())[:_MOST]:
        if probability < LISTED:
            break
        row: Why = {"effect": name, "probability": probability}
        fitted = next((f for ids, f in ((ids, found.fitted[ids]) for ids in verdict.sets if ids in found.fitted) if name in ids), None)
        if fitted is not None:
            number = [c.effect.id for c in fitted.columns].index(name)
            value, std, unit, nominal = departure_of(model, fitted, number)
            row["parameters"] = {fitted.columns[number].effect.parameter: {"value": value, "std": std, "unit": unit, "nominal": nominal}}
        rows.append(row)
    return rows


def _all_weighed(model: Diagnosable, found: Found, verdict: Verdict, runs: HeldRuns) -> list[Weighed]:
    """The sets that are listed, and no effect, the most probable first."""
    listed = [ids for ids, p in list(verdict.sets.items())[:_MOST] if p >= LISTED and ids]
    listed = sorted([*listed, ()], key=lambda ids: -verdict.sets.get(ids, 0.0))
    return [_weighed(model, found, ids, verdict.sets.get(ids, 0.0), runs) for ids in listed]


def _weighed(model: Diagnosable, found: Found, ids, probability: float, runs: HeldRuns) -> Weighed:
    fitted = found.fitted.get(ids)
    if fitted is None:
        return Weighed(ids, probability, None, {}, {}, {})
    values = {c.effect.id: departure_of(model, fitted, i) for i, c in enumerate(fitted.columns)}
    return Weighed(ids, probability, runs.gap(fitted), values, _gains(found, fitted), runs.over(fitted))


def _gains(found: Found, fitted: Refitted) -> dict[str, float]:
    """Chi-square, as the evidence weighs it, that a hypothesis explains in each signal of the recordings in which effects act."""
    linearised = found.linearised
    was, now = (linearised.basis.misfits([c.residual(p) for c, p in zip(linearised.comparisons, one.predictions, strict=True)])
                for one in (found.fitted[()], fitted))
    gains: dict[str, float] = {}
    for i, comparison in enumerate(linearised.comparisons):
        if linearised.model.altered[i]:
            for block in comparison.blocks:
                gains[block.signal] = gains.get(block.signal, 0.0) + float(np.sum(was[i][block.rows] - now[i][block.rows]))
    return gains
