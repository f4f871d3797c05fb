"""The short summary of a replay for a terminal; the same numbers as the report."""

from __future__ import annotations

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from ddh_twin_py.report.replay.agreement import Agreement, level, signal_row
from ddh_twin_py.report.units import ZERO_CELSIUS, in_unit, number, words

STYLE = {"good": "green", "fair": "yellow", "poor": "red"}
"""Colour of a level."""


def summary(agreement: Agreement, title: str) -> Group:
    """Verdict, temperatures (measured, predicted, fused), signals; fits in 40 lines of 80 columns."""
    parts: list[object] = [Text(title, style="bold"), Text(agreement.verdict)]
    if agreement.temperatures:
        parts.append(_temperatures(agreement))
    if agreement.signals:
        parts.append(_signals(agreement))
    return Group(*parts)


def print_summary(agreement: Agreement, title: str, console: Console) -> None:
    """Print the summary."""
    console.print(summary(agreement, title), soft_wrap=False)


def plain_table(*columns: str) -> Table:
    """A table without frame; the first column is text, the others are numbers."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, padding=(0, 1, 0, 0))
    table.add_column(columns[0], no_wrap=True)
    for column in columns[1:]:
        table.add_column(column, justify="right", no_wrap=True)
    return table


def _temperatures(agreement: Agreement) -> Table:
    left_out = any(t.rms_left_out is not None for t in agreement.temperatures)
    table = plain_table("temperature", "measured", "predicted", "fused ± σ", "RMS\npredicted", "RMS\nfused",
                   *(("RMS\nleft out",) if left_out else ()))
    for t in agreement.temperatures:
        table.add_row(
            words(t.sensor), number(t.measured - ZERO_CELSIUS, 2), number(t.predicted - ZERO_CELSIUS, 2),
            f"{number(t.fused - ZERO_CELSIUS, 2)} ± {number(t.fused_std, 2)}",
            Text(number(t.rms_predicted, 2), style=STYLE[level(t.predicted_in_noise)]), number(t.rms_fused, 2),
            *((number(t.rms_left_out, 2),) if left_out else ()),
        )
    table.caption = "degC at the last reading; RMS in K against the sensor" + (
        "; left out: sensor not used" if left_out else "")
    table.caption_justify = "left"
    return table


def _signals(agreement: Agreement) -> Table:
    table = plain_table("signal", "RMS free run", "× noise", "RMS soft sensor", "× noise")
    for s in agreement.signals:
        soft = ("input", "") if s.rms_soft is None else (in_unit(s.rms_soft, s.unit), number(s.soft_in_noise, 2))
        table.add_row(
            signal_row(s.name), in_unit(s.rms_free, s.unit),
            Text(number(s.free_in_noise, 2), style=STYLE[level(s.free_in_noise)]), *soft,
        )
    return table
