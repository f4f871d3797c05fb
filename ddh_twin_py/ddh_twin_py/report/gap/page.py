"""The page of a gap diagnosis: what the twin misses, where, why, how sure that is, and what to test next."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ddh_twin_py.gap.contract import Shrunk
from ddh_twin_py.gap.words import BUT, tolerances
from ddh_twin_py.names import first_of
from ddh_twin_py.report.gap.checks import checks_of
from ddh_twin_py.report.gap.detectable import detectable
from ddh_twin_py.report.gap.hypotheses import classes, effects_ranked, hypotheses
from ddh_twin_py.report.gap.next_test_block import next_test_block
from ddh_twin_py.report.gap.parameters import parameters_table
from ddh_twin_py.report.gap.places import WOULD_LACK, drawing_of, drawings, lacking_table
from ddh_twin_py.report.gap.residual_charts import residual_sections
from ddh_twin_py.report.gap.rest import shrink_table, unknown
from ddh_twin_py.report.gap.words import (
    NEAR,
    VERDICTS,
    capital,
    component_name,
    effect_name,
    ending,
    farther_off,
    floors,
    mostly,
    percent,
    places,
    set_name,
    signal_name,
    times_floor,
    way_closed,
)
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.units import number, probably

if TYPE_CHECKING:
    from ddh_twin_py.gap.diagnosis import Diagnosis

_FLOOR = (
    "Noise floor: what no twin can do better. It is the sensor's noise together with what the twin leaves when fitted to the rig as it was "
    "built; without a recording of that, 1.6 times the noise, so that noise alone is 0.6. A gap of 1 is the floor itself."
)


def gap_document(diagnosis: Diagnosis) -> doc.Document:
    """The page."""
    report = diagnosis.report
    notes = _notes(report["notes"])
    level = VERDICTS[report["verdict"]][1]
    page = doc.Document("Gap diagnosis", _title(diagnosis), _verdict(diagnosis.sentence), gap_end(diagnosis),
                        "fair" if diagnosis.damage and level == "good" else level)
    page.add("In short", doc.figures(_key_figures(diagnosis)), doc.note(_FLOOR), _fits(diagnosis),
             notes if report["verdict"] == "insufficient" else "")
    page.add("Where", drawings(diagnosis))
    if report["verdict"] == "insufficient" and not diagnosis.traces:
        return page
    page.add("Why", hypotheses(diagnosis), effects_ranked(diagnosis))
    page.add("What it had to bear", checks_of(diagnosis))
    page.add("What cannot be told apart", classes(diagnosis))
    if diagnosis.traces:
        page.add("Measured less twin, before and after", doc.note(_residual_note(diagnosis)), *residual_sections(diagnosis))
    page.add("What is left", shrink_table(diagnosis))
    page.add("What would have shown", detectable(diagnosis))
    page.add("What no listed effect explains", unknown(diagnosis))
    page.add(WOULD_LACK if report["verdict"] == "no_gap" else "What the twin lacks", _lacking(diagnosis))
    page.add("The next test", _next_test(report["next_test"], report["verdict"]))
    page.add("Parameters of the rig", parameters_table(diagnosis.parameters, diagnosis.rig, diagnosis.added, *_last_fit(diagnosis)))
    if report["verdict"] != "insufficient":
        page.add("Notes", notes)
    return page


def _verdict(sentence: str) -> doc.Html:
    """The verdict; what may have changed without a recording telling begins a line of its own."""
    first, but, rest = sentence.partition(f" {BUT}")
    return doc.Html(f"{doc.text(first)} <span>{doc.text(but.lstrip() + rest)}</span>") if but else doc.text(sentence)


def _title(diagnosis: Diagnosis) -> str:
    names = [Path(p).name or p for p in diagnosis.recordings.get("field", [])]
    return f"{diagnosis.rig.rig_id}: {', '.join(names)}" if names else diagnosis.rig.rig_id


def _key_figures(diagnosis: Diagnosis) -> list[doc.Figure]:
    report = diagnosis.report
    gap, said = report["gap"], VERDICTS[report["verdict"]][0]
    leading = diagnosis.weighed[0] if diagnosis.weighed else None
    cards = [doc.Figure("Verdict", said, f"{set_name(leading.effects)}, {probably(leading.probability)}" if leading else "see the notes",
                        _reservation(diagnosis))]
    if report["verdict"] != "insufficient":
        cards += [
            doc.Figure("Gap as given", floors(gap["as_is"]), "noise floor; nothing fitted"),
            doc.Figure("Parameters fitted", floors(gap["before"]), "noise floor; no effect added"),
        ]
    if report["verdict"] != "insufficient" and (diagnosis.added or gap["after"] != gap["before"]):
        cards.append(doc.Figure(capital(ending(report["verdict"], diagnosis.added)), floors(gap["after"]),
                                "; ".join(filter(None, ("noise floor", way_closed(gap))))))
    if report["where"]:
        first = places(report["where"])[0]
        cards.append(doc.Figure("Where", capital(component_name(first.component)), f"{percent(first.share)} of the evidence; "
                                + mostly(first.largest["domain"], first.largest["phase"])))
    if report["shrink"]:
        near = sum(times_floor(row, "after") <= NEAR for row in report["shrink"].values())
        cards.append(doc.Figure("Signals explained", f"{near} of {len(report['shrink'])}", f"within {NEAR:g} × floor at the end",
                                _farther_off(report["shrink"])))
    count = {kind: len(paths) for kind, paths in diagnosis.recordings.items()}
    cards.append(doc.Figure("Rig as built", "recorded" if count.get("commissioning") else "not recorded",
                            "changes since then" if count.get("commissioning") else "held against the sheet"))
    if report["notes"] and report["verdict"] != "insufficient":
        cards.append(doc.Figure("Notes", str(len(report["notes"])), "what cannot be known from this record; at the end"))
    held = "validation bag" if count.get("validation") else "part of the field data" if diagnosis.traces else "none"
    cards.append(doc.Figure("Held out", held, report["held_out"]))
    return cards


def _reservation(diagnosis: Diagnosis) -> str:
    """What the verdict leaves open of effects that may act since commissioning; empty where it leaves nothing."""
    named = first_of([effect_name(effect) for effect in diagnosis.untold], 1)
    return f"but {named} may have changed since commissioning; this cannot be told here" if named else ""


def _farther_off(shrink: Mapping[str, Shrunk]) -> str:
    """The signals that end farther off than they were, with both sizes; empty where none does."""
    rows = [(signal_name(name), shrink[name]) for name in farther_off(shrink)]
    named = ", ".join(f"{name} {number(times_floor(row, 'before'), 2)} → {number(times_floor(row, 'after'), 2)}" for name, row in rows)
    return f"farther off than before: {named}" if named else ""


def _notes(notes: list[str]) -> doc.Html:
    if not notes:
        return doc.Html("")
    rows = "".join(f"<li>{doc.text(n)}</li>" for n in notes)
    return doc.Html(f'<ul class="notes">{rows}</ul>')


def _fits(diagnosis: Diagnosis) -> doc.Html:
    """What the fits are whose gaps stand above and among the hypotheses; they differ."""
    if diagnosis.report["verdict"] == "insufficient":
        return doc.Html("")
    if not diagnosis.recordings.get("commissioning"):
        return doc.note(f"Parameters fitted: to the field recording{tolerances(diagnosis.cut)}; 'no effect' is the same fit.")
    last = ending(diagnosis.report["verdict"], diagnosis.added)
    third = f" {capital(last)}: they are fitted to both recordings, too; the table of parameters at the end is of this fit."
    return doc.note("Parameters fitted: to the commissioning recording alone, so the rig as it was built. Parameters refitted, which is "
                    "the hypothesis 'no effect': fitted anew to the field recording as well, nothing added; so its gap may be smaller."
                    + (third if diagnosis.added else " The table of parameters at the end is of this second fit."))


def _last_fit(diagnosis: Diagnosis) -> tuple[str, str]:
    """Of which fit the table of parameters is, and where its values come from where the rig holds those of another; empty where not."""
    told = [path for kind in ("commissioning", "field") for path in diagnosis.recordings.get(kind, [])]
    built = bool(diagnosis.recordings.get("commissioning"))
    last = ending(diagnosis.report["verdict"], diagnosis.added)
    fit = f"Fitted to the {'commissioning and the field recordings together' if built else 'field recording'}, "
    fit += f"{last}; the values leave out what it does." if diagnosis.added else "nothing added."
    if not (built and diagnosis.nameless):
        return fit, ""
    return f"{fit} -o writes those of the commissioning recording alone, as what acts is unknown.", f"fitted to {', '.join(told)}"


def _residual_note(diagnosis: Diagnosis) -> str:
    end = ending(diagnosis.report["verdict"], diagnosis.added)
    end += ", parameters refitted, too" * bool(diagnosis.added)
    return (
        "Only data that took no part in finding or fitting. Orange (before): the twin with its parameters fitted; blue (after): "
        f"{end}. Grey band: the noise floor; it bounds the usual size, single samples of plain noise leave it now and then. Small plots: "
        "the same difference against other variables; line: the middle value, band: two thirds of the samples."
    )


_INPUTS = (
    "Torque, force and flow: measured less what the laws of the fitted rig say at measured speed, pressures and motion, while the shaft "
    "turns steadily. Torque that the shaft asks for is told as the motor's, whichever of its bearings and pumps it comes from. No effect "
    "is assumed, so that what one cause does to speed and pressures is in several rows. Heat: what the smoother adds to each part so that "
    "its temperatures fit; it is drawn towards zero by some watts. What the commissioning recording leaves over alike is taken off; "
    "without one the rig's tolerances are in it, and ± knows of scatter alone. A plus: the rig has more of it than the twin. The flow is "
    "what the pump delivers to the piston side, so that a leak is a minus here."
)


def _lacking(diagnosis: Diagnosis) -> doc.Html:
    blocks = []
    none = diagnosis.report["verdict"] == "no_gap"
    if none and (diagnosis.lacking or diagnosis.alone):
        blocks.append(doc.paragraph("That no effect acts is likelier than all that stands here. A row says what would be missing if "
                                    "something acted at that place; share and certainty are among these rows, not against no effect."))
    if diagnosis.lacking:
        blocks.append(lacking_table(diagnosis.lacking, "If one of the less likely hypotheses held" if none else
                                    "Given the hypotheses, each weighed with its probability", none))
    if diagnosis.alone:
        blocks.append(doc.details("From the data alone, each place as if it acted by itself, before any effect is assumed",
                                  drawing_of(diagnosis.alone, "From the data alone"), lacking_table(diagnosis.alone, supposed=none)))
    if flows := _flows(diagnosis):
        blocks.append(doc.note(flows))
    if diagnosis.inputs:
        blocks.append(doc.details("Unknown inputs: what the recording's own balances leave over", doc.note(_INPUTS),
                                  lacking_table(diagnosis.inputs)))
    if blocks:
        blocks.append(doc.note("± is one standard deviation: the truth lies within it two times out of three. 'Clear' is beyond four of "
                               "them, 'likely' beyond two."))
    if any(row.domain == "thermal" and row.unit == "K" for row in (*diagnosis.lacking, *diagnosis.alone)):
        blocks.append(doc.note("A thermal place in kelvin: what acts there is no heat but a capacity or an exchange; told is how much "
                               "warmer it makes the reading that it moves most."))
    return doc.Html("".join(blocks))


def _flows(diagnosis: Diagnosis) -> str:
    """What a plus of a flow means; empty where none is among what is missing."""
    if not any(row.unit == "m3/s" for row in (*diagnosis.lacking, *diagnosis.alone)):
        return ""
    starved = any("unfilled" in name for name in diagnosis.added)
    unfilled = ", but of a pump that its suction does not fill it is what is delivered" if starved else ""
    return ("A plus: the rig has more of it than the twin. The flow of a pump or a valve is its leak here: a plus means that more passes "
            f"it, and less is delivered{unfilled}.")


_NO_TEST = {
    "unknown": "The catalogue does not hold the cause, so no duty is known that would tell more. Look at the machine where the gap lies.",
    "no_gap": "No test is proposed, as that no effect acts is likelier than each of its rivals. A duty and sensors that show more of "
              "these, and of what is left open, are found with ddh-twin gap-design, before anything is recorded.",
}


def _next_test(test: dict | None, verdict: str) -> doc.Html:
    return next_test_block(test) if test else doc.paragraph(_NO_TEST.get(verdict, "No test is known that would tell more."))


def gap_end(diagnosis: Diagnosis) -> doc.EndMatter:
    """What the numbers rest on."""
    rows = [(f"Recordings, {kind}", ", ".join(paths) or "none") for kind, paths in diagnosis.recordings.items()]
    if diagnosis.seconds:
        rows.append(("Computing time", ", ".join(f"{name} {number(value, 1)} s" for name, value in diagnosis.seconds.items())))
    return doc.EndMatter(f"Held out: {diagnosis.report['held_out']}.", diagnosis.rig.file, diagnosis.assumptions, rows)
