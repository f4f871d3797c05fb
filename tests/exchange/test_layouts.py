"""Every line of a layout is a field of a topic that the twin has; every column one that a table has."""

import json
import re
from xml.etree import ElementTree as xml

import pytest
import yaml
from ddh_twin_py.bags.message_types import know
from ddh_twin_py.cli.main import main
from ddh_twin_py.exchange.layouts.aggregator import analyzers
from ddh_twin_py.exchange.layouts.files import layout_files
from ddh_twin_py.exchange.layouts.foxglove import path
from ddh_twin_py.exchange.layouts.plotjuggler import series
from ddh_twin_py.exchange.layouts.views import TABS, TYPES, table_tabs
from ddh_twin_py.exchange.output_bag import write_output_bag
from ddh_twin_py.exchange.replay_columns import replay_columns
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.telemetry.signals import TEMPERATURE_SENSORS
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

LINES = [line for tab in TABS for plot in tab.plots for line in plot.lines]


def field_kind(message_type: str, field: str) -> object:
    """Type of a field, None where there is none; a dot leads into a nested message or the messages of an array."""
    fields = dict(know(message_type).fielddefs[message_type][1])
    first, _, rest = field.partition(".")
    kind = fields.get(first)
    if kind is None or not rest:
        return kind
    content = kind[1]
    return field_kind(content if isinstance(content, str) else content[0][1], rest)


@pytest.mark.parametrize("line", LINES, ids=lambda line: f"{line.topic}.{line.field}")
def test_every_line_is_a_number_of_a_message(line):
    field = f"{line.where[0]}.{line.field}" if line.where else line.field
    assert field_kind(TYPES[line.topic], field)[1] == ("float64", 0)
    if line.where:
        assert field_kind(TYPES[line.topic], f"{line.where[0]}.{line.where[1]}")[1] == ("string", 0)


def test_topics_and_types_are_those_of_the_documents(repo_root):
    text = (repo_root / "docs/topics.md").read_text()
    rows = dict(re.findall(r"^\| `([^`]+)` \| `([^`]+)`", text, re.MULTILINE))
    for topic, message_type in TYPES.items():
        first, name = topic.split("/") if "/" in topic else ("", topic)
        general = {("estimate", True): "estimate/<location>", ("temperature", True): "temperature/<sensor>"}.get(
            (first, name in NODES or name in TEMPERATURE_SENSORS), topic)
        assert rows[general] == message_type.replace("/msg/", "/"), topic


def test_an_exported_bag_has_what_the_charts_show(replayed, short_bag, tmp_path):
    write_output_bag(tmp_path / "out", short_bag, replayed)
    with AnyReader([tmp_path / "out"], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        there = {connection.topic: connection.msgtype for connection in reader.connections}
        estimates = next(reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages() if c.topic == "/ddh/temperature/estimates")
    recorded = ("Motion and pressure", "Drive", "Temperatures")
    shown = {line.topic for tab in TABS if tab.title in recorded for plot in tab.plots for line in plot.lines}
    assert {f"/ddh/{topic}": TYPES[topic] for topic in shown}.items() <= there.items()
    for line in LINES:
        if line.where and line.where[0] == "estimates":
            assert estimates.estimates[line.index].location == line.where[2]


def test_columns_of_the_table_layout_are_those_of_the_export(replayed):
    headings = {column.heading for column in replay_columns(replayed)}
    root = xml.fromstring(layout_files("/ddh")["plotjuggler_table.xml"])
    shown = {curve.get("name") for curve in root.iter("curve")}
    assert shown <= headings and len(shown) == len({name for _, plots in table_tabs() for plot in plots for name, _ in plot.columns})


def test_plotjuggler():
    root = xml.fromstring(layout_files("/crane_1")["plotjuggler_live.xml"])
    assert [curve.get("name") for curve in root.iter("curve")] == [series("/crane_1", line) for line in LINES]
    assert "/crane_1/temperature/estimates/estimates[21]/predicted" in {curve.get("name") for curve in root.iter("curve")}
    (topics,) = root.iter("selected_topics")
    assert set(topics.get("value").split(";")) == {f"/crane_1/{line.topic}" for line in LINES}
    for splitter in root.iter("DockSplitter"):
        assert int(splitter.get("count")) == len(splitter) == len(splitter.get("sizes").split(";"))


def test_foxglove():
    data = json.loads(layout_files("")["foxglove.json"])
    panels = data["configById"]
    paths = [line["value"] for name, panel in panels.items() if name.startswith("Plot!") for line in panel["paths"]]
    assert paths == [path("", line) for line in LINES]
    assert '/temperature/estimates.estimates[:]{location=="tank_oil"}.predicted' in paths

    def used(node):
        return {node} if isinstance(node, str) else used(node["first"]) | used(node["second"])

    inside = {name for tab in panels["Tab!views"]["tabs"] for name in used(tab["layout"])}
    assert inside | used(data["layout"]) == panels.keys()


def test_the_tree_has_one_place_per_component():
    tree = analyzers("/crane_1")["analyzers"]["ros__parameters"]
    assert tree["path"] == "DDH crane_1" and set(tree) == {"path", "machine", "limits", "gap", "twin"}
    assert "crane_1/temperature_fusion: temperature/tank_oil" in tree["machine"]["analyzers"]["temperature_tank_oil"]["startswith"]
    assert analyzers("")["analyzers"]["ros__parameters"]["limits"]["startswith"] == ["temperature_fusion: limits"]


def test_installed_layouts_are_what_the_verb_writes(repo_root, tmp_path, capsys):
    assert main(["layouts", str(tmp_path / "new")]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 4
    installed = repo_root / "ddh_twin_py/config/layouts"
    for path_ in (tmp_path / "new").iterdir():
        assert path_.read_text() == (installed / path_.name).read_text(), f"run: ddh-twin layouts {installed}"
    assert yaml.safe_load((installed / "diagnostic_aggregator.yaml").read_text()) == analyzers("/ddh")
    (tmp_path / "file").write_text("")
    assert main(["layouts", str(tmp_path / "file")]) == 2
    assert "is no folder" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["metadata.yaml", "x.mcap", "x.db3", "x.mcap.zstd"])
def test_layouts_are_not_written_into_a_bag(name, tmp_path, capsys):
    (tmp_path / name).write_text("")
    assert main(["layouts", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"FOLDER: {tmp_path} is a recording, nothing is written into it" in line
    assert [path.name for path in tmp_path.iterdir()] == [name]
