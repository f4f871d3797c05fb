"""The short summary of a calibration for a terminal; the same numbers as its report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.text import Text

from ddh_twin_py.report.calibration.groups import SignalFit, grouped, unfitted
from ddh_twin_py.report.replay.agreement import level
from ddh_twin_py.report.replay.summary import STYLE, plain_table
from ddh_twin_py.report.units import in_file, number, words

if TYPE_CHECKING:
    from ddh_twin_py.estimation.fitting.calibration import Calibration

_MOST_PAIRS = 12


def print_calibration(fit: Calibration, signals: Sequence[SignalFit], said: str, console: Console) -> None:
    """Print signals, parameters by group, pairs of which only a combination is informed, and the verdict.

    The verdict comes first where the fit does not describe the machine.
    """
    if failed := unfitted(signals):
        console.print(said, style=STYLE["poor"], highlight=False)
    held = any(s.held_out is not None for s in signals)
    table = plain_table("signal", "as given", "fitted", *(["held out"] if held else []))
    for s in signals:
        judged = [s.after, *([s.held_out] if held else [])]
        marks = (Text("–") if value is None else Text(number(value, 2), style=STYLE[level(value)]) for value in judged)
        table.add_row(words(s.name), number(s.before, 2), *marks)
    table.caption, table.caption_justify = "RMS of the free run over the noise of one sample", "left"
    console.print(table)
    groups = grouped(fit)
    for group in ("informed", "partly informed"):
        if not groups[group]:
            continue
        table = plain_table(group, "value ± σ", "moved", "left")
        table.columns[1].justify, table.columns[1].no_wrap = "left", False  # where it is narrow the unit goes below
        for p in groups[group]:
            unit = "" if p.unit == "1" else f" {p.unit}"
            table.add_row(p.name, in_file(p.value, p.std) + unit, number(p.moved, 1), f"{100 * p.share:.0f} %")
        table.caption, table.caption_justify = "moved: in σ of the prior; left: share of the prior's σ", "left"
        console.print(table)
    for group in ("stays at prior", "refused"):
        if groups[group]:
            console.print(f"{group} ({len(groups[group])}): " + ", ".join(p.name for p in groups[group]), highlight=False)
    pairs = fit.together()
    for a, b, r in pairs[:_MOST_PAIRS]:
        console.print(f"only together: {a} and {b} (correlation {r:+.3f})", highlight=False)
    if len(pairs) > _MOST_PAIRS:
        console.print(f"and {len(pairs) - _MOST_PAIRS} further pairs, see the report")
    if not failed:
        console.print(said, highlight=False)
