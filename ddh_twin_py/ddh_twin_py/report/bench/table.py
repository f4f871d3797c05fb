"""The table of a sealed bench for a page in Markdown, between two marks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ddh_twin_py.report.bench.page import aim, shown
from ddh_twin_py.rig.files import write_whole

BEGIN, END = "<!-- gap-bench: begin -->", "<!-- gap-bench: end -->"


class TableError(ValueError):
    """A page that has no place for the table; one line for people."""


def gap_bench_table(summary: Mapping) -> str:
    """Bounds and what was measured, as lines of Markdown."""
    scores = summary["all"]["scores"]
    lines = ["| of the sealed cases | aim | measured (95 % interval), number |", "|---|---|---|"]
    lines += [f"| {row['words']} | {aim(row)} | {shown(row['metric'], row['score'], row['bound'])} |" for row in summary["aims"]]
    lines += [f"| {summary['metrics'][name]} | | {shown(name, scores[name])} |" for name in ("seconds", "megabytes")]
    return "\n".join(lines)


def write_table(summary: Mapping, page: Path) -> None:
    """Put the table between the marks of a page.

    Raises:
        TableError: there is no such page, or no marks in it.
    """
    before, after = place_of(page)
    write_whole(page, f"{before}{BEGIN}\n{gap_bench_table(summary)}\n{END}{after}")


def place_of(page: Path) -> tuple[str, str]:
    """What stands before and after the table of a page.

    Raises:
        TableError: there is no such page, or no marks in it.
    """
    try:
        text = page.read_text("utf-8")
    except OSError as error:
        raise TableError(f"{page}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise TableError(f"{page}: is no text in UTF-8") from None
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise TableError(f"{page}: no place for the table, it goes between the lines {BEGIN} and {END}")
    return before, after
