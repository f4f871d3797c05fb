"""The design of a test for a terminal; the same numbers as its page, cut nowhere."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from ddh_twin_py.gap.drive.design import Design
from ddh_twin_py.gap.explain.classes import TELLS_APART
from ddh_twin_py.gap.explain.detection import SIZES
from ddh_twin_py.report.gap.design_words import log_odds, nearest, setting, smallest, verdict
from ddh_twin_py.report.replay.summary import STYLE, plain_table

_ENDLESS = 10_000  # columns
_MARK = {True: ("yes", "good"), False: ("no", "poor"), None: ("–", "")}


def print_design(design: Design, console: Console | None = None) -> None:
    """Print the verdict, every effect, classes."""
    console = console or Console()
    said, level = verdict(design)
    console.print(Text(said, style=f"bold {STYLE[level]}"))
    console.print(setting(design), highlight=False)
    table = _table(design, _ENDLESS)
    beside = _width(table, console) - max(len(d.effect) for d in design.detections)
    table = _table(design, console.width - beside)
    table.width = _width(table, console)  # where that is still more than the terminal has, it breaks the lines and loses nothing
    console.print(table, crop=False)
    for members in design.classes:
        console.print("not told apart: " + ", ".join(members), highlight=False)


def _width(table: Table, console: Console) -> int:
    """Columns in which nothing of a table is cut."""
    return console.measure(table, options=console.options.update(max_width=_ENDLESS)).maximum


def _table(design: Design, room: int) -> Table:
    """Every effect; names that are longer than ``room`` columns break after the component."""
    table = plain_table("effect", "smallest departure", *SIZES, "told")
    for d in design.detections:
        near = nearest(design, d)
        told = "–" if near is None else log_odds(near[1])
        marks = [Text(_MARK[d.detects(size)][0], style=STYLE.get(_MARK[d.detects(size)][1], "")) for size in SIZES]
        name = d.effect if len(d.effect) <= room else d.effect.replace(".", ".\n ", 1)
        table.add_row(name, smallest(d, short=True), *marks, told)
    table.caption, table.caption_justify = (
        f"{', '.join(SIZES)}: would it be detected where the worst signal rises to {', '.join(f'{rise:g}' for rise in SIZES.values())} "
        "times its noise; – lies beyond what the effect may be, or no sensor shows it.\n"
        "told: how surely it is told from the effect that it is taken for most easily, as "
        f"the log of the odds; from {TELLS_APART:g} on, odds of 20 to 1, the two count as told apart.", "left")
    return table
