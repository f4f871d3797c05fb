"""What a hypothesis had to bear before it was believed: every rule that was asked, what it measured, and from where it would doubt."""

from __future__ import annotations

from dataclasses import dataclass

from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.report.gap.words import set_name
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.units import number


@dataclass(frozen=True)
class _Check:
    """What a rule asks, and how its answer is told.

    Attributes:
        question: yes is bad. measured: what was measured, {} is the number. unit: of it, in short.
        nothing: what is measured where nothing is wrong.
        less: told in place of a number that is not above 0, where 0 is what is expected; empty where each number is told.
    """

    question: str
    measured: str
    unit: str
    nothing: float = 0.0
    less: str = ""


CHECKS = {
    "structure": _Check("Does it leave something in the field recording that has a law of its own?",
                        "such a law would gain {} points of evidence", "points", less="such a law would gain nothing"),
    "left_behind": _Check("Does a signal that it explains stay off in the held-out data?",
                          "the farthest is {} × its floor off, rig at its best", "× floor", 1.0),
    "far_off": _Check("Do most signals of the held-out data stay off?",
                      "half of them are {} × their floor off or more, rig at its best", "× floor", 1.0),
    "worsened": _Check("Does it spoil a signal of the held-out data?",
                       "one is {} × its floor beyond a fifth more than it is off without it", "× floor",
                       less="none is off by a fifth more than without it"),
    "refuted": _Check("Does it widen the gap of the held-out data?", "wider by {} × floor", "× floor", less="not wider than without it"),
    "strained": _Check("Does the rig that it assumes misfit the commissioning recording?",
                       "the fast signal that is farthest off is {} × its floor off", "× floor", 1.0),
    "off_its_noise": _Check("Are steady speeds off on average, in the field recording?",
                            "means over steady stretches are {} × their noise off", "× noise", 1.0),
    "drifted": _Check("Must the rig have changed beside it?",
                      "{} standard deviations farther from the rig as commissioned than is to be expected", "deviations",
                      less="no farther from the rig as commissioned than is to be expected"),
    "displaced": _Check("Do the held-out data ask for another rig than the field recording?",
                        "{} standard deviations farther from the rig as fitted than is to be expected", "deviations",
                        less="no farther from the rig as fitted than is to be expected"),
    "resized": _Check("Do the held-out data ask for another size of it?", "another size would gain {} points of evidence", "points",
                      less="another size would gain nothing"),
    "bent": _Check("Would its law have to differ from phase to phase, or with speed and warmth?",
                   "that would gain {} points of evidence", "points", less="that would gain nothing"),
    "outdone": _Check("Does one place, free in phase, speed and warmth, explain more?", "more by {} points of evidence", "points",
                      less="no place explains more"),
    "cancelling": _Check("Do its two effects undo each other?", "a share of {} of what they do to the signals", ""),
}
"""By the name of the rule."""
_NEAR = 0.75  # of the way to the limit, from which a check is near it
_ABOUT = (
    "Each question asks whether a cause outside the catalogue would do better. At the number under 'doubted from' such a cause is as "
    "likely as not by that question alone; some of these numbers grow with what the hypothesis explains. Where noise alone is left "
    "a signal is off by 1 floor. Held-out data are looked at with what the "
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
               doc.Column("Doubted from", number=False))
    table, near = [], False
    for row in rows:
        check = CHECKS[row["check"]]
        level, answer = _answer(check, row["measured"], row["limit"])
        near = near or answer == "nearly"
        limit = f"{_rounded(row['limit'])} {check.unit}".rstrip()
        table.append((check.question, doc.mark(level, answer), _measured(check, row["measured"]), limit))
    asked = doc.paragraph(f"Asked about: {set_name(tuple(rows[0]['effects']))}.")
    return doc.Html(asked + doc.table(columns, table, stacks=True) + doc.note(_NEARLY * near + _ABOUT))


def _answer(check: _Check, measured: float, limit: float) -> tuple[str, str]:
    """Level and word; a limit below what is expected where nothing is wrong has no way to it, and nothing is near it."""
    if measured >= limit:
        return "poor", "yes"
    near = limit > check.nothing and (measured - check.nothing) / (limit - check.nothing) >= _NEAR
    return ("fair", "nearly") if near else ("good", "no")


def _measured(check: _Check, value: float) -> str:
    """What a rule measured, in words where it is not above what is expected."""
    return check.less if check.less and round(value, 2) <= 0.0 else check.measured.format(_rounded(value))


def _rounded(value: float) -> str:
    """A number with the decimals that its size asks for."""
    return number(value, 2 if abs(value) < 100.0 else 0)
