"""`ddh-twin study`: sweeps of the model that answer a question."""

from __future__ import annotations

import argparse
import re
import time

from ddh_twin_py.cli.arguments import InputError, add_html, add_json, add_quiet, add_rig, add_verb, output_file, positive
from ddh_twin_py.twin.duty_file import duty_file

_EXAMPLE = "  ddh-twin study cold-start --ambient -30:40:5 --grades 15,32,68 --duty paper_cycle --html out/cold_start.html"
DUTIES = "paper_cycle,paper_cycle_each_minute,paper_cycle_fast"
_MOST = 5000
_LONGEST = 1000.0
_RANGE = (-60.0, 80.0)


def ambients(text: str) -> list[float]:
    """`from:to:step` or a list with commas, degC."""
    try:
        if ":" in text:
            first, last, step = (float(part) for part in text.split(":"))
            if step <= 0.0 or last < first:
                raise ValueError
            if (last - first) / step > _MOST:
                raise argparse.ArgumentTypeError(f"{text!r} are more than {_MOST} ambients, the most starts that are run at once")
            found = [first + k * step for k in range(int((last - first) / step + 1e-9) + 1)]
        else:
            found = [float(part) for part in text.split(",")]
    except (ValueError, OverflowError):
        raise argparse.ArgumentTypeError(f"{text!r} is neither FROM:TO:STEP nor a list such as -30,0,20, in degC") from None
    for value in found:
        if not _RANGE[0] <= value <= _RANGE[1]:
            raise argparse.ArgumentTypeError(f"an ambient of {value:g} degC, allowed are {_RANGE[0]:g} to {_RANGE[1]:g} degC")
    return sorted(set(found))


def hours(text: str) -> float:
    """Above 0, at most `_LONGEST`."""
    value = positive(text)
    if value > _LONGEST:
        raise argparse.ArgumentTypeError(f"{text!r} is above {_LONGEST:g} h, the longest that a start is run")
    return value


def names(text: str) -> list[str]:
    """A list with commas."""
    found = list(dict.fromkeys(part.strip() for part in text.split(",") if part.strip()))
    if not found:
        raise argparse.ArgumentTypeError("an empty list")
    return found


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "study", "sweep ambient, oil and duty: can the unit keep itself warm?",
        "cold-start: a unit that is as cold as its surroundings starts its duty as fast as drive and oil allow. Says for each\n"
        "ambient, oil grade and duty how long until the viscosity allows full speed, how warm oil and winding become, and\n"
        "where the answer flips.",
        _EXAMPLE,
    )
    parser._negative_number_matcher = re.compile(r"^-[\d.]\S*$")  # -30:40:5 is a value and no option
    parser.add_argument("study", metavar="STUDY", choices=("cold-start",), help="cold-start")
    parser.add_argument("--ambient", metavar="DEGC", type=ambients, default=ambients("-30:40:5"), help="FROM:TO:STEP or a list (default "
        "-30:40:5)")
    parser.add_argument("--grades", metavar="LIST", type=names, default=None, help="oil grades such as 32,46,HVLP 32 (default all of "
        "oil_grades.yaml)")
    parser.add_argument("--duty", metavar="LIST", type=names, default=names(DUTIES), help=f"duty files, or names of the project's "
        f"(default {DUTIES})")
    parser.add_argument("--hours", metavar="H", type=hours, default=8.0, help=f"of duty, at most {_LONGEST:g} (default 8)")
    add_rig(parser)
    add_html(parser, "write the page with the maps")
    parser.add_argument("--csv", metavar="FILE", type=output_file, help="write one line per start")
    add_json(parser)
    add_quiet(parser, "no progress, no table")


def run(args: argparse.Namespace) -> int:
    """Sweep, write what was asked for, print where the answer flips."""
    from ddh_twin_py.cli.console import put_json, stage
    from ddh_twin_py.rig import load_rig
    from ddh_twin_py.rig.oil_grades import oil_grade, oil_grades

    rig = load_rig(args.rig)
    grades = list(dict.fromkeys(oil_grade(name).name for name in args.grades or oil_grades()))
    paths = [duty_file(given) for given in args.duty]
    with stage("loading", args.quiet):
        from ddh_twin_py.report.page.document import write_text
        from ddh_twin_py.report.studies.cold_start import as_csv, as_json, cold_start_document
        from ddh_twin_py.twin.cold_start import Case, check_moves, sweep
        from ddh_twin_py.twin.duty import check_for_rig, load_duty
    duties = {}
    for path in dict.fromkeys(paths):
        if path.stem in duties:
            raise InputError(f"--duty: {duties[path.stem].file} and {path} have the same name; rename one, it names the rows")
        duties[path.stem] = load_duty(path)
        check_for_rig(duties[path.stem], rig)
        check_moves(duties[path.stem])
    cases = [Case(ambient, grade, duty) for duty in duties for grade in grades for ambient in args.ambient]
    if len(cases) > _MOST:
        raise InputError(f"{len(cases)} starts, at most {_MOST} are run at once; ask for fewer ambients, grades or duties")
    started = time.perf_counter()
    with stage(f"running {len(cases)} starts of {args.hours:g} h", args.quiet) as progress:
        outcomes = sweep(rig, duties, cases, args.hours, progress)
    seconds = time.perf_counter() - started
    if args.html:
        cold_start_document(rig, outcomes, args.hours, seconds).write(args.html)
    if args.csv:
        write_text(args.csv, as_csv(outcomes))
    if args.json:
        put_json(args.json, as_json(rig, outcomes, args.hours, seconds))
    if not args.quiet and args.json != "-":
        print_flips(outcomes)
    return 0


def print_flips(outcomes) -> None:
    """Where the answer changes, on standard output."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from ddh_twin_py.cli.console import output
    from ddh_twin_py.physics.oil import STATED_FROM, ZERO_CELSIUS
    from ddh_twin_py.report.studies.cold_start import flips, verdict

    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for name in ("duty", "oil", "what happens at which ambient"):
        table.add_column(name)
    for line in flips(outcomes):
        table.add_row(*line)
    console = output()
    console.print(verdict(outcomes))
    console.print(table)
    if any(o.extrapolated for o in outcomes):
        console.print(f"Below {STATED_FROM - ZERO_CELSIUS:g} degC the viscosity is extrapolated: the Walther law is stated from there on.")
