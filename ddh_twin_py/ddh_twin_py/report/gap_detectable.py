"""How large an effect would have to be for a recording without a gap to have shown it."""

from __future__ import annotations

import math

from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.report import document as doc
from ddh_twin_py.report.gap_design_words import shows_in, smallest
from ddh_twin_py.report.gap_words import effect_name
from ddh_twin_py.report.units import number


def detectable(diagnosis: Diagnosis) -> doc.Html:
    """From which size each effect would have been found, what shows least last; empty where that was not asked."""
    if not diagnosis.detectable:
        return doc.Html("")
    columns = (doc.Column("Effect", number=False), doc.Column("Would have been found from", "departure", False),
               doc.Column("Rise there", "× noise"), doc.Column("Shows most in", number=False))
    ordered = sorted(diagnosis.detectable, key=lambda d: math.inf if d.rise is None else d.rise)
    rows = [(effect_name(d.effect), smallest(d), number(d.rise, 1), shows_in(d)) for d in ordered]
    table = doc.table(columns, rows, "Found: the evidence for it is expected to be 20 times that for none. The departure is that of the "
                                     "quantity that a diagnosis reports, from its value without the effect; a dash: at no possible size.")
    return doc.Html(doc.note("No gap says that an effect of this size or more is unlikely to act: it would be expected to have shown. "
                             "What is smaller may act unseen, and the table of hypotheses holds what is not unlikely.")
                    + doc.details("How large an effect would have to be", doc.Html(f'<div class="whole-words">{table}</div>')))
