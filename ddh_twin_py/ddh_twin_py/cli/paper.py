"""`ddh-twin paper`: what the paper states beside what the twin makes of it."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import add_html, add_json, add_quiet, add_rig, add_verb

_EXAMPLE = "  ddh-twin paper --html out/paper.html --json out/paper.json"


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "paper", "reproduce the paper's results and explain each difference",
        "Runs the paper's cycle with the model in both readings of its text, 500 rpm and 0.2 m/s, and sets every result\n"
        "that the paper states beside the twin's: paper, twin, difference, explanation.",
        _EXAMPLE,
    )
    add_rig(parser)
    add_html(parser, "write the page with pictures that correspond to figures 3 to 6")
    add_json(parser)
    add_quiet(parser, "no progress, no table")


def run(args: argparse.Namespace) -> int:
    """Compute, write what was asked for, print the table."""
    from ddh_twin_py.cli.console import put_json, stage
    from ddh_twin_py.rig import load_rig

    rig = load_rig(args.rig)
    with stage("loading", args.quiet):
        from ddh_twin_py.report.studies.paper import paper_document, paper_json
        from ddh_twin_py.report.studies.paper_rows import rows
        from ddh_twin_py.twin.paper_runs import paper_runs
    with stage("running the paper's cycle in both readings", args.quiet) as progress:
        runs = paper_runs(rig, progress)
        table = rows(runs)
    if args.html:
        with stage(f"writing {args.html}", args.quiet):
            paper_document(runs, table).write(args.html)
    if args.json:
        put_json(args.json, paper_json(runs, table))
    if not args.quiet and args.json != "-":
        print_table(table)
    return 0


def print_table(rows) -> None:
    """Results with their explanations, on standard output; explanations stand below where the terminal is narrow."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from ddh_twin_py.cli.console import output
    from ddh_twin_py.report.studies.paper import cell, verdict

    console = output()
    wide = console.width >= 130
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    table.add_column("", justify="right")
    table.add_column("result", ratio=3)
    for name in ("paper", "twin", "difference"):
        table.add_column(name, justify="right", ratio=1)
    table.add_column("unit", no_wrap=True)
    table.add_column("twin's number", no_wrap=True)
    if wide:
        table.add_column("explanation", ratio=6)
    for k, row in enumerate(rows, 1):
        cells = (str(k), row.result, cell(row.paper), cell(row.twin), cell(row.difference), row.unit, row.origin)
        table.add_row(*cells, *((row.explanation,) if wide else ()))
    console.print(verdict(rows))
    console.print(table)
    if not wide:  # no room beside the numbers
        for k, row in enumerate(rows, 1):
            console.print(f"{k:2d}  {row.explanation}", highlight=False)
