"""`ddh-twin doctor`: what is wrong with installation, middleware, clocks, or a running machine."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import add_json, add_quiet, add_verb, between, namespace

_EXAMPLE = "  ddh-twin doctor --seconds 10 --json out/doctor.json"
_STYLE = {"ok": ("✓", "green"), "note": ("·", "cyan"), "warning": ("!", "yellow"), "error": ("✗", "red")}


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "doctor", "check installation, middleware, clocks and a running machine, and say what to do",
        "Looks at Python, packages, messages and clock, lets two processes talk through the middleware, then listens to the graph:\n"
        "are the machine's topics there, of the right type, often enough, stamped by one clock, in the right unit; do the nodes of\n"
        "the twin run, and what do they say of themselves. Leaves with 1 where something does not work (error), 0 otherwise.",
        _EXAMPLE,
    )
    parser.add_argument("--namespace", metavar="NS", help="of the machine (default: every one that publishes telemetry)")
    parser.add_argument("--seconds", metavar="S", type=between(1.0, 3600.0, "s"), default=5.0,
                        help="how long the graph is listened to, 1 to 3600 s (default 5)")
    parser.add_argument("--machine", action="store_true", help="a machine must be there: none is an error")
    parser.add_argument("--no-graph", action="store_true", help="leave middleware and machine out")
    add_json(parser, "write every check as JSON; - is standard output")
    add_quiet(parser, "no progress, and no more than what is wrong")


def run(args: argparse.Namespace) -> int:
    """Look, tell, leave with 1 where something does not work."""
    from ddh_twin_py.cli.console import put_json
    from ddh_twin_py.doctor.check import as_json, worst
    from ddh_twin_py.doctor.clock import check_clock
    from ddh_twin_py.doctor.installation import check_installation

    asked = None if args.namespace is None else namespace(args.namespace)
    checks = [*check_installation(), *check_clock()]
    if not args.no_graph:
        checks += _graph(args, asked)
    if args.json:
        put_json(args.json, as_json(checks))
    if args.json != "-":
        _show(checks, args.quiet)
    return 1 if worst(checks) == "error" else 0


def _graph(args: argparse.Namespace, asked: str | None) -> list:
    from ddh_twin_py.bags.topics import normalised
    from ddh_twin_py.cli.console import stage
    from ddh_twin_py.doctor.check import Check
    from ddh_twin_py.doctor.machine import check_machine, machines
    from ddh_twin_py.doctor.middleware import check_middleware
    from ddh_twin_py.doctor.twin import check_twin
    from ddh_twin_py.rig import load_rig
    from ddh_twin_py.telemetry.units.unit_scales import UnitScales

    try:
        from ddh_twin_py.nodes.graph_survey import survey
    except ImportError as error:
        return [Check("middleware", "rclpy", "error", f"cannot be loaded: {error}", "loads",
                      "run .venv/bin/ddh-twin, or source the ROS 2 workspace; --no-graph leaves this out")]
    try:
        with stage(f"listening for {args.seconds:g} s", args.quiet) as progress:
            heard = survey(args.seconds, progress)
    except RuntimeError as error:
        return [Check("middleware", "start", "error", " ".join(str(error).split()), "starts",
                      "look at RMW_IMPLEMENTATION, ROS_DOMAIN_ID and the Fast DDS profile")]
    checks = check_middleware(heard)
    namespaces = [normalised(asked)] if asked is not None else machines(heard)
    if not namespaces:
        advice = ("start the machine's software, or set ROS_DOMAIN_ID as there; to try it without a machine: "
                  "ddh-twin up --source simulation --duty mixed")
        return [*checks, Check("machine", "telemetry", "error" if args.machine else "note",
                               f"nobody publishes drive/telemetry in domain {heard.domain}", "a machine", advice)]
    rig = load_rig()
    noise, scales = {name: spec.noise for name, spec in rig.sensors.items()}, UnitScales.of(rig)
    for name in namespaces:
        checks += [*check_machine(heard, name, noise, scales), *check_twin(heard, name)]
    return checks


def _show(checks: list, quiet: bool) -> None:
    from rich.text import Text

    from ddh_twin_py.cli.console import output

    console, group = output(), ""
    for check in checks:
        if quiet and check.level in ("ok", "note"):
            continue
        if check.group != group:
            group = check.group
            console.print(Text(group, style="bold"))
        sign, style = _STYLE[check.level]
        right = f" (right: {check.right})" if check.right and check.level != "ok" else ""
        console.print(Text.assemble("  ", (sign, style), f" {check.name}: ", (check.found, style), right), soft_wrap=True)
        if check.advice:
            console.print(Text(f"      → {check.advice}"), soft_wrap=True)
    counts = {level: sum(check.level == level for check in checks) for level in _STYLE}
    if not quiet:
        console.print(", ".join(f"{count} {level}" for level, count in counts.items() if count))
