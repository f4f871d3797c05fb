"""One self-contained HTML page from sections; the look that all reports share."""

from __future__ import annotations

import itertools
import json
import platform
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from html import escape
from importlib import metadata, resources
from pathlib import Path

from ddh_twin_py.rig.files import finite, write_whole

_PACKAGES = ("numpy", "numba", "rosbags")
_ON_A_PAGE = 30
"""Bars that surely fit on one printed page."""


class Html(str):
    """Text that is markup already."""


def text(value: object) -> Html:
    """The value as markup; escaped unless it is markup already."""
    return value if isinstance(value, Html) else Html(escape(str(value)))


@dataclass(frozen=True)
class Column:
    """A column of a table: heading, what stands below it in small print, and whether it holds numbers."""

    title: str
    unit: str = ""
    number: bool = True


@dataclass(frozen=True)
class Figure:
    """One key figure: what it is, value with unit, what to hold it against, and in a second line what it leaves open."""

    label: str
    value: str
    note: str = ""
    reservation: str = ""


@dataclass(frozen=True)
class EndMatter:
    """What a reader needs to judge the numbers.

    `data_split` says what was fitted to which data and what was held back; `rows` are further
    pairs of name and value.
    """

    data_split: str
    rig_file: str
    assumptions: Sequence[str]
    rows: Sequence[tuple[str, str]] = ()

    def as_json(self) -> dict:
        """The same for a report's machine-readable twin, with the versions."""
        return {
            "data_split": self.data_split, "rig_file": self.rig_file, "assumptions": list(self.assumptions), "versions": dict(versions()),
            **({"further": dict(self.rows)} if self.rows else {}),
        }


@dataclass
class Document:
    """A report: what it is about, one sentence that says how it came out, sections, end matter."""

    kind: str
    title: str
    verdict: str
    end: EndMatter
    level: str = "good"  # good, fair or poor: the colour beside the verdict
    sections: list[tuple[str, Html]] = field(default_factory=list)

    def add(self, heading: str, *blocks: str) -> None:
        """Append a section of blocks, which are markup; nothing where all are empty."""
        body = Html("".join(blocks))
        if body:
            self.sections.append((heading, body))

    def html(self) -> str:
        """The page: no file, address or font outside of it is ever asked for."""
        sections = "".join(
            f'<section id="s{n}"><h2>{text(heading)}</h2>{body}</section>'
            for n, (heading, body) in enumerate((*self.sections, ("About these numbers", end_matter(self.end))), 1)
        )
        has_charts = "<figure" in sections
        scripts = f"<script>{_asset('language.js')}</script><script>{_asset('uplot/uPlot.iife.min.js')}</script>" if has_charts else ""
        styles = (_asset("uplot/uPlot.min.css") if has_charts else "") + _asset("style.css")
        reset = '<button id="all" type="button">Show all</button>' if has_charts else ""
        hint = (
            '<p class="hint screen">Charts move together. <span class="mouse">Drag to zoom, shift and drag to pan, '
            "double click for all; by keyboard arrows, + − 0. Click a legend entry to hide its line.</span>"
            '<span class="touch">Pinch to zoom, drag sideways to pan, tap a legend entry to hide its line.</span></p>'
            if has_charts else ""
        )
        return (
            '<!doctype html>\n<html lang="en" data-theme="light"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; style-src \'unsafe-inline\'; '
            "script-src 'unsafe-inline'; img-src data:\">"
            f'<meta name="generator" content="ddh-twin {version()}">'
            f"<title>{text(self.title)} – {text(self.kind)}</title><style>{styles}</style>"
            "<script>if(matchMedia('(prefers-color-scheme: dark)').matches)"
            "document.documentElement.dataset.theme='dark'</script></head><body>"
            f'<header><div><p class="kind">{text(self.kind)}</p><h1>{text(self.title)}</h1></div>'
            f'<nav class="screen">{reset}<button id="theme" type="button">Light / dark</button></nav></header><main>'
            f'<p class="verdict {self.level}">{text(self.verdict)}</p>'
            "<noscript><p class=\"note\">Charts need JavaScript; every number is in the tables.</p></noscript>"
            f"{hint}{sections}</main>{scripts}<script>{_asset('charts.js')}</script></body></html>\n"
        )

    def write(self, path: str | Path) -> Path:
        """Write the page, making its folder where needed."""
        return write_text(path, self.html())


def paragraph(words: str) -> Html:
    """A paragraph."""
    return Html(f"<p>{text(words)}</p>")


def note(words: str) -> Html:
    """A paragraph in small print."""
    return Html(f'<p class="note">{text(words)}</p>')


def figures(several: Iterable[Figure]) -> Html:
    """A row of key figures."""
    cards = "".join(
        f"<div><dt>{text(f.label)}</dt><dd>{text(f.value)}"
        + "".join(f"<small>{text(line)}</small>" for line in (f.note, f.reservation) if line)
        + "</dd></div>"
        for f in several
    )
    return Html(f'<dl class="figures">{cards}</dl>')


def table(columns: Sequence[Column], rows: Iterable[Sequence[object]], caption: str = "", below: Sequence[str] = (),
          stacks: bool = False) -> Html:
    """A table; the first cell of a row names it.

    Args:
        below: for each row what stands below it across the table, '' for nothing; empty where no row has any.
        stacks: whether on a narrow screen the cells of a row stand one below the other, each with its column's title: of many words.
    """
    head = "".join(
        f'<th scope="col"{_numeric(c)}>{text(c.title)}' + (f"<small>{text(c.unit)}</small>" if c.unit else "") + "</th>"
        for c in columns
    )
    body, titles = "", [f' data-title="{text(column.title)}"' if stacks else "" for column in columns]
    for row, words in itertools.zip_longest(rows, below, fillvalue=""):
        cells, told = list(zip(columns, row, strict=True)), ' class="told"' if words else ""
        body += f'<tr{told}><th scope="row"{_numeric(cells[0][0])}>{text(cells[0][1])}</th>'
        body += "".join(f"<td{_numeric(column)}{titled}>{text(cell)}</td>"
                        for (column, cell), titled in zip(cells[1:], titles[1:], strict=True)) + "</tr>"
        body += f'<tr class="below"><td colspan="{len(columns)}"><span>{text(words)}</span></td></tr>' if words else ""
    title = f"<caption><span>{text(caption)}</span></caption>" if caption else ""
    return Html(
        f'<div class="scroll{" stacks" if stacks else ""}" tabindex="0"><table>{title}<thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def details(summary: str, *blocks: str) -> Html:
    """Blocks that are folded away on screen and open in print."""
    return Html(f"<details><summary>{text(summary)}</summary>{''.join(blocks)}</details>")


def mark(level: str, words: str) -> Html:
    """Words with a sign that says good, fair or poor by shape and colour."""
    sign = {"good": "●", "fair": "◆", "poor": "▲", "none": "–"}[level]
    return Html(f'<span class="mark {level}"><span aria-hidden="true">{sign}</span> {text(words)}</span>')


def bars(rows: Sequence[tuple[str, Sequence[tuple[str, float]]]], unit: str, digits: int = 1) -> Html:
    """Horizontal bars: for each name, pairs of role (`charts.ROLES`) and value, all on one scale from zero."""
    largest = max((abs(v) for _, pairs in rows for _, v in pairs), default=0.0) or 1.0
    body = ""
    for name, pairs in rows:
        lines = "".join(
            f'<div class="bar"><i style="width:calc((100% - 5.5em) * {abs(v) / largest:.4f});'
            f'background:var(--s-{role})"></i><span>{v:.{digits}f} {text(unit)}</span></div>'
            for role, v in pairs
        )
        body += f"<dt>{text(name)}</dt><dd>{lines}</dd>"
    kind = "bars" if len(rows) <= _ON_A_PAGE else "bars long"  # long ones go on over the page when printed
    return Html(f'<dl class="{kind}">{body}</dl>')


def legend(entries: Iterable[tuple[str, str]]) -> Html:
    """Pairs of role and label."""
    items = "".join(f'<li><i style="background:var(--s-{role})"></i>{text(label)}</li>' for role, label in entries)
    return Html(f'<ul class="legend">{items}</ul>')


def end_matter(end: EndMatter) -> Html:
    """Data split, rig file, further rows, assumptions, versions."""
    rows = [("Data split", end.data_split), ("Rig file", end.rig_file), *end.rows]
    rows.append(("Versions", ", ".join(f"{name} {number}" for name, number in versions().items())))
    pairs = "".join(f"<dt>{text(name)}</dt><dd>{text(value)}</dd>" for name, value in rows)
    assumed = "".join(f"<li>{text(a)}</li>" for a in end.assumptions)
    return Html(f'<dl class="about">{pairs}<dt>Assumptions</dt><dd><ul>{assumed}</ul></dd></dl>')


@cache
def version() -> str:
    """Version of this project, with the commit where it runs from a checkout."""
    try:
        number = metadata.version("ddh_twin_py")
    except metadata.PackageNotFoundError:
        number = "unknown"
    package = Path(__file__).resolve().parents[2]
    top, commit = package.parents[1], ""
    if top / "ddh_twin_py" / "ddh_twin_py" == package and (top / ".git").exists():  # a checkout of ours, not one that encloses a .venv
        try:
            commit = subprocess.run(
                ["git", "-C", str(top), "describe", "--always", "--dirty", "--exclude=*"],
                capture_output=True, text=True, timeout=5, check=True,
            ).stdout.strip()
        except (OSError, subprocess.SubprocessError):
            pass
    return f"{number}+{commit}" if commit else number


@cache
def versions() -> Mapping[str, str]:
    """What the numbers were made with: name to version."""
    found = {"ddh_twin_py": version(), "python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def write_text(path: str | Path, content: str) -> Path:
    """Write a file whole or not at all, making its folder where needed."""
    return write_whole(path, content)


def write_json(path: str | Path, data: Mapping) -> Path:
    """Write the machine-readable twin of a report; NaN becomes null."""
    return write_text(path, json_text(data) + "\n")


def json_text(data: object) -> str:
    """JSON with NaN and infinity as null."""
    return json.dumps(finite(data), indent=1, ensure_ascii=False, allow_nan=False)


def _numeric(column: Column) -> str:
    return ' class="n"' if column.number else ""


@cache
def _asset(name: str) -> str:
    content = resources.files("ddh_twin_py.report").joinpath("assets", *name.split("/")).read_text("utf-8")
    if name.endswith(".js") and "</script" in content:
        raise ValueError(f"{name} holds '</script' and cannot stand inline")
    return content
