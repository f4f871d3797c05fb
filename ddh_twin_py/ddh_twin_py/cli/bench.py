"""`ddh-twin bench`: how fast this machine runs the twin."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import add_quiet, add_verb, json_file

_EXAMPLE = "  ddh-twin bench --quick --json out/bench.json"


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "bench", "print speed and memory of replay and of the live graph",
        "Simulates an hour of 100 Hz telemetry, replays it in a process of its own, and plays a recording through the\n"
        "live nodes, times the free run and the Kalman filter beside other tools where these are installed, and diagnoses\n"
        "a recording of 30 minutes (--quick: of 5) with and without commissioning, which takes minutes.\n"
        "Each figure stands beside what it is held against; a ratio above 1 is better than that.",
        _EXAMPLE,
    )
    parser.add_argument(
        "--quick", action="store_true", help="10 minutes of telemetry instead of an hour, diagnoses of 5 minutes, live nodes briefly"
    )
    parser.add_argument("--no-live", action="store_true", help="leave the live nodes out")
    parser.add_argument(
        "--json", metavar="FILE", type=json_file, default="out/bench.json", help="where the rows go (default out/bench.json)"
    )
    add_quiet(parser, "no progress")


def run(args: argparse.Namespace) -> int:
    """Measure, print, write."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from ddh_twin_py.cli.benchmarks import LIVE_FAILED, measure
    from ddh_twin_py.cli.console import output, put_json, say

    figures, left_out, machine = measure(quick=args.quick, live=not args.no_live, quiet=args.quiet)
    rows = [figure.row() for figure in figures]
    put_json(args.json, rows)
    failed = [reason for reason in left_out if reason.startswith(LIVE_FAILED)]
    if args.json != "-":
        table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
        table.add_column("figure", overflow="fold")
        for column in ("value", "against", "ratio"):
            table.add_column(column, justify="right", no_wrap=True)
        table.add_column("of", overflow="fold")
        for figure in figures:
            table.add_row(*figure.cells())
        console = output()
        console.print(table)
        for reason in (reason for reason in left_out if reason not in failed):
            console.print(f"left out: {reason}", soft_wrap=True)
        console.print(f"{machine}; rows in {args.json}", soft_wrap=True)
    for reason in failed:
        say(f"ddh-twin bench: error: {reason}")
    return 2 if failed else 0
