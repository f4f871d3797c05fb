"""The page and the JSON of `ddh-twin gap-design`."""

from __future__ import annotations

from ddh_twin_py.gap.drive.design import Design
from ddh_twin_py.gap.explain.classes import TELLS_APART
from ddh_twin_py.gap.explain.detection import DETECTED, SIZES, Detection
from ddh_twin_py.report.gap.design_words import (
    SIZE_WORDS,
    found_at_some_size,
    impossible,
    log_odds,
    nearest,
    separation_words,
    setting,
    shows_in,
    smallest,
    verdict,
)
from ddh_twin_py.report.gap.words import effect_name
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.heatmap import Cell, Grid, heatmap
from ddh_twin_py.report.units import duration, number
from ddh_twin_py.rig import Rig

_FILLS = ((1.0, "#00224e"), (TELLS_APART, "#666970"), (10.0, "#c8b866"))
"""Expected log Bayes factor below which a cell has that colour."""
_CLEAR, _SAME = "#fee838", "#ffffff"
_CAPTION = "How surely each effect is told from every other, as the log of the odds"
_UNSEEN = "○"
_UNSEEN_WORDS = (
    f"{_UNSEEN}: this test does not detect the effect at a moderate size, or it cannot be so large; its row is then of the largest size "
    "that it can have. What a black line surrounds in its row or column counts in no class above: these hold what is detected alone."
)
_GRID = Grid(cell=22, row=22, left=290)
_ASSUMPTIONS = [
    "Rehearsed by the twin with the rig as its file says; noise, tolerances and slack of the model's laws are those of a diagnosis.",
    "Expected values: the noise of a real recording scatters the log of the odds by about the square root of twice its value.",
    "An effect that may act in several ways or in both directions is shown by the way that shows least.",
    "One effect acts at a time.",
]


def design_document(design: Design, rig: Rig, duty: str, seconds: float) -> doc.Document:
    """The page: what is detected, the matrix as a picture, classes."""
    said, level = verdict(design)
    page = doc.Document("Design of a test", f"{rig.rig_id}: what would {duty} tell?", said, _end(rig, seconds), level)
    seen = {size: [d.detects(size) for d in design.detections if d.detects(size) is not None] for size in SIZES}
    asked = len(design.detections)
    page.add("The test", doc.paragraph(setting(design)), doc.figures(
        [doc.Figure(f"{size} effects detected", f"{sum(own)} of {len(own)}", _of_so_many(size, len(own), asked))
         for size, own in seen.items()]
        + [doc.Figure("not told apart", str(sum(map(len, design.classes))), "effects that are detected at a moderate size")]),
        doc.note("Each size is asked of the effects that can be so large and show in a signal; these become fewer from faint to clear, and "
                 "so may those that are detected."))
    page.add("What cannot be told apart", *_classes(design))
    page.add("Every effect against every other", *_matrix(design))
    page.add("What is detected", _detections(design))
    return page


def _of_so_many(size: str, possible: int, asked: int) -> str:
    """What a size is, and how many effects cannot be so large."""
    return SIZE_WORDS[size] + (f"; {asked - possible} more cannot be so large, or show nowhere" if possible < asked else "")


def _end(rig: Rig, seconds: float) -> doc.EndMatter:
    split = "Nothing was measured; every number is expected of a recording that is still to be made."
    return doc.EndMatter(split, rig.file, _ASSUMPTIONS, [("Computing time", f"{seconds:.1f} s")])


def _classes(design: Design) -> list[doc.Html]:
    unseen = [effect_name(d.effect) for d in design.detections if not d.detects("moderate")]
    blocks = [doc.paragraph(" · ".join(effect_name(name) for name in members)) for members in design.classes]
    blocks = blocks or [doc.paragraph("Every two effects that are detected at a moderate size are told apart.")]
    if unseen:
        blocks.append(doc.note("Not detected at a moderate size, or not possible so large: " + ", ".join(unseen) + "."))
    return blocks


def _fill(value: float) -> str:
    return next((fill for least, fill in _FILLS if value < least), _CLEAR)


def _matrix(design: Design) -> list[doc.Html]:
    names = design.names
    if len(names) < 2:
        return []
    numbers = [str(i) for i in range(1, len(names) + 1)]
    cells = []
    for i, one in enumerate(names):
        row = []
        for j, other in enumerate(names):
            value = float(design.separation[i, j])
            if i == j:
                row.append(Cell(_SAME, "", effect_name(one), "told"))
            else:
                label = number(value, 1 if value < TELLS_APART else 0) if value < 10.0 else ""
                row.append(Cell(_fill(value), label, separation_words(one, other, value), "told" if value >= TELLS_APART else "not"))
        cells.append(row)
    keys = (("#00224e", "below 1: alike"), ("#666970", f"1 to {TELLS_APART:g}: not told apart"),
            ("#c8b866", f"{TELLS_APART:g} to 10: told apart"), (_CLEAR, "above 10: surely"), (_SAME, "the effect itself"))
    said = "".join(f'<li><i style="background:{fill}"></i>{words}</li>' for fill, words in keys)
    seen = {d.effect for d in design.detections if d.detects("moderate")}
    rows = [f"{effect_name(name)}{'' if name in seen else f' {_UNSEEN}'}  {n}" for n, name in zip(numbers, names, strict=True)]
    return [
        doc.paragraph("A row is the effect that truly acts, at a moderate size; a column is what it might be taken for, once the rig's "
                      "parameters are fitted again. The number is the log of the odds that the test is expected to give for the truth: at "
                      f"{TELLS_APART:g} the odds are 20 to 1. Black lines go round what is not told apart. Rest the pointer on a cell to "
                      "read it."),
        doc.Html(f'<ul class="key">{said}</ul>'),
        doc.note(_UNSEEN_WORDS) if set(names) - seen else doc.Html(""),
        heatmap(numbers, rows, cells, "taken for (number of the row)", _CAPTION, _GRID),
    ]


def _detections(design: Design) -> doc.Html:
    columns = [doc.Column("Effect", number=False), doc.Column("Smallest detected", "departure", False), doc.Column("Rise", "× noise"),
               doc.Column("Shows most in", number=False), *(doc.Column(size.capitalize(), f"{rise:g} × noise", False)
                                                            for size, rise in SIZES.items()),
               doc.Column("Least told from", "log of the odds", False)]
    rows = []
    for d in design.detections:
        near, rise = nearest(design, d), number(d.rise if found_at_some_size(d) else None, 1)
        rows.append((effect_name(d.effect), smallest(d), rise, shows_in(d), *(_mark(d, size) for size in SIZES),
                     "–" if near is None else f"{effect_name(near[0])}, {log_odds(near[1])}"))
    table = doc.table(columns, rows, "Detected: the evidence for the effect is expected to be 20 times that for none. The departure is "
                                     "that of the quantity that a diagnosis reports, from its value without the effect.")
    return doc.Html(f'<div class="whole-words">{table}</div>')


def _mark(d: Detection, size: str) -> doc.Html:
    found = d.detects(size)
    return doc.mark("none", impossible(d)) if found is None else doc.mark(*(("good", "detected") if found else ("poor", "missed")))


def design_json(design: Design, rig: Rig, duty: str, seconds: float) -> dict:
    """The machine-readable twin of the page; departures in SI."""
    return {
        "report": "gap_design", "verdict": verdict(design)[0], "duty": duty, "duration_s": design.duration,
        "commissioning_s": design.commissioning, "sensors": list(design.sensors), "pressures": design.pressures,
        "detected_from_log_evidence": DETECTED, "told_apart_from": TELLS_APART,
        "effects": [
            {"effect": d.effect, "unit": d.unit, "smallest_departure": d.smallest, "rise_in_noise": d.rise, "worst_signal": d.worst,
             "expected_log_evidence": d.gain, "detected": {size: d.detects(size) for size in SIZES}} for d in design.detections
        ],
        "separation": {"effects": design.names, "expected_log_bayes_factor": design.separation.tolist()},
        "classes": design.classes,
        "end_matter": _end(rig, seconds).as_json() | {
            "rig_id": rig.rig_id, "recorded": setting(design), "length": duration(design.duration), "computing_time_s": seconds},
    }
