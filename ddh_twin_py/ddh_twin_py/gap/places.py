"""What the twin lacks and where: under the hypotheses, before one is believed, and where something unknown acts."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.diagnosis import Lack
from ddh_twin_py.gap.hypotheses import WIDTH
from ddh_twin_py.gap.lacking import Acting, chi_square_by_phase, lacks
from ddh_twin_py.gap.model import Diagnosable
from ddh_twin_py.gap.refit import Refitted
from ddh_twin_py.gap.search import Found
from ddh_twin_py.gap.unknown import Unknown
from ddh_twin_py.gap.verdict import Verdict

_PLACES_ALONE = 5


def places(model: Diagnosable, found: Found, verdict: Verdict) -> list[Lack]:
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
        std = float(np.hypot(np.sqrt(max(fitted.covariance[i, i], 0.0)) / abs(x), column.effect.law_error))
        rows.append(Acting(column.effect, model.course(column.effect, without, acting), weight,
                           chi_square_by_phase(change, found.linearised.comparisons), std))
    total = sum(row.share for row in rows) or 1.0
    return lacks([Acting(r.effect, r.course, r.share / total, r.by_phase, r.relative) for r in rows])


def alone(model: Diagnosable, found: Found) -> list[Lack]:
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


def unknown_places(model: Diagnosable, found: Found, unknown: Unknown, leader: Refitted) -> list[Lack]:
    """Where something acts that no listed effect explains, by the phases of its signals' chi-square."""
    number = model.altered.index(True)
    comparison = found.linearised.comparisons[number]
    left = [np.zeros(c.size) for c in found.linearised.comparisons]
    named = {form.signal for form in unknown.forms if form.gain > 0.0}
    for block in comparison.blocks:
        if block.signal in named or not named:
            left[number][block.rows] = comparison.residual(leader.predictions[number])[block.rows]
    parts = chi_square_by_phase(left, found.linearised.comparisons)
    return [Lack(unknown.component, unknown.domain, phase, "", unknown.size, 0.3 * unknown.size, unknown.unit, share)
            for phase, share in parts.items() if share > 0.0]


def entry_of(row: Lack) -> dict:
    return {"component": row.component, "domain": row.domain, "phase": row.phase, "share": row.share, "missing": row.value,
            "unit": row.unit, "std": row.std}
