"""What a search found, as the answer to a case: verdict, sizes on held-out data, places, parameters, words."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.gap import size
from ddh_twin_py.gap.classes import classes_of
from ddh_twin_py.gap.diagnosis import Diagnosis, Lack, Weighed
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.hypotheses import WIDTH
from ddh_twin_py.gap.lacking import Acting, chi_square_by_phase, lacks
from ddh_twin_py.gap.learned import described, learn
from ddh_twin_py.gap.model import Diagnosable, Held
from ddh_twin_py.gap.refit import Refitted
from ddh_twin_py.gap.search import Found
from ddh_twin_py.gap.tolerance import without_parameters
from ddh_twin_py.gap.unknown import Unknown, borne_out, halfway, refuted, unknown_beside
from ddh_twin_py.gap.verdict import Verdict, judge
from ddh_twin_py.gap.words import sentence

_NEARLY, _SHRINKS, _LOUD = 1.25, 0.95, 50.0  # without commissioning: a gap so small that no effect shrinks is none, unless
# parameters would have to be so far off that the log evidence of an effect is larger than a flaw of the laws makes it
LISTED = 0.01
"""Probability from which an effect or a set is listed."""
_PLACES_ALONE = 5
_MOST = 12  # sets and effects listed


def diagnosis(model: Diagnosable, found: Found, theta: np.ndarray, seconds: Mapping[str, float]) -> Diagnosis:
    """The whole answer.

    Args:
        model, found: of the case. theta: parameters fitted to the commissioning recording, (k,).
        seconds: by stage so far.
    """
    found = without_parameters(model, found)
    leader = found.fitted.get(found.leader) or found.fitted[()]
    unknown, best = unknown_beside(model, found, leader), leader
    held, none = model.held_data(), found.fitted[()]
    runs = _HeldRuns(held)
    plain = none.theta if all(model.altered) else theta
    sheet_runs, before_runs = held.run(np.zeros(model.size), ()), runs.of(none) if all(model.altered) else held.run(plain, ())
    signals = held.signals()
    names = list(dict.fromkeys(name for own in signals for name in own))
    commissioning = [(s, p) for s, p, altered in zip(model.signals, model.run(plain, ()), model.altered, strict=True) if not altered]
    floor = size.floors(commissioning, names)
    as_is, before = _ratios(held, sheet_runs), _ratios(held, before_runs)
    gap_before = size.gap(before, floor)
    left = runs.ratios(leader)
    shrunk = size.gap(left, floor) if leader.columns else gap_before
    unknown = borne_out(unknown, found.linearised.power, {name: ratio / floor[name] for name, ratio in left.items()},
                        size.closed(gap_before, shrunk))
    if len(leader.columns) > 1:
        unknown = halfway(unknown, shrunk, size.closed(gap_before, shrunk))
    if leader.columns:
        unknown = refuted(unknown, _shrinks(runs, none, leader))
    speaks = leader.log_evidence - none.log_evidence
    within = gap_before <= _NEARLY and shrunk > _SHRINKS * gap_before and speaks < _LOUD
    verdict = judge(found, unknown, all(model.altered) and within)
    learned = None
    if verdict.word == "no_gap":
        leader = none
    elif verdict.word == "unknown" and (terms := model.learned_terms(unknown.component, unknown.domain)):
        learned = learn(model, found, terms, lambda fitted: size.gap(runs.ratios(fitted), floor))
        leader = learned or leader
    acting, after = leader.acting, runs.ratios(leader)
    gap_after = size.gap(after, floor)
    classes, confusable = classes_of(found.linearised, verdict.effects)
    places = _places(model, found, verdict)
    if verdict.word == "unknown":
        places = [*_unknown_places(model, found, unknown, best), *(row for row in places if row.regime)]
    listed = [ids for ids, p in list(verdict.sets.items())[:_MOST] if p >= LISTED and ids]
    listed = sorted([*listed, ()], key=lambda ids: -verdict.sets.get(ids, 0.0))
    weighed = [_weighed(model, found, ids, verdict.sets.get(ids, 0.0), runs, floor) for ids in listed]
    first = signals[0]
    report = {
        "verdict": verdict.word,
        "gap": {"as_is": size.gap(as_is, floor), "before": gap_before, "after": gap_after,
                "closed_fraction": size.closed(gap_before, gap_after)},
        "where": [_place(row) for row in places if row.regime == ""] if verdict.word != "no_gap" else [],
        "why": _why(model, found, verdict),
        "classes": classes,
        "hypotheses": [{"effects": list(w.effects), "probability": w.probability, "gap_after": w.gap_after} for w in weighed],
        "shrink": {name: {"unit": first[name].unit, "before": before[name] * first[name].noise, "after": after[name] * first[name].noise,
                          "noise": floor[name] * first[name].noise} for name in names if name in before and name in first},
        "unknown": verdict.unknown, "next_test": model.next_test(found, verdict, unknown), "held_out": held.words,
        "notes": [*unknown.notes, *([described(learned, gap_before, gap_after)] if learned else []), *model.notes()],
    }
    spread = np.sqrt(np.diagonal(found.linearised.basis.covariance()))
    inputs = model.unknown_inputs(plain, spread) if verdict.word != "no_gap" else []
    parameters = model.fitted_parameters(leader.theta, spread)
    believed = acting if learned or verdict.word in ("explained", "ambiguous") else []
    return Diagnosis(
        report=report, sentence=sentence(report, model.catalogue), recordings=model.recordings,
        traces=held.traces(before_runs[0], runs.of(leader)[0], floor), axes=held.axes(leader.theta, acting),
        lacking=places, alone=_alone(model, found), inputs=inputs, weighed=weighed, confusable=confusable, parameters=parameters,
        shapes=unknown.shapes, rig=model.rig_with(leader.theta, believed, spread),
        assumptions=model.assumptions, seconds=dict(seconds), catalogue=model.catalogue)


class _HeldRuns:
    """Free runs of held-out data under fits; each fit is run once."""

    def __init__(self, held: Held) -> None:
        self._held = held
        self._known: dict[int, tuple[Refitted, list[dict[str, np.ndarray]]]] = {}  # the fit is kept, so that its id stays its own

    def of(self, fitted: Refitted) -> list[dict[str, np.ndarray]]:
        """Predictions, by recording."""
        if id(fitted) not in self._known:
            self._known[id(fitted)] = fitted, self._held.run(fitted.theta, fitted.acting)
        return self._known[id(fitted)][1]

    def ratios(self, fitted: Refitted) -> dict[str, float]:
        """RMS over noise of each signal."""
        return _ratios(self._held, self.of(fitted))


def _shrinks(runs: _HeldRuns, none: Refitted, leader: Refitted) -> float:
    """By how much a hypothesis shrinks the gap of held-out data below that of no effect, in multiples of the noise."""
    before, after = runs.ratios(none), runs.ratios(leader)
    return size.gap(before, dict.fromkeys(before, 1.0)) - size.gap(after, dict.fromkeys(after, 1.0))


def insufficient(model: Diagnosable, reason: str) -> Diagnosis:
    """The answer where the recordings allow none."""
    report = {
        "verdict": "insufficient", "gap": dict.fromkeys(("as_is", "before", "after", "closed_fraction")), "where": [], "why": [],
        "classes": [], "hypotheses": [], "shrink": {}, "unknown": None, "next_test": None, "held_out": model.held_data().words,
        "notes": [reason, *model.notes()],
    }
    return Diagnosis(report, sentence(report, model.catalogue), model.recordings, {}, {}, [], [], [], {}, [], [],
                     model.rig, model.assumptions, catalogue=model.catalogue)


def _ratios(held: Held, runs) -> dict[str, float]:
    """RMS over noise of each signal, all held-out recordings together."""
    return size.pooled(list(zip(held.signals(), runs, strict=True)), held.mask())


def _departure(model: Diagnosable, fitted: Refitted, number: int) -> tuple[float, float, str, float | None]:
    """Value, standard deviation, unit and nominal value of an effect of a hypothesis."""
    column = fitted.columns[number]
    effect = column.effect
    first = model.altered.index(True)
    record = model.record(first, fitted.theta)
    nominal = effect.reference(record)
    std = float(np.sqrt(max(fitted.covariance[number, number], 0.0)))
    if all(model.altered):  # held against the sheet: what the rig's own parameter took is part of the value
        sheet = model.record(first, np.zeros(model.size))
        plain = effect.reference(sheet)
        ratio = _ratio(effect, column.law, record, sheet) if plain == nominal else 1.0
        taken = _taken(effect, column.law, record, sheet) if plain == nominal == 0.0 else 0.0
        return (nominal + float(fitted.x[number])) * ratio + taken, std * ratio, effect.unit, plain
    return nominal + float(fitted.x[number]), std, effect.unit, nominal


def _taken(effect: Effect, law: int, record: np.ndarray, sheet: np.ndarray) -> float:
    """Departure that the rig's own fitted parameters stand for where the effect adds to one quantity that the sheet has too, else 0."""
    moved = record.copy()
    effect.laws[law](moved, effect.step)
    fields = [field for field in record.dtype.names if moved[field][0] != record[field][0]]
    if len(fields) != 1:
        return 0.0
    field = fields[0]
    return float((record[field][0] - sheet[field][0]) * effect.step / (moved[field][0] - record[field][0]))


def _ratio(effect: Effect, law: int, record: np.ndarray, sheet: np.ndarray) -> float:
    """Fitted over sheet value of what the effect scales, 1 where it adds."""
    moved = record.copy()
    effect.laws[law](moved, 0.01)
    for field in record.dtype.names:
        if moved[field][0] != record[field][0] and sheet[field][0] != 0.0 and effect.reference(record) == 1.0:
            ratio = float(record[field][0] / sheet[field][0])
            return ratio if moved[field][0] > record[field][0] else 1.0 / ratio
    return 1.0


def _why(model: Diagnosable, found: Found, verdict: Verdict) -> list[dict]:
    rows = []
    for name, probability in list(verdict.effects.items())[:_MOST]:
        if probability < LISTED:
            break
        row: dict = {"effect": name, "probability": probability}
        fitted = next((f for ids, f in ((ids, found.fitted[ids]) for ids in verdict.sets if ids in found.fitted) if name in ids), None)
        if fitted is not None:
            number = [c.effect.id for c in fitted.columns].index(name)
            value, std, unit, nominal = _departure(model, fitted, number)
            row["parameters"] = {fitted.columns[number].effect.parameter: {"value": value, "std": std, "unit": unit, "nominal": nominal}}
        rows.append(row)
    return rows


def _weighed(model: Diagnosable, found: Found, ids, probability: float, runs: _HeldRuns, floor) -> Weighed:
    fitted = found.fitted.get(ids)
    if fitted is None:
        return Weighed(ids, probability, None, {}, {}, {})
    ratios = runs.ratios(fitted)
    values = {c.effect.id: _departure(model, fitted, i) for i, c in enumerate(fitted.columns)}
    return Weighed(ids, probability, size.gap(ratios, floor), values, _gains(found, fitted),
                   {name: ratio / floor[name] for name, ratio in ratios.items()})


def _gains(found: Found, fitted: Refitted) -> dict[str, float]:
    """Chi-square that a hypothesis explains in each signal of the recordings in which effects act."""
    linearised = found.linearised
    none = found.fitted[()]
    gains: dict[str, float] = {}
    for i, (comparison, altered) in enumerate(zip(linearised.comparisons, linearised.model.altered, strict=True)):
        if altered:
            was, now = comparison.residual(none.predictions[i]), comparison.residual(fitted.predictions[i])
            for block in comparison.blocks:
                gains[block.signal] = gains.get(block.signal, 0.0) + float(np.sum(was[block.rows] ** 2) - np.sum(now[block.rows] ** 2))
    return gains


def _places(model: Diagnosable, found: Found, verdict: Verdict) -> list[Lack]:
    """What the twin lacks, by the probability of each effect."""
    number = model.altered.index(True)
    rows = []
    for name, probability in verdict.effects.items():
        fitted = next((found.fitted[ids] for ids in verdict.sets if name in ids and ids in found.fitted), None)
        if fitted is None or probability < 0.02:
            continue
        i = [c.effect.id for c in fitted.columns].index(name)
        column, x = fitted.columns[i], float(fitted.x[i])
        if x == 0.0:
            continue
        others = [a for j, a in enumerate(fitted.acting) if j != i]
        without, acting = model.record(number, fitted.theta, others), model.record(number, fitted.theta, fitted.acting)
        change = [h * x / column.x for h in column.change]
        weight = probability * float(sum(np.sum(h**2) for h in change))
        std = float(np.sqrt(max(fitted.covariance[i, i], 0.0))) / abs(x)
        rows.append(Acting(column.effect, model.course(column.effect, without, acting), weight,
                           chi_square_by_phase(change, found.linearised.comparisons), std))
    total = sum(row.share for row in rows) or 1.0
    return lacks([Acting(r.effect, r.course, r.share / total, r.by_phase, r.relative) for r in rows])


def _alone(model: Diagnosable, found: Found) -> list[Lack]:
    """What each place would have to add by itself, any of its effects' ways taken as a free input, before one is believed."""
    sums, columns = found.linearised.evidence.sums, found.linearised.columns
    number, theta = model.altered.index(True), found.linearised.theta
    precision = np.diagonal(sums.information) + WIDTH**-2
    explained = sums.score**2 / precision
    best: dict[str, int] = {}
    for i in np.argsort(-explained):
        if sums.score[i] > 0.0:
            best.setdefault(columns[i].effect.component, int(i))
    rows = []
    for i in list(best.values())[:_PLACES_ALONE]:
        column, departure = columns[i], float(sums.score[i] / precision[i])
        x = column.effect.limit(departure * column.x)
        if x == 0.0:
            continue
        without, acting = model.record(number, theta), model.record(number, theta, [(column.effect, column.law, x)])
        change = [h * x / column.x for h in column.change]
        rows.append(Acting(column.effect, model.course(column.effect, without, acting), float(explained[i]),
                           chi_square_by_phase(change, found.linearised.comparisons), float(1.0 / (departure * np.sqrt(precision[i])))))
    total = sum(row.share for row in rows) or 1.0
    return lacks([Acting(r.effect, r.course, r.share / total, r.by_phase, r.relative) for r in rows])


def _unknown_places(model: Diagnosable, found: Found, unknown: Unknown, leader: Refitted) -> list[Lack]:
    """Where something acts that no listed effect explains, by the phases of its signals' chi-square."""
    number = model.altered.index(True)
    comparison = found.linearised.comparisons[number]
    left = [np.zeros(c.size) for c in found.linearised.comparisons]
    named = {form.signal for form in unknown.forms if form.gain > 0.0}
    for block in comparison.blocks:
        if block.signal in named:
            left[number][block.rows] = comparison.residual(leader.predictions[number])[block.rows]
    parts = chi_square_by_phase(left, found.linearised.comparisons)
    return [Lack(unknown.component, unknown.domain, phase, "", unknown.size, 0.3 * unknown.size, unknown.unit, share)
            for phase, share in parts.items()]


def _place(row: Lack) -> dict:
    return {"component": row.component, "domain": row.domain, "phase": row.phase, "share": row.share, "missing": row.value,
            "unit": row.unit, "std": row.std}
