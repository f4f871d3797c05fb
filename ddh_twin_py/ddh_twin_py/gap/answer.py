"""What a search found, as the answer to a case: verdict, sizes on held-out data, places, parameters, words."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ddh_twin_py.estimation.calibration import FittedParameter
from ddh_twin_py.gap.diagnosable import Diagnosable
from ddh_twin_py.gap.diagnosis import Diagnosis, Weighed
from ddh_twin_py.gap.explain.classes import classes_of
from ddh_twin_py.gap.explain.departure import departure_of
from ddh_twin_py.gap.explain.detection import SIZES, Detection, detections
from ddh_twin_py.gap.explain.learned import described, learn
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.explain.taken_up import not_shown, shown_since
from ddh_twin_py.gap.shrink import size
from ddh_twin_py.gap.shrink.at_odds import at_odds
from ddh_twin_py.gap.shrink.held_runs import HeldRuns, ratios_of, recorded
from ddh_twin_py.gap.shrink.open_rig import asked_of_rig, told
from ddh_twin_py.gap.verdict.conclusion import conclude
from ddh_twin_py.gap.verdict.places import alone, entry_of, places, sized, unknown_places
from ddh_twin_py.gap.verdict.verdict import Verdict
from ddh_twin_py.gap.words import careful, sentence, shown_by_field, untold
from ddh_twin_py.rig.reader_units import moved, plus_minus
from ddh_twin_py.rig.sheet import CUT

LISTED = 0.01
"""Probability from which an effect or a set is listed."""
_RUN, _HEARD, _PLACED = 0.1, 0.7, 0.85  # shares of the work that are done when held-out data were run, and heard, and places are known
_MOST_AT_END = 4  # parameters named that are pressed against the end of their tolerance
_MOST = 12  # sets and effects listed


def diagnosis(model: Diagnosable, found: Found, theta: np.ndarray, hidden: Sequence[str], seconds: Mapping[str, float],
              progress: Callable[[float], None] | None = None) -> Diagnosis:
    """The whole answer.

    Args:
        model, found: of the case. theta: parameters fitted to the commissioning recording, (k,).
        hidden: effects asked about that no signal would show. seconds: by stage so far. progress: told the share done.
    """
    plain = found.fitted[()].theta if all(model.altered) else theta
    held = model.held_data()
    signals = held.signals()
    names = list(dict.fromkeys(name for own in signals for name in own))
    floor = size.floors(recorded(model, model.run(plain, ()), acts=False), names)
    runs = HeldRuns(held, floor)
    before_runs = runs.of(found.fitted[()]) if all(model.altered) else held.run(plain, ())
    as_is, before = ratios_of(held, held.run(np.zeros(model.size), ())), ratios_of(held, before_runs)
    gap_as_is, gap_before = size.gap(as_is, floor), size.gap(before, floor)
    progress = progress or (lambda share: None)
    progress(_RUN)
    concluded = conclude(model, found, plain, runs, before, lambda share: progress(_RUN + (_HEARD - _RUN) * share))
    progress(_HEARD)
    found, verdict, unknown, best = concluded.found, concluded.verdict, concluded.unknown, concluded.best
    leader, learned = found.fitted[()] if verdict.word == "no_gap" else best, None
    if verdict.word == "unknown":
        terms = model.learned_terms(unknown.places[0].component, unknown.places[0].domain)
        learned = concluded.law.fitted if concluded.law else learn(model, found, terms, runs.gap, gap_before) if terms else None
        leader = learned or min((found.fitted[()], best), key=runs.gap)
        rows = unknown_places(model, concluded.sought, unknown, best)
        unknown = sized(unknown, rows)
    else:
        rows = places(model, found, verdict)
    progress(_PLACED)
    acting, after = leader.acting, runs.ratios(leader)
    gap_after = size.gap(after, floor)
    classes, confusable = classes_of(found.linearised, verdict.effects, found.fitted)
    listed = [ids for ids, p in list(verdict.sets.items())[:_MOST] if p >= LISTED and ids]
    listed = sorted([*listed, ()], key=lambda ids: -verdict.sets.get(ids, 0.0))
    weighed = [_weighed(model, found, ids, verdict.sets.get(ids, 0.0), runs) for ids in listed]
    first = signals[0]
    spread = np.sqrt(np.diagonal(found.linearised.basis.covariance()))
    parameters = model.fitted_parameters(leader.theta, spread)
    pressed = _pressed(parameters)
    at_best = concluded.at_best.get(leader.effects)
    asked_for = asked_of_rig(model, leader, at_best, runs) if at_best else ""
    other_rig = [told(gap_after, at_best.gap, asked_for, "validation" in model.recordings)] if asked_for else []
    since = _since(found, leader.theta, spread, parameters) if verdict.word == "no_gap" else {}
    unsure = list(dict.fromkeys([*_taken_up(found), *since])) if verdict.word == "no_gap" else []
    detectable = _detectable(found, unsure) if verdict.word == "no_gap" else []
    missed = _missed(detectable)
    odd = at_odds(model, best, runs, gap_as_is, gap_before) if verdict.word == "unknown" else []
    odd = [*([concluded.crossed.said] if concluded.crossed and verdict.word == "unknown" else []), *odd]
    nameless = verdict.word == "unknown" and not learned  # what acts is in no rig file then, and parameters fitted beside it took it up
    report = {
        "verdict": verdict.word,
        "gap": {"as_is": gap_as_is, "before": gap_before, "after": gap_after,
                "closed_fraction": size.closed(gap_before, gap_after)},
        "where": [entry_of(row) for row in rows if row.regime == ""] if verdict.word != "no_gap" else [],
        "why": _why(model, found, verdict),
        "classes": classes,
        "hypotheses": [{"effects": list(w.effects), "probability": w.probability, "gap_after": w.gap_after} for w in weighed],
        "shrink": {name: {"unit": first[name].unit, "before": before[name] * first[name].noise, "after": after[name] * first[name].noise,
                          "noise": floor[name] * first[name].noise, "before_interval": runs.interval(name, before_runs),
                          "after_interval": runs.interval(name, runs.of(leader))} for name in names if name in before and name in first},
        "unknown": unknown.entry() if verdict.word == "unknown" else None, "next_test": model.next_test(found, verdict, unknown),
        "held_out": held.words,
        "checks": [{"effects": list(best.effects), "check": check.name, "measured": check.measured, "limit": check.limit}
                   for check in unknown.checks],
        "notes": [*odd, *unknown.notes, *concluded.notes, *other_rig, *([described(learned, gap_before, gap_after)] if learned else []),
                  *(_along_with(model, leader) if verdict.word in ("explained", "ambiguous") else []),
                  *model.notes(), *_not_held(model, before), *_not_seen(hidden),
                  *_since_when([name for name in unsure if name not in since]), *_only_since(since), *_would_not_show(missed),
                  *_at_the_end(pressed, nameless and leader.theta is not plain)],
    }
    inputs = model.unknown_inputs(plain, spread) if verdict.word != "no_gap" else []
    believed = acting if learned or verdict.word in ("explained", "ambiguous") else []
    return Diagnosis(
        report=report, recordings=model.recordings,
        sentence=careful(odd) + sentence(report, model.catalogue, [*(d.effect for d in missed), *hidden], unknown.reading,
                                         at_best.over if at_best else None, asked_for, pressed, not all(model.altered),
                                         since, verdict.together),
        traces=held.traces(before_runs[0], runs.of(leader)[0], floor), axes=held.axes(leader.theta, acting),
        lacking=rows, alone=alone(model, found), inputs=inputs, weighed=weighed, confusable=confusable, parameters=parameters,
        shapes=unknown.shapes,
        rig=model.rig_with(plain if nameless else leader.theta, believed, spread, joint=leader.joint if believed else None,
                           as_built=nameless and not all(model.altered)),
        added=leader.effects, nameless=nameless, detectable=detectable, untold=_untold(unsure, since),
        assumptions=model.assumptions, seconds=dict(seconds), catalogue=model.catalogue)


def _not_seen(hidden: Sequence[str]) -> list[str]:
    """A note on effects that no signal would show, none where there are none."""
    return [f"can be neither found nor excluded, as no signal of these recordings would show it: {', '.join(hidden)}"] if hidden else []


def _detectable(found: Found, unsure: Sequence[str]) -> list[Detection]:
    """From which size effects that move any signal would have been found; of those that are ``unsure`` nothing is said."""
    asked = {column.effect.id: column.effect for column in found.linearised.columns if column.effect.id not in unsure}
    with ThreadPoolExecutor(max_workers=2) as pool:
        return detections(found.linearised, list(asked.values()), pool)


def _missed(detectable: Sequence[Detection]) -> list[Detection]:
    """Effects that neither a moderate size would have shown nor one that machines reach."""
    return [d for d in detectable if d.smallest is None or d.rise > SIZES["moderate"] or d.beyond]


def _with_size(missed: Detection) -> str:
    """Such an effect, with the value of its quantity up or down to which it may act unseen, where there is one."""
    if missed.smallest is None:
        return missed.effect
    return f"{missed.effect} {'up' if missed.smallest > 0.0 else 'down'} to {moved(missed.nominal, missed.smallest, missed.unit)}"


def _would_not_show(missed: Sequence[Detection]) -> list[str]:
    """A note on what no gap does not exclude, none where every effect would have been found."""
    return [f"'no gap' does not exclude these, which would likely have been missed even at {SIZES['moderate']:g} times the noise of their "
            f"worst signal, or as large as machines have them: {', '.join(map(_with_size, missed))}"] if missed else []


def _pressed(parameters: Sequence[FittedParameter]) -> list[str]:
    """Parameters that a fit pressed against the end of their tolerance, each with its value and that of the sheet."""
    return [f"{p.name} ({p.value:.4g} instead of {p.prior:.4g}{'' if p.unit == '1' else f' {p.unit}'})"
            for p in parameters if p.informed and p.at_end]


def _at_the_end(pressed: Sequence[str], unwritten: bool) -> list[str]:
    """A note on them, none where there are none; ``unwritten``: a rig file that is written holds other values."""
    more = f" and {len(pressed) - _MOST_AT_END} further parameters" if len(pressed) > _MOST_AT_END else ""
    are = "are" if len(pressed) > 1 else "is"
    where = "in the fit that comes nearest, which no rig file is written from, " if unwritten else ""
    return [f"{where}{', '.join(pressed[:_MOST_AT_END])}{more} {are} fitted {CUT:g} times the tolerance off, the very "
            "end of what a fit may use; the sheet may be wrong there, or something hide behind it"] if pressed else []


def _not_held(model: Diagnosable, held: Collection[str]) -> list[str]:
    """A note on what the field recordings hold and held-out data do not, none where nothing is missing."""
    asked = dict.fromkeys(name for own, altered in zip(model.signals, model.altered, strict=True) if altered for name in own)
    missing = [name for name in asked if name not in held]
    return [f"held-out data have no usable {', '.join(missing)}: how near the twin comes to that is not known"] if missing else []


def _taken_up(found: Found) -> list[str]:
    """Effects in whose place the rig's own value, which field recordings alone show, may stand."""
    single = [(ids[0], fitted) for ids, fitted in found.fitted.items() if len(ids) == 1 and not fitted.slight]
    return [name for name, fitted in single if not_shown(found.linearised, fitted)]


def _since(found: Found, theta: np.ndarray, spread: np.ndarray, parameters: Sequence[FittedParameter]) -> dict[str, str]:
    """Effect to the parameter, with its value, that stands in its place and that only the field recordings show; see `shown_since`."""
    shown = shown_since(found.linearised, theta, spread)
    told = {name: parameters[number] for name, number in shown.items() if number < len(parameters)}
    return {name: f"{p.name} {plus_minus(p.value, p.std, p.unit)} instead of the sheet's {plus_minus(p.prior, p.prior_std, p.unit)}"
            for name, p in told.items()}


def _only_since(since: Mapping[str, str]) -> list[str]:
    """Notes on what `_since` found."""
    return [untold({name: value}) for name, value in since.items()]


def _untold(unsure: Sequence[str], since: Mapping[str, str]) -> dict[str, str]:
    """Effect to why recordings do not tell whether it acts since commissioning; what `_since` found first."""
    own = "a value of the rig's own within its tolerance does the same, and the commissioning recording does not show that value"
    return {**{name: shown_by_field(value) for name, value in since.items()}, **{name: own for name in unsure if name not in since}}


def _since_when(names: Sequence[str]) -> list[str]:
    """A note on such effects, none where there are none."""
    return [f"the rig's own value within {CUT:g} times its tolerance explains what {', '.join(names)} would; the "
            "commissioning recording does not show that value, so whether it has changed since cannot be known"] if names else []


def insufficient(model: Diagnosable, reason: str) -> Diagnosis:
    """The answer where the recordings allow none."""
    report = {
        "verdict": "insufficient", "gap": dict.fromkeys(("as_is", "before", "after", "closed_fraction")), "where": [], "why": [],
        "classes": [], "hypotheses": [], "shrink": {}, "unknown": None, "next_test": None, "held_out": model.held_data().words,
        "checks": [], "notes": [reason, *model.notes()],
    }
    return Diagnosis(report, sentence(report, model.catalogue), model.recordings, {}, {}, [], [], [], {}, [], [],
                     model.rig, model.assumptions, catalogue=model.catalogue)


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


def _why(model: Diagnosable, found: Found, verdict: Verdict) -> list[dict]:
    rows = []
    for name, probability in list(verdict.effects.items())[:_MOST]:
        if probability < LISTED:
            break
        row: dict = {"effect": name, "probability": probability}
        fitted = next((f for ids, f in ((ids, found.fitted[ids]) for ids in verdict.sets if ids in found.fitted) if name in ids), None)
        if fitted is not None:
            number = [c.effect.id for c in fitted.columns].index(name)
            value, std, unit, nominal = departure_of(model, fitted, number)
            row["parameters"] = {fitted.columns[number].effect.parameter: {"value": value, "std": std, "unit": unit, "nominal": nominal}}
        rows.append(row)
    return rows


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
