"""Where a gap lies: the circuit coloured by what is missing, per phase, and what the twin lacks there in figures."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.report.gap.words import PHASE_MEANING, PHASES, capital, component_name, mostly, percent, places, regime_name, signal_name
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.circuit_drawing import COMPONENTS, Tint, circuit_drawing, scale, step_of
from ddh_twin_py.report.units import plus_minus, probably

WOULD_LACK = "What the twin would lack if something acted"
"""Heading of what the twin lacks where that no effect acts is likeliest."""
_UNSURE = re.compile(r" ± \S+")
_AT_ALL_TIMES = "Whole recording", "the mean over all phases; evidence of readings that belong to no phase, such as temperatures"
_WITH_STD = 2.0
"""Standard deviations from which on a lack is called clear."""


def drawings(diagnosis: Diagnosis) -> doc.Html:
    """One large drawing of the whole, one small per phase; plain where nothing is missing."""
    recorded = frozenset(diagnosis.report["shrink"]) or None
    erring = tuple(dict.fromkeys(name for row in diagnosis.lacking if row.component == "sensor" for name in row.signals))
    rows = [Lack(r["component"], r["domain"], r["phase"], "", r["missing"], r["std"], r["unit"], r["share"])
            for r in diagnosis.report["where"] if r["component"] in COMPONENTS]
    if not rows:
        return doc.Html(
            doc.paragraph(_nowhere(diagnosis))
            + f'<div class="phases"><div class="phase wide"><div class="scroll">{circuit_drawing({}, "The DDH circuit", recorded)}'
            + "</div></div></div>"
        )
    by_phase = {phase: [row for row in rows if row.phase == phase] for phase in PHASES}
    if len(by_phase["all"]) == len(rows):
        figures = [_figure(*_AT_ALL_TIMES, _of_phase(rows), recorded, erring, wide=True)]
    else:
        figures = [_figure("All phases together", "share of the evidence", _whole(rows), recorded, erring, wide=True)]
        figures += [_figure(p.capitalize(), PHASE_MEANING[p], _of_phase(own), recorded, erring)
                    for p, own in by_phase.items() if p != "all"]
        if by_phase["all"]:
            figures.append(_figure(*_AT_ALL_TIMES, _of_phase(by_phase["all"]), recorded, erring))
    return doc.Html(
        doc.paragraph("What is missing is what would have to be added at a place of the twin for it to agree with the rig: a flow, a "
                      "force, a torque, a heat, or a reading. A minus means that the rig has less of it than the twin. Friction "
                      "has the sign of the motion: where the rig has more of it in lowering the number is negative, and in a mean over "
                      "both ways it cancels. The colour is the "
                      "share of the evidence: how strongly the recordings ask for it there, not how large it is.")
        + scale() + f'<div class="phases">{"".join(figures)}</div>'
    )


def _nowhere(diagnosis: Diagnosis) -> str:
    """Why nothing is marked."""
    if diagnosis.report["verdict"] == "insufficient":
        return "The record does not say where anything is missing."
    if diagnosis.report["verdict"] != "no_gap":
        return "No place can be named at which something is missing."
    none = next((row["probability"] for row in diagnosis.report["hypotheses"] if not row["effects"]), 0.0)
    said = f"No place is marked, as that no effect acts is likelier ({probably(none)}) than that any does."
    return said + (f" What would be missing if one did stands under '{WOULD_LACK}'." if diagnosis.lacking or diagnosis.alone else "")


def drawing_of(rows: Sequence[Lack], title: str) -> doc.Html:
    """One drawing of the shares of some rows, those of single regimes left out; empty where there are none."""
    tints = _whole([row for row in rows if not row.regime and row.component in COMPONENTS])
    return doc.Html(f'<div class="phases">{_figure(title, "share of the evidence", tints, wide=True)}</div>' if tints else "")


def lacking_table(rows: Sequence[Lack], caption: str = "", supposed: bool = False) -> doc.Html:
    """What is missing by place, phase and regime, largest share first within whole and parts; empty where there are none.

    Args:
        supposed: that something acts there is only supposed.
    """
    if not rows:
        return doc.Html("")
    columns = (
        doc.Column("Place", number=False), doc.Column("Kind", number=False), doc.Column("Phase", number=False),
        doc.Column("Regime", "range of the variable", number=False),
        doc.Column("Would be missing ± std" if supposed else "Missing ± std", "mean there"),
        doc.Column("Share", "of the evidence"), doc.Column("How sure", "if something acts there" if supposed else "", number=False),
    )
    ordered = sorted(rows, key=lambda r: (bool(r.regime), -r.share))
    table = doc.table(columns, [
        (capital(component_name(r.component)), r.domain, "mean of all" if r.phase == "all" else r.phase,
         regime_name(r.regime) or "all", plus_minus(r.value, r.std, r.unit, sign=True), "–" if r.regime else percent(r.share),
         sureness(r.value, r.std))
        for r in ordered
    ], caption)
    return doc.Html(f'<div class="snug">{table}</div>')


def sureness(value: float, std: float) -> doc.Html:
    """Whether a value stands out of its uncertainty, as a mark with words."""
    if value == 0.0:
        return doc.mark("none", "nothing")
    times = abs(value) / std if std > 0.0 else float("inf")
    if times >= 2.0 * _WITH_STD:
        return doc.mark("good", "clear")
    return doc.mark("fair", "likely") if times >= _WITH_STD else doc.mark("none", "may be chance")


def _figure(title: str, words: str, tints: dict[str, Tint], recorded: frozenset[str] | None = None,
            erring: Sequence[str] = (), wide: bool = False) -> str:
    said = "; ".join(tint.title + (_readings(erring) if name == "sensor" else "") for name, tint in tints.items())
    said = said or "nothing is missing here"
    head = f'<p class="caption">{doc.text(title)} <span class="unit">{doc.text(words)}</span></p>'
    drawn = circuit_drawing(tints, f"{title}: {said}", recorded, erring)
    return (
        f'<div class="phase{" wide" if wide else ""}">{head}<div class="scroll">{drawn}</div>'
        f"{doc.note(capital(said) + '.')}</div>"
    )


def _readings(erring: Sequence[str]) -> str:
    """Of which signals it is that readings err; empty where that is not known."""
    return f", in readings of {' and of '.join(signal_name(name) for name in erring)}" if erring else ""


def _whole(rows: Sequence[Lack]) -> dict[str, Tint]:
    found = places([{"component": row.component, "domain": row.domain, "phase": row.phase, "share": row.share} for row in rows])
    return {
        p.component: Tint(step_of(p.share), percent(p.share), f"{component_name(p.component)}: {percent(p.share)} of the evidence, "
                          + mostly(p.largest["domain"], p.largest["phase"]))
        for p in found if p.share > 0.0
    }


def _of_phase(rows: Sequence[Lack]) -> dict[str, Tint]:
    tints = {}
    for name in dict.fromkeys(r.component for r in rows):
        own = sorted((r for r in rows if r.component == name), key=lambda r: -r.share)
        share = sum(r.share for r in own)
        label = _UNSURE.sub("", plus_minus(own[0].value, own[0].std, own[0].unit, sign=True))  # there is no room for more beside a part
        title = "; ".join(f"{component_name(name)}, {r.domain}: {plus_minus(r.value, r.std, r.unit, sign=True)} "
                          f"({percent(r.share)} of the evidence)" for r in own)
        tints[name] = Tint(step_of(share), label + (" …" if len(own) > 1 else ""), title)
    return tints
