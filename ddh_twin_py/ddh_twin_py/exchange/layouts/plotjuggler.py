"""Layouts of PlotJuggler 3 (XML): live topics or an MCAP bag, and a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.etree import ElementTree as xml

from ddh_twin_py.exchange.layouts.views import TABS, Line, table_tabs

_STREAMER = "ROS2 Topic Subscriber"


def series(namespace: str, line: Line) -> str:
    """The name that PlotJuggler gives to a field of a message."""
    array = f"{line.where[0]}[{line.index}]/" if line.where else ""
    return f"{namespace}/{line.topic}/{array}{line.field.replace('.', '/')}"


def live_layout(namespace: str) -> str:
    """For the topics of a running twin, or of a bag in MCAP; `namespace` with a leading slash, '' for the root."""
    tabs = [
        (tab.title, [(plot.title, [(series(namespace, line), line.colour) for line in plot.lines]) for plot in tab.plots]) for tab in TABS
    ]
    topics = sorted({f"{namespace}/{line.topic}" for tab in TABS for plot in tab.plots for line in plot.lines})
    root = _layout(tabs)
    streamer = xml.SubElement(root.find("Plugins"), "plugin", {"ID": _STREAMER})
    for name, value in (
        ("use_header_stamp", "true"), ("discard_large_arrays", "false"), ("max_array_size", "500"),
        ("boolean_strings_to_number", "true"), ("remove_suffix_from_strings", "true"), ("selected_topics", ";".join(topics)),
    ):
        xml.SubElement(streamer, name, {"value": value})
    xml.SubElement(root, "previouslyLoaded_Streamer", {"name": _STREAMER})
    return _text(root)


def table_layout(headings: Mapping[str, str]) -> str:
    """For a table of `ddh-twin export`; `headings`: name of a column to its heading in the file."""
    return _text(_layout([
        (title, [(plot.title, [(headings[name], colour) for name, colour in plot.columns]) for plot in plots])
        for title, plots in table_tabs()
    ]))


def _layout(tabs: Sequence[tuple[str, Sequence[tuple[str, Sequence[tuple[str, str]]]]]]) -> xml.Element:
    root = xml.Element("root")
    tabbed = xml.SubElement(root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"})
    for title, plots in tabs:
        container = xml.SubElement(xml.SubElement(tabbed, "Tab", {"tab_name": title, "containers": "1"}), "Container")
        share = ";".join([f"{1.0 / len(plots):.6f}"] * len(plots))
        splitter = xml.SubElement(container, "DockSplitter", {"orientation": "-", "sizes": share, "count": str(len(plots))})
        for name, lines in plots:
            plot = xml.SubElement(xml.SubElement(splitter, "DockArea", {"name": name}), "plot", {
                "mode": "TimeSeries", "style": "Lines", "flip_x": "false", "flip_y": "false"})
            xml.SubElement(plot, "range", {"left": "0.000000", "right": "10.000000", "bottom": "-0.100000", "top": "1.100000"})
            xml.SubElement(plot, "limitY")
            for series_name, colour in lines:
                xml.SubElement(plot, "curve", {"name": series_name, "color": colour})
    xml.SubElement(tabbed, "currentTabIndex", {"index": "0"})
    xml.SubElement(root, "use_relative_time_offset", {"enabled": "1"})
    for name in ("Plugins", "previouslyLoaded_Datafiles", "customMathEquations", "snippets"):
        xml.SubElement(root, name)
    return root


def _text(root: xml.Element) -> str:
    xml.indent(root, " ")
    return "<?xml version='1.0' encoding='UTF-8'?>\n" + xml.tostring(root, encoding="unicode") + "\n"
