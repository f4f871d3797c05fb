"""A layout of Foxglove and Lichtblick (JSON): the same charts, health and the running test of a gap."""

from __future__ import annotations

import json

from ddh_twin_py.exchange.layouts.views import TABS, Line, Plot


def path(namespace: str, line: Line) -> str:
    """The message path of a field."""
    entry = '.{}[:]{{{}=="{}"}}'.format(*line.where) if line.where else ""
    return f"{namespace}/{line.topic}{entry}.{line.field}"


def layout(namespace: str) -> str:
    """The layout's file; `namespace` with a leading slash, '' for the root."""
    panels: dict[str, object] = {}
    tabs = []
    for tab in TABS:
        names = [_plot(panels, namespace, tab.title, plot) for plot in tab.plots]
        tabs.append({"title": tab.title, "layout": _stacked(names)})
    panels["StateTransitions!gap"] = {
        "paths": [{"value": f"{namespace}/gap/status.opened", "label": "gap open", "timestampMethod": "headerStamp"}], "isSynced": True,
    }
    panels["RawMessages!gap"] = {"topicPath": f"{namespace}/gap/status", "diffEnabled": False}
    tabs.append({"title": "Gap", "layout": _stacked(["StateTransitions!gap", "RawMessages!gap"])})
    panels["Tab!views"] = {"activeTabIdx": 0, "tabs": tabs}
    panels["DiagnosticSummary!health"] = {
        "minLevel": 0, "pinnedIds": [], "hardwareIdFilter": "", "topicToRender": "/diagnostics", "sortByLevel": True,
    }
    return json.dumps({
        "configById": panels, "globalVariables": {}, "userNodes": {}, "playbackConfig": {"speed": 1},
        "layout": {"direction": "row", "first": "Tab!views", "second": "DiagnosticSummary!health", "splitPercentage": 75},
    }, indent=1) + "\n"


def _plot(panels: dict[str, object], namespace: str, tab: str, plot: Plot) -> str:
    words = f"{tab} {plot.title.split(' [')[0]}".lower().split()
    name = "Plot!" + "_".join("".join(filter(str.isalnum, word)) for word in words)
    panels[name] = {
        "title": plot.title,
        "paths": [
            {"value": path(namespace, line), "label": line.label, "color": line.colour, "enabled": True, "timestampMethod": "headerStamp"}
            for line in plot.lines
        ],
        "showXAxisLabels": True, "showYAxisLabels": True, "showLegend": True, "legendDisplay": "floating", "isSynced": True,
        "showPlotValuesInLegend": True, "xAxisVal": "timestamp", "followingViewWidth": 60, "sidebarDimension": 240,
    }
    return name


def _stacked(names: list[str]) -> object:
    """Panels below each other, all of one height."""
    if len(names) == 1:
        return names[0]
    return {"direction": "column", "first": names[0], "second": _stacked(names[1:]), "splitPercentage": 100 / len(names)}
