"""What a hypothesis had to bear before it was believed: every rule that was asked, what it measured, and from where it would doubt."""

from __future__ import annotations

from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.report.gap.words import set_name
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.units import number

_FLOOR, _DEVIATIONS, _EVIDENCE = "× floor", "standard deviations", "points of evidence"
CHECKS = {
    "structure": ("Does it leave something in the field recording that has a law of its own?", "what that would gain", _EVIDENCE, 0.0),
    "left_behind": ("Does a signal that it explains stay off in the held-out data?", "the farthest, rig at its best", _FLOOR, 1.0),
    "far_off": ("Do most signals of the held-out data stay off?", "the median, rig at its best", _FLOOR, 1.0),
    "worsened": ("Does it spoil a signal of the held-out data?", "beyond 1.2 times what that was off without it", _FLOOR, 0.0),
    "refuted": ("Does it widen the gap of the held-out data?", "by how much", _FLOOR, 0.0),
    "strained": ("Does the rig that it assumes misfit the commissioning recording?", "the farthest fast signal", _FLOOR, 1.0),
    "off_its_noise": ("Are steady speeds off on average, in the field recording?", "means over steady stretches", "× their noise", 1.0),
    "drifted": ("Must the rig have changed beside it?", "from the rig as commissioned", _DEVIATIONS, 0.0),
    "displaced": ("Do the held-out data ask for another rig than the field recording?", "from the rig as fitted", _DEVIATIONS, 0.0),
    "resized": ("Do the held-out data ask for another size of it?", "what another size would gain", _EVIDENCE, 0.0),
    "bent": ("Would its law have to differ from phase to phase, or with speed and warmth?", "what that would gain", _EVIDENCE, 0.0),
    "outdone": ("Does one place, free in phase, speed and warmth, explain more?", "by how much", _EVIDENCE, 0.0),
    "cancelling": ("Do its two effects undo each other?", "share of what they do to the signals", "", 0.0),
}
"""Of each check: the question, to which yes is bad, what is measured, the unit, and what is measured where nothing is wrong."""
_NEAR = 0.75  # of the way to the limit, from which a check is near it
_ABOUT = (
    "Each question asks whether a cause outside the catalogue would do better. At the number under 'doubted from' such a cause is as "
    "likely as not by that question alone; some of these numbers grow with what the hypothesis explains. Where noise alone is left "
    "a signal is off by 1 floor; how much a gap widens, and what is beyond a limit, is 0 where nothing is wrong. A number below 0 speaks "
    "for the hypothesis, such as a gap that it narrows. Held-out data are looked at with what the "
    "recordings left open of the rig at its best, so these numbers may be smaller than those of the charts. A question that does not "
    "apply was not asked. Where the answer is yes the notes say what follows, or why nothing does. The method is in "
    "docs/gap_method.md, section 11."
)
_NEARLY = "'Nearly' is three quarters of the way from where nothing is wrong to there. "


def checks_of(diagnosis: Diagnosis) -> doc.Html:
    """The checks as a table, empty where none was made."""
    rows = diagnosis.report.get("checks", [])
    if not rows:
        return doc.Html("")
    columns = (doc.Column("Asked", number=False), doc.Column("Answer", number=False), doc.Column("Measured", number=False),
               doc.Column("Doubted from"))
    table, near = [], False
    for row in rows:
        question, what, unit, nothing = CHECKS[row["check"]]
        share = (row["measured"] - nothing) / (row["limit"] - nothing)
        level, answer = ("good", "no") if share < _NEAR else ("fair", "nearly") if share < 1.0 else ("poor", "yes")
        measured = f"{number(row['measured'], 2)} {unit}".strip()
        near = near or answer == "nearly"
        table.append((question, doc.mark(level, answer), f"{measured}; {what}", number(row["limit"], 2)))
    asked = doc.paragraph(f"Asked about: {set_name(tuple(rows[0]['effects']))}.")
    return doc.Html(asked + doc.table(columns, table) + doc.note(_NEARLY * near + _ABOUT))
