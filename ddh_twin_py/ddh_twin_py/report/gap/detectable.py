"""How large an effect would have to be for a recording without a gap to have shown it."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.gap.explain.detection import Detection
from ddh_twin_py.report.gap.design_words import shows_in
from ddh_twin_py.report.gap.words import effect_name
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.units import moved, number, plus_minus, words


def detectable(diagnosis: Diagnosis) -> doc.Html:
    """From which size each effect would have been found, what cannot be told first and what shows least last; empty where that was not
    asked."""
    if not diagnosis.detectable and not diagnosis.untold:
        return doc.Html("")
    columns = (doc.Column("Effect", number=False), doc.Column("Would have been found from", "value (departure)", False),
               doc.Column("Rise there", "× noise"), doc.Column("Shows most in", number=False))
    ordered = sorted(diagnosis.detectable, key=lambda d: (d.beyond or d.smallest is None, math.inf if d.rise is None else d.rise))
    rows = [(effect_name(effect), f"cannot be told here: {why}", "–", "–") for effect, why in diagnosis.untold.items()]
    rows += [(effect_name(d.effect), _found_from(d), number(d.rise, 1), shows_in(d)) for d in ordered]
    table = doc.table(columns, rows, "Found: the evidence for it is expected to be 20 times that for none. The value is that of the "
                                     "quantity that a diagnosis reports, in brackets its departure from that without the effect where "
                                     "this is not 0; a dash: at no possible size.")
    return doc.Html(doc.note("No gap says that an effect of this size or more is unlikely to act: it would be expected to have shown. "
                             "What is smaller may act unseen, and the table of hypotheses holds what is not unlikely."
                             + _cannot_be_told(diagnosis.untold))
                    + doc.details("How large an effect would have to be", doc.Html(f'<div class="whole-words">{table}</div>')))


def _cannot_be_told(untold: Mapping[str, str]) -> str:
    """Effects of which nothing is said by size."""
    named = ", ".join(map(effect_name, untold))
    return f" Of these it says nothing, at no size: {named}; what they would do may be older than commissioning." if untold else ""


def _found_from(d: Detection) -> str:
    """The value from which an effect is found, with the quantity's name; a dash where there is none."""
    if d.smallest is None:
        return "–"
    name = words(EFFECTS[d.effect].parameter) if d.effect in EFFECTS else ""
    departure = plus_minus(d.smallest, None, d.unit, sign=True)
    value = f"{moved(d.nominal, d.smallest, d.unit)} ({departure})" if d.nominal else departure
    return f"{name} {value}{', which no machine reaches' if d.beyond else ''}".lstrip()
