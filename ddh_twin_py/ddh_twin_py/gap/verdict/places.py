"""What the twin lacks and where: under the hypotheses, before one is believed, and where something unknown acts."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ddh_twin_py.estimation.fitting.binning import PHASES
from ddh_twin_py.gap.contract import Place
from ddh_twin_py.gap.evidence.hypotheses import WIDTH
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.locate.lacking import ActingEffect, chi_square_by_phase, lacks
from ddh_twin_py.gap.locate.locatable import Locatable
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.verdict import Verdict

_PLACES_ALONE = 5
_BELIEVED = 0.1  # of the likeliest effect's probability, from which another says what is lacking
_LIKELY = 0.05  # share from which a place is listed where something unknown acts
_MOSTLY = 0.6  # share of the chi-square from which a phase stands for all
_CRUDE = 0.3  # standard deviation of what a free form is large, as a share of it


def places(model: Locatable, found: Found, verdict: Verdict) -> list[Lack]:
    """What the twin lacks, by the probability of each effect."""
    number = model.altered.index(True)
    rows = []
    for name, probability in verdict.effects.items():
        fitted = next((found.fitted[ids] for ids in verdict.sets if name in ids and ids in found.fitted), None)
        if fitted is None or probability < _BELIEVED * max(verdict.effects.values()):
            continue
        i = [c.effect.id for c in fitted.columns].index(name)
        column, x = fitted.columns[i], float(fitted.x[i])
        if x == 0.0:
            continue
        others = [a for j, a in enumerate(fitted.acting) if j != i]
        without, acting = model.record(number, fitted.theta, others), model.record(number, fitted.theta, fitted.acting)
        change = [h * x / column.x for h in column.change]
        weight = probability * float(sum(np.sum(h**2) for h in change))
        std = float(np.hypot(np.sqrt(max(fitted.covariance[i, i], 0.0)) / abs(x), column.effect.law_error))
        rows.append(ActingEffect(column.effect, model.course(column.effect, without, acting), weight,
                           chi_square_by_phase(change, found.linearised.comparisons), std))
    return _lacking(rows)


def alone(model: Locatable, found: Found) -> list[Lack]:
    """What each place would have to add by itself, any of its effects' ways taken as a free input, before one is believed."""
    sums, columns = found.linearised.evidence.sums, found.linearised.columns
    precision = np.diagonal(sums.information) + WIDTH**-2
    explained = sums.score**2 / precision
    best: dict[str, int] = {}
    for i in np.argsort(-explained):
        if sums.score[i] > 0.0:
            best.setdefault(columns[i].effect.component, int(i))
    rows = []
    for i in list(best.values())[:_PLACES_ALONE]:
        departure = float(sums.score[i] / precision[i])
        rows.append(_by_itself(model, found, columns[i], departure, float(explained[i]), float(1.0 / (departure * np.sqrt(precision[i])))))
    return _lacking([row for row in rows if row is not None])


def _lacking(acting: Sequence[ActingEffect]) -> list[Lack]:
    """What is lacking where shares are brought to a sum of one."""
    total = sum(one.share for one in acting) or 1.0
    return lacks([replace(one, share=one.share / total) for one in acting])


def _by_itself(model: Locatable, found: Found, column: Column, departure: float, share: float, relative: float) -> ActingEffect | None:
    """One way of an effect as it acts with nothing else, at so many multiples of its column; None where its bounds allow nothing."""
    number, theta = model.altered.index(True), found.linearised.theta
    x = column.effect.limit(departure * column.x)
    if x == 0.0:
        return None
    without, acting = model.record(number, theta), model.record(number, theta, [(column.effect, column.law, x)])
    change = [h * x / column.x for h in column.change]
    return ActingEffect(column.effect, model.course(column.effect, without, acting), share,
                  chi_square_by_phase(change, found.linearised.comparisons), relative)


def unknown_places(model: Locatable, found: Found, unknown: Unknown, leader: Refitted) -> list[Lack]:
    """Where something acts that no listed effect explains: what each likely place lacks, or the reading that errs there.

    Of several places each has one row, so that the likeliest stands first.
    """
    likely = [place for place in unknown.places if place.share >= _LIKELY] or unknown.places[:1]
    whole = sum(place.share for place in likely)
    acting, rows = [], []
    for place in likely:
        share = place.share / whole
        one = _by_itself(model, found, place.column, place.departure, share, place.relative) if place.departure > 0.0 else None
        if one is not None:
            acting.append(one if len(likely) == 1 else replace(one, by_phase=_in_one(one.by_phase)))
            continue
        if place.course is not None:
            rows += _misread(found, place, share, apart=len(likely) == 1)
            continue
        by_phase = _left_by_phase(found, leader, {form.signal for form in unknown.forms if form.gain > 0.0})
        rows += [Lack(place.component, place.domain, phase, "", unknown.size, _CRUDE * unknown.size, unknown.unit, share * part)
                 for phase, part in (by_phase if len(likely) == 1 else _in_one(by_phase)).items() if part > 0.0]
    lacking = lacks(acting)
    rows += [row for row in lacking if not row.regime]
    return sorted(rows, key=lambda row: -row.share) + [row for row in lacking if row.regime]


def located(unknown: Unknown, linearised: Linearised, places: list[FreePlace]) -> Unknown:
    """The same with where it acts; as large as the likeliest reading errs, if a reading it is."""
    if places[0].course is None:
        return replace(unknown, places=places)
    value, _, unit = _misreading(linearised, places[0])
    return replace(unknown, places=places, size=float(np.sqrt(np.mean(value**2))), unit=unit)


def sized(unknown: Unknown, rows: Sequence[Lack]) -> Unknown:
    """The same, as large as what is lacking at its likeliest place; a reading that errs keeps the size that `located` gave it.

    Args:
        rows: of `unknown_places`; the mean of the first that is not nothing counts.
    """
    own = [row for row in rows if row.component == unknown.places[0].component]
    if not own or unknown.places[0].course is not None:
        return unknown
    row = next((row for row in own if row.value), own[0])
    return replace(unknown, size=abs(row.value), unit=row.unit)


def _misreading(linearised: Linearised, place: FreePlace) -> tuple[np.ndarray, np.ndarray, str]:
    """What the reading of a place is off by in the recordings in which effects act, in its unit, (b,), phases (b,), and that unit."""
    value, phase, unit = [], [], ""
    for comparison, signals, course, acts in zip(linearised.comparisons, linearised.model.signals, place.course, linearised.model.altered,
                                                 strict=True):
        for block in comparison.blocks:
            if acts and block.signal == place.signal:
                value.append(course[block.rows] * block.spread)
                phase.append(block.binning.phase)
                unit = signals[block.signal].unit
    return np.concatenate(value), np.concatenate(phase), unit


def _misread(found: Found, place: FreePlace, share: float, apart: bool) -> list[Lack]:
    """Rows of a reading that errs: its mean error in each phase, or in all of them together."""
    value, phase, unit = _misreading(found.linearised, place)
    by_phase = chi_square_by_phase(place.course, found.linearised.comparisons) if apart else {"all": 1.0}
    rows = []
    for name, part in by_phase.items():
        own = value[phase == PHASES.index(name)] if name in PHASES else value
        mean = float(own.mean()) if own.size else 0.0
        rows.append(Lack(place.component, place.domain, name, "", mean, _CRUDE * abs(mean), unit, share * part, (place.signal,)))
    return [row for row in rows if row.share > 0.0]


def _in_one(by_phase: Mapping[str, float]) -> dict[str, float]:
    """The phase that has most of a chi-square, as all of it; all phases where none has."""
    phase = max(by_phase, key=by_phase.get, default="all")
    return {phase if by_phase.get(phase, 0.0) >= _MOSTLY else "all": 1.0}


def _left_by_phase(found: Found, leader: Refitted, named: Collection[str]) -> dict[str, float]:
    """Parts of what is left beside a hypothesis in some signals, or in all, of the recordings in which effects act; summing to 1."""
    linearised = found.linearised
    left = [np.zeros(c.size) for c in linearised.comparisons]
    for i, (comparison, altered) in enumerate(zip(linearised.comparisons, linearised.model.altered, strict=True)):
        residual = comparison.residual(leader.predictions[i]) if altered else None
        for block in comparison.blocks:
            if residual is not None and (block.signal in named or not named):
                left[i][block.rows] = residual[block.rows]
    return chi_square_by_phase(left, linearised.comparisons)


def entry_of(row: Lack) -> Place:
    return {"component": row.component, "domain": row.domain, "phase": row.phase, "share": row.share, "missing": row.value,
            "unit": row.unit, "std": row.std}
