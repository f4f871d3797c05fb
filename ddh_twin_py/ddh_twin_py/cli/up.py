"""`ddh-twin up`: the graph of nodes as processes with one log, kept running until it is stopped."""

from __future__ import annotations

import argparse
import itertools
import os
import signal
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from ddh_twin_py.bags.numbering import numbered
from ddh_twin_py.cli.arguments import (
    RATE,
    InputError,
    Parser,
    add_json,
    add_quiet,
    add_rig,
    add_verb,
    kept_file,
    named_file,
    namespace,
    new_folder,
    output_file,
    refuse_missing,
    seed,
)
from ddh_twin_py.cli.console import put_json, say
from ddh_twin_py.cli.parameter_yaml import parameter_yaml
from ddh_twin_py.cli.supervisor import Child, Supervisor, combined_log
from ddh_twin_py.cli.twin_nodes import FLUSH_AFTER, TWIN, played_topics
from ddh_twin_py.twin.duty_file import duty_file

__all__ = ["ENDING", "Parser", "add_parser", "check", "environment_additions", "node_parameters", "run"]

SOURCES = ("none", "bag", "simulation")
ENDING = ("bag_player", "drive_telemetry", "pressure_telemetry")
"""Nodes that may come to their end; with them the whole ends."""
_EXAMPLE = """\
  ddh-twin up                                          beside a machine that publishes its telemetry
  ddh-twin up --source bag --bag bags/paper_cycle --rate 0 --record out/live
  ddh-twin up --source simulation --duty mixed --namespace /rig_7 --state-file out/rig_7.state"""


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "up", "run the twin's nodes beside a machine, a bag or a simulated rig",
        "Starts the nodes as processes, restarts one that crashes (after 1, 2, 4 ... 30 s), and stops all of them on\n"
        "Ctrl-C, when the bag or the duty has come to its end, or when the player of a bag crashes, which would begin\n"
        "from the start. `ros2 launch ddh_twin_py twin.launch.py` does the same, with the same arguments, where ROS 2 is\n"
        "installed.",
        _EXAMPLE,
    )
    parser.add_argument(
        "--source", choices=SOURCES, default="none",
        help="where telemetry comes from: none (default; a machine publishes it), bag (played without loss), simulation",
    )
    parser.add_argument("--bag", metavar="BAG", type=named_file, help="bag to play, with --source bag: its telemetry and rig")
    parser.add_argument("--duty", metavar="FILE", type=named_file,
                        help="duty file, or the name of one of the project's, with --source simulation")
    parser.add_argument("--seed", type=seed, default=1, help="which rig is simulated (default 1)")
    parser.add_argument(
        "--rate", type=RATE, default=1.0,
        help="speed of the source against real time (default 1); 0 plays a bag as fast as the nodes take it",
    )
    parser.add_argument("--loop", action="store_true", help="begin again at the end of the bag or the duty")
    add_rig(parser)
    parser.add_argument("--namespace", metavar="NS", default="/ddh", help="of all topics and nodes (default /ddh)")
    parser.add_argument("--record", metavar="BAG", type=new_folder, help="record everything into this folder, which must not exist")
    parser.add_argument("--state-file", metavar="FILE", type=output_file, help="where the estimate survives a restart")
    parser.add_argument(
        "--normal-file", metavar="FILE", type=kept_file,
        help="normal levels of the running test of a gap: read where it exists, else written once learned",
    )
    parser.add_argument("--view", action="store_true", help="serve the live page, see ddh-twin view; where, says the log")
    parser.add_argument("--params", metavar="FILE", type=named_file, help="parameter file (YAML) for all nodes, see config/twin.yaml")
    parser.add_argument("--log", metavar="FILE", type=output_file, help="write the log of all nodes here too")
    add_json(parser, "when it ends, write what ran, how often it was started again, and where the files are; - is standard output")
    add_quiet(parser, "no log on the screen; warnings and errors stay")


def node_parameters(args: argparse.Namespace) -> dict[str, dict[str, object]]:
    """Which nodes run, and the parameters of each that follow from the arguments."""
    rig = {"rig": str(args.rig)} if args.rig else {}
    played = {"use_sim_time": True, "flush_after": FLUSH_AFTER} if args.source == "bag" else {}
    nodes: dict[str, dict[str, object]] = {name: {**rig, **played} for name in TWIN}
    if args.source == "bag":
        del nodes["gap_monitor"]["flush_after"]  # it holds nothing back
    if args.normal_file:
        nodes["gap_monitor"] |= {"normal_file": str(args.normal_file), "learn_until_end": args.source == "bag"}
    if args.state_file:
        nodes["temperature_fusion"]["state_file"] = str(args.state_file)
    if args.record:
        nodes["bag_recorder"] = {"bag": str(args.record), "if_exists": "number"}
        if args.source == "bag":
            nodes["bag_recorder"] |= {"use_sim_time": True, "log_time": "arrival" if args.loop else "stamp"}
    if args.view:
        nodes["web_view"] = dict(rig)
    if args.source == "bag":
        nodes["bag_player"] = {
            "bag": str(args.bag), "rate": args.rate, "loop": args.loop, "wait_for_nodes": [name for name in nodes if name != "web_view"],
        }  # fmt: skip
        if not _in_file(args, "bag_player", "topics"):
            nodes["bag_player"]["topics"] = played_topics(args.bag)
    if args.source == "simulation":
        simulated = {"source": "simulation", "rate": args.rate, "loop": args.loop}
        simulated |= {"simulation.duty": str(args.duty), "simulation.seed": args.seed}
        if args.rig:
            simulated["simulation.rig"] = str(args.rig)
        nodes |= {"drive_telemetry": dict(simulated), "pressure_telemetry": dict(simulated)}
    return nodes


def _in_file(args: argparse.Namespace, node: str, name: str) -> list[object]:
    """What the parameter file gives a node for this parameter; empty where it does not."""
    if not args.params:
        return []
    from ddh_twin_py.bags.topics import normalised
    from ddh_twin_py.nodes.parameter_file import given, read_parameter_file

    return given(read_parameter_file(args.params), f"{normalised(args.namespace)}/{node}", name)


def _ran(args: argparse.Namespace, children: Sequence[Child], code: int) -> dict:
    """What `--json` writes; of files those that are there."""
    files = {name: getattr(args, name) for name in ("log", "record", "state_file", "normal_file")}
    return {
        "namespace": args.namespace, "source": args.source, "ros_domain": int(os.environ.get("ROS_DOMAIN_ID") or 0), "exit_code": code,
        "nodes": [{"name": child.name, "restarts": child.restarts} for child in children],
        "files": {**{name: file if file and Path(file).exists() else None for name, file in files.items()},
                  "records": _recorded(args.record)},
    }  # fmt: skip


def _not_learned(args: argparse.Namespace) -> str:
    """That a whole bag was played and no normal levels came of it, '' where there is a file of them or none was asked for."""
    if args.source != "bag" or not args.normal_file or Path(args.normal_file).is_file():
        return ""
    return f"--normal-file: {args.normal_file} was not written; no level was learned from {args.bag}, or the folder cannot be written to"


def _not_whole(args: argparse.Namespace, children: Sequence[Child]) -> str:
    """That the recorder ended with an error, as where the disk was full, or before the end, '' where it did not."""
    for recorder in (child for child in children if child.name == "bag_recorder"):
        if recorder.restarts or recorder.process is None or (recorder.process.returncode or 0) > 0:
            return f"--record: not all was recorded into {args.record}, see the log"
    return ""


def _recorded(record: str | None) -> list[str]:
    """Every folder that was recorded into: a recorder that was started again goes on in the next one."""
    return [str(path) for path in itertools.takewhile(Path.exists, numbered(record))] if record else []


def command(node: str, parameters: Mapping[str, object], namespace: str, file: str | None) -> list[str]:
    """How one node is started; what the arguments say goes before the parameter file."""
    line = [*_executable(node), "--ros-args", "-r", f"__ns:={namespace}"]
    if file:
        line += ["--params-file", file]
    for name, value in parameters.items():
        line += ["-p", f"{name}:={parameter_yaml(value)}"]
    return line


def _executable(node: str) -> list[str]:
    """Where `ros2 run` finds it; else the module, by this Python."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        path = Path(prefix) / "lib" / "ddh_twin_py" / node
        if prefix and path.is_file():
            return [str(path)]
    return [sys.executable, "-c", f"import sys; from ddh_twin_py.nodes.{node} import main; sys.exit(main())"]


def check(args: argparse.Namespace) -> None:
    """What can be known to be wrong before anything is started; the namespace and the duty are put as nodes want them."""
    args.namespace = namespace(args.namespace)
    if args.source == "bag" and not args.bag:
        raise InputError("--source bag needs --bag BAG")
    if args.source == "simulation" and not args.duty:
        raise InputError("--source simulation needs --duty FILE")
    if args.source == "simulation" and not 0.01 <= args.rate <= 100.0:
        raise InputError(f"--rate is {args.rate:g}, a simulated rig runs at 0.01 to 100 times real time")
    if args.bag and args.source != "bag" or args.duty and args.source != "simulation":
        given, wanted = ("--bag", "bag") if args.bag and args.source != "bag" else ("--duty", "simulation")
        raise InputError(f"{given} was given, but --source is {args.source}; it needs --source {wanted}")
    for name in ("rig", "params", "bag"):
        given = getattr(args, name)
        if given:
            refuse_missing(f"--{name}", given)
    if args.rig:
        from ddh_twin_py.rig import load_rig

        load_rig(args.rig)  # or each node would refuse it by itself
    if args.bag:
        from ddh_twin_py.bags.folder import open_folder

        open_folder(args.bag)
    if args.params:
        from ddh_twin_py.nodes.parameter_file import check_files, check_values, of_other_nodes, read_parameter_file, unanswered

        sections, started = read_parameter_file(args.params), node_parameters(args)
        for section, said in of_other_nodes(sections).items():
            del sections[section]
            say(f"ddh-twin up: warning: {args.params}: {section}: {said}; no node that is started takes it")
        for said in check_values(args.params, sections, args.namespace, started):
            say(f"ddh-twin up: warning: {said}; no node that is started takes it")
        check_files(args.params, sections, args.namespace, started)
        for section in unanswered(sections, args.namespace):
            say(f"ddh-twin up: warning: {args.params}: {section}: no node in {args.namespace} takes it; /**/NODE is one in any namespace")
    if args.view:
        from ddh_twin_py.cli.page_port import refuse_taken
        from ddh_twin_py.web.access import LOCAL, PORT

        host, port = ([default, *_in_file(args, "web_view", name)][-1] for name, default in (("host", LOCAL), ("port", PORT)))
        refuse_taken(host, port, f"--view: port {port}", "end what is served there, or give web_view another port with --params")
    if args.duty:
        args.duty = duty_file(args.duty)
        refuse_missing("--duty", args.duty)
        from ddh_twin_py.twin.duty import load_duty

        load_duty(args.duty)


def environment_additions() -> dict[str, str]:
    """Variables that the nodes need and the user has not set: the profile for Fast DDS."""
    if os.environ.get("FASTRTPS_DEFAULT_PROFILES_FILE"):
        return {}
    folders = [Path(__file__).resolve().parents[2] / "config"]
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    folders += [Path(prefix) / "share" / "ddh_twin_py" / "config" for prefix in prefixes if prefix]
    for folder in folders:
        if (folder / "fastdds_profile.xml").is_file():
            return {"FASTRTPS_DEFAULT_PROFILES_FILE": str(folder / "fastdds_profile.xml")}
    return {}


def run(args: argparse.Namespace) -> int:
    """Start, keep and stop the graph."""
    check(args)
    nodes = node_parameters(args)
    children = [
        Child(
            name, command(name, parameters, args.namespace, args.params),
            source=name in ENDING, once=name == "bag_player", last=name == "bag_recorder",
        )
        for name, parameters in nodes.items()
    ]  # fmt: skip
    file = None
    if args.log:
        Path(args.log).parent.mkdir(parents=True, exist_ok=True)
        file = open(args.log, "a", encoding="utf-8")
    environment = {**os.environ, **environment_additions(), "PYTHONUNBUFFERED": "1", "RCUTILS_COLORIZED_OUTPUT": "0"}
    environment.setdefault("RCUTILS_CONSOLE_OUTPUT_FORMAT", "{severity} {message}")
    screen = None if args.quiet else sys.stderr if args.json == "-" else sys.stdout
    supervisor = Supervisor(children, combined_log(file, screen), environment)
    before = [(number, signal.signal(number, supervisor.ask_to_stop)) for number in (signal.SIGINT, signal.SIGTERM)]
    try:
        supervisor.say(f"starting {', '.join(nodes)} in {args.namespace}; Ctrl-C stops them")
        code = supervisor.run()
        for missed in filter(None, (_not_learned(args), _not_whole(args, children))):
            supervisor.say(missed)
            code = code or 1
        if args.json:
            put_json(args.json, _ran(args, children, code))
        return code
    finally:
        for number, handler in before:
            signal.signal(number, handler)
        if file is not None:
            file.close()
