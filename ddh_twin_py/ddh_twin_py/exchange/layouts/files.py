"""All layouts as files of one folder."""

from __future__ import annotations

from collections.abc import Iterable

from ddh_twin_py.exchange.layouts.aggregator import aggregator_yaml
from ddh_twin_py.exchange.layouts.foxglove import layout
from ddh_twin_py.exchange.layouts.plotjuggler import live_layout, table_layout
from ddh_twin_py.exchange.layouts.views import table_tabs
from ddh_twin_py.telemetry.signals import SIGNALS

_UNITS = {"temperature": "degC", "lower": "degC", "upper": "degC", "free_run": "degC"}


def layout_files(namespace: str) -> dict[str, str]:
    """Name of each file to its text; `namespace` with a leading slash, '' for the root."""
    columns = {name for _, plots in table_tabs() for plot in plots for name, _ in plot.columns}
    return {
        "plotjuggler_live.xml": live_layout(namespace),
        "plotjuggler_table.xml": table_layout(_headings(columns)),
        "foxglove.json": layout(namespace),
        "diagnostic_aggregator.yaml": aggregator_yaml(namespace),
    }


def _headings(columns: Iterable[str]) -> dict[str, str]:
    """Headings of columns as `replay_columns` names them."""
    units = {signal.name: signal.message_unit for signal in SIGNALS}
    found = {}
    for name in columns:
        first, last = name.rsplit("/", 1)
        found[name] = f"{name} [{units[first] if first in units else _UNITS[last]}]"
    return found
