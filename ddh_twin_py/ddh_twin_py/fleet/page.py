"""The page of a fleet: how each rig goes over time, and the table of all recordings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from datetime import datetime

from ddh_twin_py.fleet.recordings import REFERENCE
from ddh_twin_py.fleet.row import Row, with_one_probability
from ddh_twin_py.fleet.trend_chart import Line, trend_chart
from ddh_twin_py.report.gap.words import UNKNOWN, VERDICTS, percent
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.rig.reader_units import plus_minus, shown

_GAPS = ("explained", "ambiguous", "unknown")
_FLOOR = 1.0  # gap below which nothing is beyond the noise
_MOST_NAMED = 10  # rigs with a gap that are named
_MARKS = {"no_gap": "good", "explained": "fair", "ambiguous": "fair", "unknown": "poor", "insufficient": "none", "": "none"}


def fleet_document(folder: str, rows: Sequence[Row], rig_file: str) -> doc.Document:
    """The page."""
    rigs = sorted({row.rig for row in rows if row.rig})
    page = doc.Document(
        kind="Fleet", title=folder, verdict=verdict(rows), level="good" if all(row.verdict == "no_gap" for row in rows) else "fair",
        end=fleet_end(rows, rig_file),
    )  # fmt: skip
    counts = Counter(row.verdict for row in rows if not row.error)
    page.add("Overview", doc.figures([
        doc.Figure("Recordings", str(len(rows)), f"of {_rigs(rigs)}" if rigs else ""),
        *(doc.Figure(VERDICTS[name][0], str(counts[name])) for name in VERDICTS if counts[name]),
        doc.Figure("Errors", str(sum(bool(row.error) for row in rows))),
    ]))  # fmt: skip
    for rig in rigs:
        own = [row for row in rows if row.rig == rig]
        page.add(f"Rig {rig}", *_charts(own), _newest(own))
    page.add("All recordings", _table(rows))
    return page


def fleet_end(rows: Sequence[Row], rig_file: str) -> doc.EndMatter:
    """What the numbers rest on."""
    return doc.EndMatter(
        "Each recording is diagnosed by itself: what its own report says of data split and held-out data holds here.", rig_file,
        [
            "Gaps are in multiples of the noise floor, on data that took no part in fitting; 1 is the floor.",
            "Sizes are those of the most probable effect; bars are two standard deviations. The probability in the table is that the "
            "effect acts, alone or with others; that of a class is that of its members together.",
            "A rig's recordings are told by the rig id in the bag; those without one are in the table alone.",
            *filter(None, [of_reference(rows)]),
        ],
        (("Recordings", str(len(rows))), ("Rigs", str(len({row.rig for row in rows if row.rig}))),
         *([("Answers of other versions", others)] if (others := of_other_versions(rows)) else [])),
    )


def of_reference(rows: Sequence[Row]) -> str:
    """That recordings with an answer were held against the reference sheet, how many, and what a machine of another design needs; '' where
    none was."""
    held = sum(row.sheet.partition(": ")[0] == REFERENCE for row in rows)
    return (f"{held} of {len(rows)} recordings were held against the reference sheet: a machine that differs from it by design "
            "(stroke, pumps ...) needs its own rig file (--rig), else the difference is told as an effect.") if held else ""


def remark(row: Row) -> str:
    """What must be known of a recording before its verdict is read: why there is none, what its answer warns of, or that none of several
    rig files is of its rig; else empty."""
    if row.error:
        return row.error
    told = row.sentence if row.verdict == "insufficient" or row.sentence.startswith("Careful") else ""
    sheet, _, why = row.sheet.partition(": ")
    against = f"Held against the {sheet}: {why}." if sheet == REFERENCE and why else ""
    return " ".join(filter(None, [against, told]))


def verdict(rows: Sequence[Row]) -> str:
    """Of how many recordings and rigs, and what is wrong with how many; in a second sentence in how many all together are within noise."""
    rigs = {row.rig for row in rows if row.rig}
    gaps = [row for row in rows if row.verdict in _GAPS]
    concerned = {row.rig for row in gaps if row.rig}
    failed = sum(bool(row.error) for row in rows)
    unclear = sum(row.verdict == "insufficient" for row in rows)
    answered = len(rows) - failed - unclear
    shows = "shows" if len(gaps) == 1 else "show"
    said = f"{len(gaps)} of {answered} diagnosed recordings {shows} a gap" if answered else "no recording has an answer"
    if rigs:
        said += f", on {len(concerned)} of {_rigs(rigs)}" if answered else f", of {_rigs(rigs)}"
    said += f"; {unclear} {'does' if unclear == 1 else 'do'} not allow an answer" if unclear else ""
    said += f"; {failed} could not be diagnosed." if failed else "."
    within = sum(row.verdict == "explained" and (row.gap_before or _FLOOR) < _FLOOR for row in gaps)
    which = "the one" if len(gaps) == 1 else "all" if within == len(gaps) else f"{within} of those"
    noise = f" In {which} with a gap some signals show the cause, though all together are off by no more than noise."
    return said + (noise if within else "")


def newest_gaps(rows: Sequence[Row]) -> list[str]:
    """A line for each rig whose newest recording with an answer shows a gap, such as 'b, crane_1: explained, line_b.compliance 94 %'.

    A recording that names no rig is one by itself. After `_MOST_NAMED` lines how many more there are.
    """
    newest: dict[tuple[str, str], Row] = {}
    for row in sorted(rows, key=lambda row: (row.rig, row.begin, row.recording)):
        if row.verdict == "no_gap" or row.verdict in _GAPS:
            newest[row.rig, "" if row.rig else row.recording] = row
    told = [f"{', '.join(filter(None, (row.recording, row.rig)))}: {_cause(row)}" for row in newest.values() if row.verdict in _GAPS]
    return [*told[:_MOST_NAMED], *([f"and {len(told) - _MOST_NAMED} more"] if len(told) > _MOST_NAMED else [])]


def _cause(row: Row) -> str:
    """Verdict, cause and its probability, and what acts beside it."""
    share = "" if row.probability is None else f" {percent(row.probability)}"
    if row.effect in ("", UNKNOWN):
        return f"{row.verdict}{' cause' * (row.verdict == 'unknown')}{share}"
    return f"{row.verdict}, {row.effect}{share}" + (f", beside it {row.also}" if row.also else "")


def _rigs(rigs: Sequence[str] | set[str]) -> str:
    return f"{len(rigs)} rig{'' if len(rigs) == 1 else 's'}"


def of_other_versions(rows: Sequence[Row]) -> str:
    """How many answers are kept from which other versions of this project, such as '2 of 1.0+abc'; '' where there is none."""
    counts = Counter(row.version or "one that is not known" for row in rows if row.version != doc.version())
    return ", ".join(f"{n} of {version}" for version, n in sorted(counts.items()))


def _charts(rows: Sequence[Row]) -> list[doc.Html]:
    """Of one rig, all over the same time."""
    span = [row.time for row in rows if row.time and (row.gap_before, row.gap_after, row.size) != (None, None, None)]
    return [_gap_chart(rows, span), *_size_charts(rows, span)]


def _gap_chart(rows: Sequence[Row], span: Sequence[datetime]) -> doc.Html:
    def points(key: str) -> list:
        return [(row.time, getattr(row, key), None, f"{row.recording}: {getattr(row, key):.3g}") for row in rows
                if row.time and getattr(row, key) is not None]

    lines = [Line("before", "predicted", points("gap_before")), Line("after, with what was found", "fused", points("gap_after"))]
    return trend_chart("Gap", "multiples of the floor", lines, ("floor", 1.0), span)


def _size_charts(rows: Sequence[Row], span: Sequence[datetime]) -> list[doc.Html]:
    kinds: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        if row.size is not None and row.time:
            kinds.setdefault((row.effect, row.parameter, row.unit), []).append(row)
    charts = []
    for (effect, parameter, unit), own in sorted(kinds.items()):
        read = shown(unit)
        points = [(row.time, row.size * read.factor, None if row.size_std is None else row.size_std * read.factor,
                   f"{row.recording}: {_size(row)}") for row in own]
        nominal = next((row.nominal for row in own if row.nominal is not None), None)
        line = Line(parameter, "c4", points)
        charts.append(trend_chart(f"{effect}: {parameter.replace('_', ' ')}", read.unit, [line],
                                  None if nominal is None else ("nominal", nominal * read.factor), span))  # fmt: skip
    return charts


def _newest(rows: Sequence[Row]) -> doc.Html:
    told = [row for row in sorted(rows, key=lambda row: row.begin) if row.sentence]
    return doc.note(f"Newest, {told[-1].begin}: {with_one_probability(told[-1]).sentence}") if told else doc.Html("")


def _table(rows: Sequence[Row]) -> doc.Html:
    columns = (
        doc.Column("Recording", number=False), doc.Column("Rig", number=False), doc.Column("Begin", "UTC", number=False),
        doc.Column("Duration", "s"), doc.Column("Verdict", number=False), doc.Column("Effect or class", number=False),
        doc.Column("Probability", "of the effect"), doc.Column("Size ± std"), doc.Column("Gap, floors", "before → after"),
    )  # fmt: skip
    ordered = sorted(rows, key=lambda row: (row.rig, row.begin, row.recording))
    cells = [
        (row.names, row.rig, _begin(row), _number(row.duration, ".0f"),
         doc.mark(_MARKS.get(row.verdict, "none"), _said(row.verdict)) if row.verdict else "–",
         _effect(row),
         "–" if row.probability is None else percent(row.probability), _size(row), _gap(row))
        for row in ordered
    ]  # fmt: skip
    return doc.Html(f'<div class="whole-words">{doc.table(columns, cells, below=[remark(row) for row in ordered])}</div>')


def _said(verdict: str) -> str:
    """A verdict in the words of a gap's own page; as it stands where it is none of the contract."""
    return VERDICTS.get(verdict, (verdict,))[0]


def _effect(row: Row) -> doc.Html:
    """What acts; a name may break after its component."""
    return doc.Html(doc.text(" + ".join(filter(None, (row.effect, row.also))) or "–").replace(".", ".<wbr>"))


def _size(row: Row) -> str:
    return "–" if row.size is None else plus_minus(row.size, row.size_std, row.unit)


def _gap(row: Row) -> str:
    if row.gap_before is None:
        return "–"
    return f"{row.gap_before:.2f}" + (f" → {row.gap_after:.2f}" if row.gap_after is not None else "")


def _begin(row: Row) -> doc.Html:
    return doc.Html(f'<span class="nowrap">{doc.text(row.begin.replace("T", " ").removesuffix("Z"))}</span>')


def _number(value: float | None, form: str) -> str:
    return "–" if value is None else format(value, form)
