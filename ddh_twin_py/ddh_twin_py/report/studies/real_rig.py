"""The page of a study of a real rig, and the table of several."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ddh_twin_py.report.gap.hypotheses import classes, effects_ranked, hypotheses
from ddh_twin_py.report.gap.next_test_block import next_test_block
from ddh_twin_py.report.gap.parameters import parameters_table
from ddh_twin_py.report.gap.places import lacking_table
from ddh_twin_py.report.gap.residual_charts import residual_sections
from ddh_twin_py.report.gap.rest import shrink_table, unknown
from ddh_twin_py.report.gap.words import VERDICTS, set_name
from ddh_twin_py.report.page import charts
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.units import number, plain, probably

if TYPE_CHECKING:
    from ddh_twin_py.real_rigs.diagnose import Outcome
    from ddh_twin_py.real_rigs.study import Picture, Row, Study

TABLE = ("rig", "found", "figure", "unit", "data", "samples", "before", "after", "published", "negative controls")
"""Columns of the table of several studies."""


def real_rig_end(study: Study) -> doc.EndMatter:
    """What the numbers rest on."""
    rows = [(name, said) for name, said in study.splits]
    if study.seconds:
        rows.append(("Computing time", ", ".join(f"{name} {number(value, 1)} s" for name, value in study.seconds.items())))
    return doc.EndMatter("; ".join(f"{name}: {said}" for name, said in study.splits), study.source, study.assumptions, rows)


def real_rig_document(study: Study) -> doc.Document:
    """The page."""
    level = "good" if all(c.passed for c in study.controls) and all(r.after < r.before for r in study.rows) else "fair"
    page = doc.Document("Real rig", study.title, study.sentence, real_rig_end(study), level)
    page.add("In short", doc.figures([*_key_figures(study)]))
    page.add("Before and after", _rows(study.rows), *(_picture(p) for p in study.pictures))
    for title, cells in study.tables.items():
        head, *body = cells
        page.add(title, doc.table([doc.Column(str(name), number=i > 0) for i, name in enumerate(head)], body))
    page.add("Negative controls", _controls(study))
    for n, outcome in enumerate(study.rounds, 1):
        page.add(f"Diagnosis {n}", *_diagnosis(outcome))
    page.add("Notes", *(doc.paragraph(said) for said in study.notes))
    return page


def table_of(studies: Sequence[Study]) -> list[tuple[str, ...]]:
    """One line per figure of each study, by the columns of `TABLE`."""
    out = []
    for study in studies:
        passed = f"{sum(c.passed for c in study.controls)} of {len(study.controls)}"
        for row in study.rows:
            out.append((study.rig, " + ".join(study.found) or "nothing", row.what, row.unit, row.split, str(row.samples),
                        plain(row.before), plain(row.after), row.published, passed))
    return out


def as_csv(studies: Sequence[Study]) -> str:
    """The table as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(TABLE)
    writer.writerows(table_of(studies))
    return text.getvalue()


def _key_figures(study: Study):
    yield doc.Figure("Found", " and ".join(study.found) or "nothing", f"{len(study.rounds)} diagnoses, each with what was found built in")
    for row in study.rows[:4]:
        yield doc.Figure(row.what, f"{plain(row.before)} → {plain(row.after)} {row.unit}", row.split + (
            f"; published {row.published}" if row.published else ""))
    if study.controls:
        yield doc.Figure("Negative controls", f"{sum(c.passed for c in study.controls)} of {len(study.controls)} passed")


def _rows(rows: Sequence[Row]) -> doc.Html:
    columns = (doc.Column("Figure", number=False), doc.Column("Data", number=False), doc.Column("Samples"), doc.Column("Before"),
               doc.Column("After"), doc.Column("Unit", number=False), doc.Column("Published", number=False))
    return doc.table(columns, [
        (r.what, r.split, r.samples, _with_interval(r.before, r.before_interval), _with_interval(r.after, r.after_interval), r.unit,
         r.published or "–") for r in rows
    ])


def _with_interval(value: float, interval: tuple[float, float] | None) -> str:
    return plain(value) if interval is None else f"{plain(value)} ({plain(interval[0])} to {plain(interval[1])})"


def _controls(study: Study) -> doc.Html:
    if not study.controls:
        return doc.Html("")
    columns = (doc.Column("Tried", number=False), doc.Column("Must come out", number=False), doc.Column("Came out", number=False),
               doc.Column("", number=False))
    return doc.table(columns, [(c.what, c.expected, c.found, doc.mark("good", "passed") if c.passed else doc.mark("poor", "failed"))
                               for c in study.controls])


def _picture(picture: Picture) -> doc.Html:
    lines = [charts.Trace(line.label, line.role, line.values, dots=line.dots) for line in picture.lines]
    return doc.Html(charts.charts([charts.Chart(picture.title, picture.unit, picture.time, lines, digits=4, height=190, wide=True,
                                                differences=picture.differences, note=picture.note, below=140)]))


def _diagnosis(outcome: Outcome) -> list[doc.Html]:
    diagnosis = outcome.diagnosis
    words = f"Built in: {set_name(outcome.believed)}." if outcome.believed else "Nothing is built in."
    blocks = [
        doc.Html(f'<p class="found"><strong>{doc.text(words)}</strong></p>'),
        doc.paragraph(f"The engine: {VERDICTS[outcome.verdict][0].lower()}. {diagnosis.sentence}"),
        doc.note("Among the listed effects alone: " + "; ".join(f"{set_name(ids)} {probably(p)}" for ids, p in _leading(outcome))
                 + f". Held-out residuals {'surely shrink' if outcome.shrinks else 'do not surely shrink'} "
                 f"({diagnosis.report['held_out']})."),
    ]
    test = diagnosis.report["next_test"]
    blocks += [effects_ranked(diagnosis), classes(diagnosis), shrink_table(diagnosis), unknown(diagnosis),
               next_test_block({**test, "description": f"Next test: {test['description']}"}) if test else doc.note(outcome.why_no_test())]
    if outcome.leader.columns:
        blocks.append(doc.details("What the leading effects add, by regime", lacking_table(outcome.places())))
    blocks += [doc.details("Hypotheses", hypotheses(diagnosis)),
               doc.details("Parameters", parameters_table(diagnosis.parameters, diagnosis.rig)),
               doc.details("Residuals on held-out data of this diagnosis", *residual_sections(diagnosis))]
    notes = [doc.note(said) for said in diagnosis.report["notes"]]
    return [*blocks, *notes]


def _leading(outcome: Outcome) -> list[tuple[tuple[str, ...], float]]:
    """The leading listed sets, at most four."""
    return [(ids, p) for ids, p in outcome.listed.sets.items() if p >= 0.005 and ids != ("unknown",)][:4]
