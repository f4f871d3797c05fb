"""The design of a test for a terminal of 80 columns; the same numbers as its page."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from ddh_twin_py.gap.design import Design
from ddh_twin_py.gap.detection import SIZES
from ddh_twin_py.report.gap_design_words import nearest, setting, smallest, verdict
from ddh_twin_py.report.summary import STYLE, plain_table
from ddh_twin_py.report.units import number

_MARK = {True: ("yes", "good"), False: ("no", "poor"), None: ("–", "")}


def print_design(design: Design, console: Console | None = None) -> None:
    """Print the verdict, every effect, classes."""
    console = console or Console()
    said, level = verdict(design)
    console.print(Text(said, style=f"bold {STYLE[level]}"))
    console.print(setting(design), highlight=False)
    table = plain_table("effect", "smallest detected", *(f"{rise:g}" for rise in SIZES.values()), "told")
    for d in design.detections:
        near = nearest(design, d.effect)
        told = "–" if near is None else number(near[1], 1)
        marks = [Text(_MARK[d.detects(size)][0], style=STYLE.get(_MARK[d.detects(size)][1], "")) for size in SIZES]
        table.add_row(d.effect, smallest(d, short=True), *marks, told)
    table.caption, table.caption_justify = (
        "2.2, 5, 11: would it be detected where the worst signal rises to so many times\nits noise (faint, moderate, clear); – lies beyond "
        "what the effect may be, or no sensor shows it.\ntold: least expected log Bayes factor against another effect; 3 is "
        "needed.", "left")
    console.print(table)
    for members in design.classes:
        console.print("not told apart: " + ", ".join(members), highlight=False)
