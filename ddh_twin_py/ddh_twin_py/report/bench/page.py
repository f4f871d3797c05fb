"""The report of a sealed bench: scores with intervals, reliability, confusion, every case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.document import Html

SHARES = ("right", "detected", "false_alarm", "first", "third", "component", "both", "unknown_found", "unknown_component",
          "false_unknown", "coverage")
"""Metrics that are shares."""
_SIDE, _EDGE = 320, 44
_FEW = 20  # cases, below which an interval that holds the bound says neither yes nor no
_NOTHING = "–"


def shown(name: str, estimate: Mapping, bound: float | None = None) -> str:
    """A score with its interval and the number of cases: shares in per cent; '–' where no case says anything.

    Args:
        bound: to be reached; a share that whole per cents would not tell from it has a decimal.
    """
    said = _with_interval(name, estimate, bound)
    return said if said == _NOTHING else f"{said}, {estimate['n']}"


def _with_interval(name: str, estimate: Mapping, bound: float | None = None) -> str:
    """The same without the number of cases."""
    if estimate["n"] == 0 or estimate["value"] is None:
        return _NOTHING
    if name in SHARES:
        value, low, high = (100 * estimate[k] for k in ("value", "low", "high"))
        close = bound is not None and round(value) == round(100 * bound) and estimate["value"] != bound
        return f"{value:.{int(close)}f} % ({low:.0f}–{high:.0f})"
    digits = 0 if name == "megabytes" else 1 if name == "seconds" else 2
    return f"{estimate['value']:.{digits}f} ({estimate['low']:.{digits}f}–{estimate['high']:.{digits}f})"


def aim(row: Mapping) -> str:
    """A bound that is to be reached."""
    return f"at {'most' if row['most'] else 'least'} {100 * row['bound']:.0f} %"


def verdict(summary: Mapping) -> str:
    """How it came out, in one sentence."""
    scores = summary["all"]["scores"]
    crashed = len(summary["crashed"])
    told = _told(summary)
    aims = f"; {sum(told)} of {len(told)} aims {'is' if sum(told) == 1 else 'are'} met" if told else ""
    right = scores["right"]
    return (f"Of {right['n']} sealed cases {_with_interval('right', right)} are answered rightly"
            f"{_also('true effect first in', 'first', scores)}"
            f"{_also('false alarms in', 'false_alarm', scores)}{aims}" + (f"; {crashed} crashed" if crashed else "") + ".")


def _also(words: str, name: str, scores: Mapping) -> str:
    """A further share of so many, nothing where no case tells."""
    if not scores[name]["n"]:
        return ""
    return f"; {words} {_with_interval(name, scores[name])} of {scores[name]['n']}"


def gap_bench_end(folder: str) -> doc.EndMatter:
    """What the numbers rest on."""
    return doc.EndMatter(
        "Cases were made and their truth was hashed before any diagnosis; nothing was fitted to them.", "reference sheet",
        ["The plant shares the data sheet with the twin and none of its equations.",
         "Shares have Wilson's 95 % intervals, means and medians bootstrap ones; the last number is that of cases.",
         "A class of at most three effects that contains the true one counts as it. A crashed case is a wrong one."],
        [("Folder", folder)])


def gap_bench_document(summary: Mapping, folder: str) -> doc.Document:
    """The page of `gap_bench.scoring.summary`."""
    document = doc.Document(
        "Gap bench", "Sealed proof of the gap diagnosis", verdict(summary), gap_bench_end(folder), _level(summary),
    )
    document.add("Aims", _aims(summary["aims"]))
    suites = {row["suite"]: [other for other in summary["suites"] if other["suite"] == row["suite"]] for row in summary["suites"]}
    document.add("Scores", _scores([summary["all"], *summary["by_commissioning"]], summary["metrics"], "Overall", "suite"),
                 *(_scores(rows, summary["metrics"], f"Suite {suite}, by level", "level") for suite, rows in suites.items()))
    document.add("Reliability", reliability_figure(summary["reliability"]), _reliability_table(summary["reliability"]))
    document.add("Confusion", _confusion(summary["confusion"]))
    if summary["crashed"]:
        document.add("Crashed", doc.table([doc.Column("case", number=False), doc.Column("why", number=False)],
                                          [(row["name"], row["why"]) for row in summary["crashed"]]))
    document.add("Cases", doc.details(f"All {summary['cases']} cases", _cases(summary["answers"])))
    return document


def _aims(rows: Sequence[Mapping]) -> Html:
    columns = [doc.Column("of the sealed cases", number=False), doc.Column("aim"), doc.Column("measured", "95 %, number"),
               doc.Column("reached", number=False)]
    body = [(row["words"].replace("`", ""), aim(row), shown(row["metric"], row["score"], row["bound"]), reached(row)) for row in rows]
    return doc.table(columns, body)


def reached(row: Mapping) -> Html | str:
    """Whether a bound is reached, as a mark with words; too few cases say neither."""
    if row["score"]["value"] is None:
        return _NOTHING
    met = _met(row)
    return doc.mark("none", "too few cases") if met is None else doc.mark("good", "yes") if met else doc.mark("poor", "no")


def _met(row: Mapping) -> bool | None:
    """Whether a bound is reached; None where too few cases tell, or none."""
    score, bound = row["score"], row["bound"]
    value = score["value"]
    if value is None or (score["n"] < _FEW and score["low"] < bound < score["high"]):
        return None
    return value <= bound if row["most"] else value >= bound


def _told(summary: Mapping) -> list[bool]:
    """Of the aims of which enough cases tell, which are met."""
    return [met for met in map(_met, summary["aims"]) if met is not None]


def _level(summary: Mapping) -> str:
    """good where all aims that cases tell of are met, fair where half of them are."""
    told = _told(summary)
    return "good" if told and all(told) else "fair" if told and 2 * sum(told) >= len(told) else "poor"


def _scores(rows: Sequence[Mapping], metrics: Mapping[str, str], caption: str, by: str) -> Html:
    """A column for each row of a summary, headed by its suite or its level, without scores of which none of them tells."""
    columns = [doc.Column("score", number=False)]
    columns += [doc.Column(row[by], f"{row['cases']} cases") for row in rows]
    body = [[words, *(shown(name, row["scores"][name]) for row in rows)] for name, words in metrics.items()]
    body = [cells for cells in body if set(cells[1:]) != {_NOTHING}]
    return Html(f'<div class="whole-words">{doc.table(columns, body, caption)}</div>')


def reliability_figure(rows: Sequence[Mapping]) -> Html:
    """Stated probability against the share that was right, with 95 % intervals, as inline SVG."""
    def x(value: float) -> float:
        return _EDGE + _SIDE * value

    def y(value: float) -> float:
        return 10 + _SIDE * (1.0 - value)

    parts = [f'<rect x="{x(0)}" y="{y(1)}" width="{_SIDE}" height="{_SIDE}" fill="none" style="stroke:currentColor" opacity=".4"/>',
             f'<path d="M{x(0)} {y(0)}L{x(1)} {y(1)}" stroke="currentColor" stroke-dasharray="4 4" opacity=".5"/>']
    for k in range(0, 11, 2):
        parts.append(f'<text x="{x(k / 10)}" y="{y(0) + 16}" text-anchor="middle" class="axis">{k / 10:g}</text>')
        parts.append(f'<text x="{x(0) - 6}" y="{y(k / 10) + 4}" text-anchor="end" class="axis">{k / 10:g}</text>')
    for row in rows:
        right = row["right"]
        if not right["n"]:
            continue
        at = x(row["stated"])
        parts.append(
            f'<g><title>stated {row["stated"]:.2f}, right {right["value"]:.2f} of {right["n"]}</title>'
            f'<path d="M{at:.1f} {y(right["low"]):.1f}V{y(right["high"]):.1f}" stroke="var(--s-c1)" stroke-width="2"/>'
            f'<circle cx="{at:.1f}" cy="{y(right["value"]):.1f}" r="4.5" fill="var(--s-c1)"/></g>')
    parts.append(f'<text x="{x(0.5)}" y="{y(0) + 34}" text-anchor="middle" class="axis">stated probability</text>')
    parts.append(f'<text x="12" y="{y(0.5)}" text-anchor="middle" class="axis" transform="rotate(-90 12 {y(0.5)})">share right</text>')
    said = "Stated probability of every named cause, and of no gap, against how often it was right; on the line it is calibrated."
    size = f'width="{_SIDE + _EDGE + 12}" height="{_SIDE + 52}"'
    return Html(f'<div class="map"><p class="caption">{said}</p><svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 '
                f'{_SIDE + _EDGE + 12} {_SIDE + 52}" {size} role="img" aria-label="{said}">{"".join(parts)}</svg></div>')


def _reliability_table(rows: Sequence[Mapping]) -> Html:
    columns = [doc.Column("stated"), doc.Column("mean stated"), doc.Column("right", "95 %, causes named and no gap")]
    return doc.table(columns, [
        (f"{row['from']:.1f}–{row['to']:.1f}", f"{row['stated']:.2f}", shown("right", row["right"])) for row in rows if row["right"]["n"]
    ])


def _confusion(rows: Sequence[Mapping]) -> Html:
    said: dict[str, list[tuple[str, int]]] = {}
    for row in rows:
        said.setdefault(row["true"], []).append((row["said"], row["cases"]))
    body = []
    for true, answers in said.items():
        others = sorted(((s, n) for s, n in answers if s != true), key=lambda pair: (-pair[1], pair[0]))
        right = sum(n for s, n in answers if s == true)
        body.append((true, right + sum(n for _, n in others), right, ", ".join(f"{s} {n}" for s, n in others)))
    columns = [doc.Column("true", number=False), doc.Column("cases"), doc.Column("said so"), doc.Column("said instead", number=False)]
    return doc.table(columns, body)


def _cases(answers: Sequence[Mapping]) -> Html:
    columns = [doc.Column("case", number=False), doc.Column("suite", number=False), doc.Column("level", number=False),
               doc.Column("true", number=False), doc.Column("verdict", number=False), doc.Column("leading cause", number=False),
               doc.Column("right", number=False), doc.Column("seconds"), doc.Column("MB")]
    return doc.table(columns, [
        (a["name"], a["suite"], a["level"], ", ".join(a["true"]) or a["expected"], a["verdict"] or "crashed", a["named"],
         doc.mark("good", "yes") if a["right"] else doc.mark("poor", "no"),
         "–" if a["seconds"] is None else f"{a['seconds']:.1f}", "–" if a["megabytes"] is None else f"{a['megabytes']:.0f}")
        for a in answers
    ])
