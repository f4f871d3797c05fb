"""Parameter file, pages and launch file say what the code says."""

import argparse
import importlib
import json
import re
import signal
import sys
import types
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest
import rclpy
import yaml
from ddh_twin_py.bags.qos import SENSOR_DATA
from ddh_twin_py.bags.writer import BagWriter
from ddh_twin_py.cli import up
from ddh_twin_py.cli.twin_nodes import TWIN
from ddh_twin_py.nodes.parameter_file import PARAMETERS, AsRos, ParameterFileError, check_files, read_parameter_file, unanswered


@pytest.fixture(scope="module")
def config(repo_root):
    return yaml.safe_load((repo_root / "ddh_twin_py" / "config" / "twin.yaml").read_text())


@pytest.mark.parametrize("node", PARAMETERS)
def test_the_parameter_file_holds_all_defaults(node, config):
    written = config[f"/**/{node}"]["ros__parameters"]
    declared = {p.name: list(p.default) if isinstance(p.default, tuple) else p.default for p in PARAMETERS[node]}
    assert written == declared
    assert {name: type(value) for name, value in written.items()} == {name: type(value) for name, value in declared.items()}


def asked_to_start(text, folder, *given):
    """What `up` is asked for, with a parameter file that holds this text."""
    (folder / "twin.yaml").write_text(text)
    arguments = argparse.ArgumentParser()
    up.add_parser(arguments.add_subparsers())
    return arguments.parse_args(["up", "--params", str(folder / "twin.yaml"), *given])


def refused(text, folder):
    """What is said of a parameter file that holds this text, by `up` with nearly all nodes, before a node is started."""
    with pytest.raises(ParameterFileError) as error:
        up.run(asked_to_start(text, folder, "--view", "--source", "simulation", "--duty", "mixed", "--record", str(folder / "new")))
    said = str(error.value)
    assert said.startswith(f"{folder / 'twin.yaml'}: ") and "\n" not in said
    return said


@pytest.mark.parametrize(("text", "words"), [
    ("/**/gap_monitor: [\n", ["is not YAML (line 1): a bracket is not closed"]),
    ("", ["is empty; a parameter file is a mapping of nodes with ros__parameters"]),
    ("- a\n", ["holds a list; a parameter file is a mapping"]),
    ("/**/gap_monitor:\n", ["/**/gap_monitor: holds nothing, a node's name with ros__parameters is needed"]),
    ("/**/gap_monitor: {ros__parameters: {bin: }}\n", ["bin is nothing, it must be of type double"]),
    ("/**/gap_monitor: {ros__parameters: &a {bin: 20.0}}\n/**/web_view: {ros__parameters: *a}\n", ["line 2", "alias, which ROS does not"]),
    ("interval: 0.05\n", ["interval: holds 0.05, a node's name with ros__parameters is needed"]),
    ("/**/gap_monitor: {ros_parameters: {bin: 20.0}}\n", ["/**/gap_monitor: no section 'ros_parameters'"]),
    ("/**: {rosparameters: 1}\n", ["/**: no section 'rosparameters'"]),
    ("/**/gap_monitor: {ros__parameters: }\n", ["/**/gap_monitor: ros__parameters holds nothing"]),
    ("/**/gap_monitor: {ros__parameters: {bins: 20.0}}\n", ["/**/gap_monitor: no parameter 'bins'", "nearest is 'bin'"]),
    ("/**/gap_monitor: {ros__parameters: {bin: 0.5}}\n", ["/**/gap_monitor: bin is 0.5, it must be of type double and 1 to 3600"]),
    ("/**/gap_monitor: {ros__parameters: {bin: 20}}\n", ["bin is 20, it must be of type double", "write 20.0"]),
    ("/**/gap_monitor: {ros__parameters: {bin: '20.0'}}\n", ["bin is '20.0', it must be of type double"]),
    ("/**/gap_monitor: {ros__parameters: {bin: '2e1'}}\n", ["bin is '2e1', it must be of type double and 1 to 3600"]),
    ("/**/gap_monitor: {ros__parameters: {bin: 1_0.5}}\n", ["bin is '1_0.5', it must be of type double"]),
    ("/**/web_view: {ros__parameters: {port: 2:20}}\n", ["port is '2:20', it must be of type integer"]),
    ("/**/gap_monitor: {ros__parameters: {bin: .nan}}\n", ["bin is nan"]),
    ("ros__parameters: {bin: 20.0}\n", ["ros__parameters stands below no node; valid are hydraulic_model", "**"]),
    ("/**/gap_monitor: {ros__parameters: {diagnosis_command: ddh}}\n", ["diagnosis_command is 'ddh', it must be of type string array"]),
    ("/**/gap_monitor: {ros__parameters: {bin: 20.0, bin: 30.0}}\n", ["bin: given twice"]),
    ("/ddh/bag_recorder: {ros__parameters: {log_time: now}}\n", ["log_time is 'now'", "one of 'arrival', 'stamp'"]),
    ("/**/drive_telemetry: {ros__parameters: {simulation: {sed: 1}}}\n", ["no parameter 'simulation.sed'", "nearest is 'simulation.seed'"]),
    ("/**: {ros__parameters: {interval: 5.0}}\n", ["/**: interval is 5.0"]),
    ("/**: {ros__parameters: {intervall: 0.05}}\n", ["/**: no parameter 'intervall'"]),
])
def test_a_parameter_file_that_cannot_be_used_is_refused_before_a_node_starts(text, words, tmp_path):
    said = refused(text, tmp_path)
    assert all(word in said for word in words), said


@pytest.mark.parametrize(("text", "said"), [
    ("/other/gap_monitor: {ros__parameters: {bin: 0.5}}\n", "/other/gap_monitor: bin is 0.5, it must be of type double and 1 to 3600"),
    ("/other/gap_monitor: {ros__parameters: {bins: 20.0}}\n", "/other/gap_monitor: no parameter 'bins'"),
    ("/other/gap_moniter: {ros__parameters: {bin: 20.0}}\n", "/other/gap_moniter: no node 'gap_moniter' is the twin's; the nearest"),
    ("/ddh: {gap_moniter: {ros__parameters: {bin: 20.0}}}\n",
     "/ddh/gap_moniter: no node 'gap_moniter' is the twin's; the nearest is 'gap_monitor'; no node that is started takes it"),
    ("/**/my_own_node: {ros__parameters: {gain: 1.0}}\n/**: {ros__parameters: {interval: 0.05}}\n",
     "/**/my_own_node: no node 'my_own_node' is the twin's; no node that is started takes it\n"),
    ("/camera: {ros__parameters: {exposure: 3}}\n", "/camera: no node 'camera'"),
    ("/**/web_view: {ros__parameters: {port: 'many'}}\n", "/**/web_view: port is 'many', it must be of type integer"),
    ("/**: {ros__parameters: {port: 'many'}}\n", "/**: port is 'many', it must be of type integer"),
    ("/ddh/*: {ros__parameters: {loop: 3}}\n", "/ddh/*: loop is 3, it must be of type bool"),
])
def test_what_only_other_nodes_would_take_is_told_and_stops_nothing(text, said, tmp_path, capsys):
    up.check(asked_to_start(text, tmp_path))
    assert f"ddh-twin up: warning: {tmp_path / 'twin.yaml'}: {said}" in "".join(capsys.readouterr())


@pytest.mark.parametrize("text", ["/other/gap_monitor: {ros__parameters: {bin: }}\n", "/camera: {ros__parameters: {modes: [1, fast]}}\n"])
def test_what_ros_does_not_read_stops_all_nodes(text, tmp_path):
    assert text.partition(":")[0] in refused(text, tmp_path)


def test_a_parameter_file_that_nodes_take_is_taken(repo_root, tmp_path):
    read_parameter_file(repo_root / "ddh_twin_py" / "config" / "twin.yaml")
    (tmp_path / "own.yaml").write_text(
        "/**: {ros__parameters: {use_sim_time: true, interval: 5e-2}}\n"
        "rig_7:\n  drive_telemetry: {ros__parameters: {simulation: {seed: 3}, qos_overrides: {/rosout: {publisher: {depth: 9}}}}}\n"
        "bag_player: {ros__parameters: {topics: [drive/*, rig], rate: 1e1}}\n"
    )
    sections = read_parameter_file(tmp_path / "own.yaml")
    assert sections["/**"] == {"use_sim_time": True, "interval": 0.05} and sections["bag_player"]["rate"] == 10.0
    assert list(sections["rig_7/drive_telemetry"]) == ["simulation.seed", "qos_overrides./rosout.publisher.depth"]


@pytest.mark.parametrize(("section", "said"), [
    ("/**: {ros__parameters: {rig: FOLDER/crane_2.yaml}}",
     "/**: rig: FOLDER/crane_2.yaml: no such rig file; the nearest is FOLDER/crane_1.yaml"),
    ("/**/hydraulic_model: {ros__parameters: {rig: FOLDER/twin.yaml}}", "/**/hydraulic_model: rig: FOLDER/twin.yaml: /**/hydraulic_model:"),
    ("/ddh/temperature_fusion: {ros__parameters: {state_file: FOLDER}}", "/ddh/temperature_fusion: state_file: FOLDER is a folder; name"),
    ("/**/gap_monitor: {ros__parameters: {normal_file: /dev/full}}", "/**/gap_monitor: normal_file: /dev/full is a character device; name"),
])
def test_a_file_that_a_parameter_file_names_is_looked_at_before_a_node_starts(section, said, tmp_path):
    (tmp_path / "crane_1.yaml").write_text("rig_id: crane_1\n")
    told = refused(section.replace("FOLDER", str(tmp_path)), tmp_path)
    assert told.startswith(f"{tmp_path}/twin.yaml: {said.replace('FOLDER', str(tmp_path))}")


@pytest.mark.parametrize("section", [
    "/other/hydraulic_model: {ros__parameters: {rig: nowhere.yaml}}",
    "/**/drive_telemetry: {ros__parameters: {simulation: {rig: nowhere.yaml}}}",
    "/**: {ros__parameters: {rig: ''}}", "/**/temperature_fusion: {ros__parameters: {state_file: nowhere.npz}}",
])
def test_files_of_nodes_that_are_not_started_and_those_that_are_made_are_not_asked_for(section, tmp_path):
    (tmp_path / "own.yaml").write_text(section)
    check_files(tmp_path / "own.yaml", read_parameter_file(tmp_path / "own.yaml"), "/ddh", dict.fromkeys(TWIN, {}))


def test_a_rig_file_that_an_argument_replaces_is_not_asked_for(tmp_path):
    (tmp_path / "own.yaml").write_text("/**: {ros__parameters: {rig: nowhere.yaml}}")
    sections = read_parameter_file(tmp_path / "own.yaml")
    check_files(tmp_path / "own.yaml", sections, "/ddh", dict.fromkeys(TWIN, {"rig": "crane_1.yaml"}))
    with pytest.raises(ParameterFileError, match="nowhere.yaml: no such rig file"):
        check_files(tmp_path / "own.yaml", sections, "/ddh", dict.fromkeys(TWIN, {}))


def test_a_parameter_file_is_read_as_ros_reads_it(tmp_path):
    """Against the parser of ROS itself."""
    given = ["1e1", "'1e1'", "10.0", '"10.0"', "1E+3", ".5", "10.", "-1e-2", "1_000", "1:30", "010", "0x10", "0o10", "0b1", "2026-01-01",
             "inf", "yes", "Off", "y", "'y'", "7", "+7", "1e1f", "text", "1.5.2", "99999999999999999999", "08"]
    file = tmp_path / "values.yaml"
    file.write_text("/**:\n  ros__parameters:\n" + "".join(f"    v{k}: {text}\n" for k, text in enumerate(given)))
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(file)], context=context)
    node = rclpy.create_node("reader", context=context, automatically_declare_parameters_from_overrides=True)
    try:
        read = [node.get_parameter(f"v{k}").value for k in range(len(given))]
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
    ours = yaml.load(file.read_text(), AsRos)["/**"]["ros__parameters"]
    ours = [ours[f"v{k}"] for k in range(len(given))]
    assert [(text, type(value), value) for text, value in zip(given, ours, strict=True)] == \
        [(text, type(value), value) for text, value in zip(given, read, strict=True)]


@pytest.mark.parametrize(("section", "namespace", "taken"), [
    ("temperature_fusion", "/ddh", False), ("/**/temperature_fusion", "/ddh", True), ("/**", "/ddh", True), ("/*", "/ddh", False),
    ("/ddh/*", "/ddh", True), ("/crane/temperature_fusion", "/ddh", False), ("/crane/temperature_fusion", "/crane", True),
    ("/**/temperature_fusion", "/site/crane", True), ("/*/*", "/ddh", True), ("/*/*", "/site/crane", False),
    ("temperature_fusion", "/", True), ("'*'", "/ddh", False),
])  # fmt: skip
def test_a_section_that_no_node_takes_is_named(section, namespace, taken, tmp_path):
    (tmp_path / "own.yaml").write_text(f"{section}: {{ros__parameters: {{use_sim_time: true}}}}\n")
    assert unanswered(read_parameter_file(tmp_path / "own.yaml"), namespace) == ([] if taken else [section.strip("'")])


@pytest.mark.parametrize("node", PARAMETERS)
def test_the_page_names_every_parameter_with_its_default(node, repo_root):
    page = (repo_root / "docs" / "nodes" / f"{node}.md").read_text()
    rows = {cells[0].strip(" `"): [cell.strip(" `") for cell in cells[1:]] for cells in table_rows(page) if len(cells) >= 3}
    for parameter in PARAMETERS[node]:
        assert parameter.name in rows, f"{node}.md lacks {parameter.name}"
        assert rows[parameter.name][0] == shown(parameter.default), parameter.name
        assert rows[parameter.name][-1].startswith(parameter.description), parameter.name
    for heading in ("## Topics", "## Parameters", "## Failure modes"):
        assert heading in page


def table_rows(page):
    return [line.strip("|").split("|") for line in page.splitlines() if line.startswith("| `")]


def shown(default):
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, tuple):
        return "[" + ", ".join(f'"{entry}"' for entry in default) + "]"
    return f'"{default}"' if isinstance(default, str) else repr(default)


@pytest.mark.parametrize("node", PARAMETERS)
def test_every_parameter_is_described(node):
    for parameter in PARAMETERS[node]:
        assert len(parameter.description) > 10
        assert parameter.description.endswith("."), parameter.name


# --- launch file, with what `launch` and `launch_ros` would be ---------------------------------


@pytest.fixture
def launch_file(repo_root, monkeypatch):
    """The module of twin.launch.py over stand-ins that keep what they are given."""

    def kept(name):
        return lambda *args, **kwargs: SimpleNamespace(kind=name, args=args, **kwargs)

    for module, names in {
        "launch": ["LaunchDescription"],
        "launch.actions": [
            "DeclareLaunchArgument", "OpaqueFunction", "RegisterEventHandler", "SetEnvironmentVariable", "Shutdown", "TimerAction",
        ],
        "launch.event_handlers": ["OnProcessExit", "OnProcessIO"],
        "launch_ros": [],
        "launch_ros.actions": ["Node"],
    }.items():
        made = types.ModuleType(module)
        for name in names:
            setattr(made, name, kept(name))
        monkeypatch.setitem(sys.modules, module, made)
    substitutions = types.ModuleType("launch.substitutions")
    substitutions.LaunchConfiguration = lambda name: SimpleNamespace(perform=lambda context: context[name])
    monkeypatch.setitem(sys.modules, "launch.substitutions", substitutions)
    spec = importlib.util.spec_from_file_location("twin_launch", repo_root / "ddh_twin_py" / "launch" / "twin.launch.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_launch_file_has_the_arguments_of_up(launch_file):
    entities = launch_file.generate_launch_description().args[0]
    declared = {e.args[0]: e for e in entities if e.kind == "DeclareLaunchArgument"}
    wanted = {action.dest for action in launch_file.parser()._actions} - {"help", "json"}
    assert set(declared) == wanted
    assert {"source", "bag", "duty", "rig", "namespace", "record", "rate", "params", "state_file", "normal_file", "log"} <= wanted
    assert declared["source"].choices == list(up.SOURCES)
    assert all(e.description for e in declared.values())


def started(launch_file, **given):
    defaults = {name: default for name, default, *_ in launch_file.options()}
    return [a for a in launch_file.nodes({**defaults, **given}) if a.kind == "Node"]


def test_the_launch_file_starts_what_up_starts(launch_file, paper_cycle_bag, tmp_path):
    nodes = started(launch_file, source="bag", bag=str(paper_cycle_bag), rate="0", record=str(tmp_path / "out"), namespace="rig_b")
    arguments = launch_file.parser().parse_args(
        ["--source=bag", f"--bag={paper_cycle_bag}", "--rate=0", f"--record={tmp_path / 'out'}", "--namespace=rig_b"]
    )
    assert {n.executable: n.parameters[-1] for n in nodes} == up.node_parameters(arguments)
    assert {n.namespace for n in nodes} == {"/rig_b"}
    assert {n.executable for n in nodes if not n.respawn} == {"bag_player"}
    assert {n.respawn_delay for n in nodes} == {launch_file.RESPAWN_DELAY}


def test_the_lines_of_the_readme_start_the_same(launch_file, repo_root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("crane_1.yaml").write_text("rig_id: crane_1\n")
    lines = [line.split() for line in (repo_root / "README.md").read_text("utf-8").splitlines()]
    (by_up,) = [line[2:] for line in lines if line[:2] == ["ddh-twin", "up"] and "--rig" in line]
    (launch,) = [line[4:] for line in lines if line[:2] == ["ros2", "launch"]]
    (one,) = [line[3:] for line in lines if line[:2] == ["ros2", "run"]]
    arguments = launch_file.parser().parse_args(by_up)
    nodes = started(launch_file, **dict(word.split(":=") for word in launch))
    assert {n.executable: n.parameters[-1] for n in nodes} == up.node_parameters(arguments)
    assert {n.namespace for n in nodes} == {arguments.namespace} and f"__ns:={arguments.namespace}" in one
    given = dict(value.split(":=") for option, value in pairwise(one) if option == "-p")
    assert given == up.node_parameters(arguments)[one[0]]


def test_a_played_bag_is_a_reference_for_the_normal_levels_and_a_machine_is_not(launch_file, paper_cycle_bag):
    for given, whole in (([], False), (["--source=bag", f"--bag={paper_cycle_bag}"], True)):
        monitor = up.node_parameters(launch_file.parser().parse_args(["--normal-file=levels.json", *given]))["gap_monitor"]
        assert (monitor["normal_file"], monitor["learn_until_end"]) == ("levels.json", whole)
    assert "normal_file" not in up.node_parameters(launch_file.parser().parse_args([]))["gap_monitor"]


def test_normal_levels_that_were_not_written_are_told_at_the_end(launch_file, paper_cycle_bag, tmp_path, monkeypatch):
    class Ended:
        said = []

        def __init__(self, children, line, environment):
            self.ask_to_stop = signal.SIG_DFL

        def say(self, text):
            self.said.append(text)

        def run(self):
            return 0

    monkeypatch.setattr(up, "Supervisor", Ended)
    levels = tmp_path / "levels.json"

    def ended(*given):
        parser = argparse.ArgumentParser()
        up.add_parser(parser.add_subparsers())
        Ended.said.clear()
        return up.run(parser.parse_args(["up", "--quiet", *map(str, given)])), Ended.said[1:]

    code, said = ended("--source", "bag", "--bag", paper_cycle_bag, "--normal-file", levels)
    assert code == 1 and len(said) == 1 and f"{levels} was not written" in said[0] and str(paper_cycle_bag) in said[0]
    ended("--normal-file", levels, "--log", tmp_path / "log", "--state-file", tmp_path / "state", "--json", tmp_path / "ran.json")
    files = json.loads((tmp_path / "ran.json").read_text())["files"]
    assert files == {"log": str(tmp_path / "log"), "record": None, "state_file": None, "normal_file": None, "records": []}
    assert ended("--normal-file", levels) == (0, [])  # a machine may be stopped before it has shown enough
    levels.touch()
    assert ended("--source", "bag", "--bag", paper_cycle_bag, "--normal-file", levels) == (0, [])


@pytest.mark.parametrize(("ended", "restarts", "code"), [(0, 0, 0), (1, 0, 1), (-signal.SIGTERM, 0, 0), (None, 0, 1), (0, 1, 1)])
def test_a_recording_that_is_not_whole_is_said_and_counts(ended, restarts, code, monkeypatch, tmp_path):
    class Ended:
        said = []

        def __init__(self, children, line, environment):
            self.children, self.ask_to_stop = children, signal.SIG_DFL

        def say(self, text):
            self.said.append(text)

        def run(self):
            for child in self.children:
                child.process = SimpleNamespace(returncode=0)
                if child.name == "bag_recorder":  # crashed and not yet started again where it has no process
                    child.process, child.restarts = None if ended is None else SimpleNamespace(returncode=ended), restarts
            return 0

    monkeypatch.setattr(up, "Supervisor", Ended)
    parser = argparse.ArgumentParser()
    up.add_parser(parser.add_subparsers())
    assert up.run(parser.parse_args(["up", "--quiet", "--record", str(tmp_path / "bag")])) == code
    assert [text for text in Ended.said if "not all was recorded" in text and str(tmp_path / "bag") in text] == Ended.said[1:]
    assert len(Ended.said) == 1 + code


def test_of_a_bag_telemetry_and_rig_are_played_unless_the_file_names_other_topics(launch_file, paper_cycle_bag, tmp_path):
    def topics(bag, *given):
        arguments = launch_file.parser().parse_args(["--source=bag", f"--bag={bag}", "--namespace=a", *given])
        return up.node_parameters(arguments)["bag_player"].get("topics")

    played = topics(paper_cycle_bag)
    assert {"rig", "drive/telemetry", "temperature/tank_oil"} <= set(played) and "temperature/estimates" not in played
    assert not any(pattern.startswith(("hydraulics/s", "motor/", "gap/")) or "*" in pattern for pattern in played)
    (tmp_path / "twin.yaml").write_text("/**/bag_player: {ros__parameters: {topics: ['*']}}\n")
    assert topics(paper_cycle_bag, f"--params={tmp_path / 'twin.yaml'}") is None
    (tmp_path / "other.yaml").write_text("/b/bag_player: {ros__parameters: {topics: ['*']}}\n")
    assert topics(paper_cycle_bag, f"--params={tmp_path / 'other.yaml'}") == played
    (tmp_path / "root.yaml").write_text("bag_player: {ros__parameters: {topics: ['*']}}\n")
    assert topics(paper_cycle_bag, f"--params={tmp_path / 'root.yaml'}", "--namespace=/") is None
    with BagWriter(tmp_path / "other") as writer:
        writer.write_raw("/tf", "std_msgs/msg/Empty", SENSOR_DATA, 0, bytes(8))
    assert topics(tmp_path / "other") == ["*"]


def test_the_live_page_is_an_option_and_no_player_waits_for_it(launch_file, paper_cycle_bag):
    nodes = up.node_parameters(launch_file.parser().parse_args(["--view", "--source=bag", f"--bag={paper_cycle_bag}"]))
    assert nodes["web_view"] == {} and "web_view" not in nodes["bag_player"]["wait_for_nodes"]
    assert "web_view" in [n.executable for n in started(launch_file, view="true")]
    assert "web_view" not in [n.executable for n in started(launch_file)]


def test_flags_and_plain_start_of_the_launch_file(launch_file):
    assert [n.executable for n in started(launch_file)] == list(TWIN)
    assert {n.output for n in started(launch_file, quiet="true")} == {"log"}
    assert {n.output for n in started(launch_file, quiet="false")} == {"screen"}


def test_a_node_that_cannot_use_what_it_was_given_stops_the_launch_and_one_that_was_killed_does_not(launch_file):
    defaults = {name: default for name, default, *_ in launch_file.options()}
    actions = launch_file.nodes(defaults)
    handled = {a.args[0].target_action.executable: a.args[0].on_exit for a in actions if a.kind == "RegisterEventHandler"}
    assert set(handled) == set(TWIN)
    (stop,) = handled["hydraulic_model"](SimpleNamespace(returncode=2, process_name="hydraulic_model-1"), None)
    assert stop.kind == "Shutdown" and "hydraulic_model-1 cannot use what it was given" in stop.reason
    assert handled["hydraulic_model"](SimpleNamespace(returncode=-9, process_name="hydraulic_model-1"), None) == []


def test_a_source_that_failed_stops_the_launch_and_says_so(launch_file):
    failed = launch_file.end(SimpleNamespace(returncode=2, process_name="bag_player-5"), None)
    assert re.search("bag_player-5 ended with exit code 2", failed[0].reason)
    ended = launch_file.end(SimpleNamespace(returncode=0, process_name="bag_player-5"), None)
    assert ended[0].kind == "TimerAction"
