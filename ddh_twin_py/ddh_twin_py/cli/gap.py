"""`ddh-twin gap`: why a recorded rig and its twin part."""

from __future__ import annotations

import argparse
import os

from ddh_twin_py.cli.arguments import InputError, add_html, add_json, add_namespace, add_quiet, add_rig, add_verb, named_file, output_file
from ddh_twin_py.names import no_such

_EXAMPLE = """\
  ddh-twin gap bags/paper_cycle --html out/gap.html
  ddh-twin gap out/today --commissioning out/new -o out/press_7_now.yaml    with the recordings that the tutorial makes"""


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "gap", "say why a recorded rig and its twin part",
        "Runs the twin over recordings of a rig and says what it misses, where, which effects of the catalogue explain it and\n"
        "how surely, what is left, and which test would tell the rest apart. With a recording of the rig as built, the gap is\n"
        "what changed since then; without one, the rig is held against its rig file, or the reference sheet where none is\ngiven.",
        _EXAMPLE,
    )
    parser.add_argument("field", metavar="FIELD", nargs="+",
                        help="bags of one rig in one condition, or a folder with field/, commissioning/ and validation/ in it")
    parser.add_argument("--commissioning", metavar="BAG", type=named_file, help="the rig as built, recorded when it was new")
    parser.add_argument("--validation", metavar="BAG", type=named_file,
                        help="the same rig in the same condition on another duty; takes no part in finding")
    add_rig(parser)
    add_namespace(parser)
    parser.add_argument("--without", metavar="EFFECT", action="append", default=[],
                        help="leave this effect out, because the machine was checked for it (may be given several times)")
    parser.add_argument("-o", "--output", metavar="FILE", type=output_file,
                        help="rig file to write: parameters fitted, the leading cause in it; none where the recordings allow no answer")
    add_html(parser)
    add_json(parser)
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose, write what was asked for, print the summary."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices; the free runs use the cores
    from ddh_twin_py.bags.case import case_of
    from ddh_twin_py.cli.console import stage
    from ddh_twin_py.rig import load_rig

    case = case_of(args.field, args.commissioning, args.validation)
    rig = load_rig(args.rig)
    with stage("loading", args.quiet):
        from ddh_twin_py.diagnosis.of_bags import diagnose, stage_of
        from ddh_twin_py.gap.catalogue import EFFECTS
    for effect in args.without:
        if effect not in EFFECTS:
            raise InputError(f"--without: {no_such('effect', effect, sorted(EFFECTS))}")
    with stage("diagnosing", args.quiet, stage_of) as progress:
        diagnosis = diagnose(case.field, case.commissioning, case.validation, rig, without=tuple(dict.fromkeys(args.without)),
                             progress=progress, namespace=args.namespace)
    failed: list[OSError] = []
    for write in (_write_html, _write_json, _print, _write_rig):
        try:
            write(args, diagnosis, case, rig)
        except OSError as error:  # what took minutes is not lost with one of its files
            failed.append(error)
    if failed:
        raise failed[0]
    return 0


def _write_html(args: argparse.Namespace, diagnosis, case, rig) -> None:
    if args.html:
        from ddh_twin_py.cli.console import stage
        from ddh_twin_py.report.gap.page import gap_document

        with stage(f"writing {args.html}", args.quiet):
            gap_document(diagnosis).write(args.html)


def _write_json(args: argparse.Namespace, diagnosis, case, rig) -> None:
    if args.json:
        from ddh_twin_py.cli.console import put_json
        from ddh_twin_py.report.gap.page import gap_end

        put_json(args.json, {**diagnosis.report, "end_matter": gap_end(diagnosis).as_json()})


def _print(args: argparse.Namespace, diagnosis, case, rig) -> None:
    from ddh_twin_py.cli.console import output, say
    from ddh_twin_py.report.gap.summary import lost_data, print_gap

    if not args.quiet and args.json != "-":
        print_gap(diagnosis, output())
        return
    for said in lost_data(diagnosis):
        say(f"warning: {said}")


def _write_rig(args: argparse.Namespace, diagnosis, case, rig) -> None:
    if args.output:
        from ddh_twin_py.cli.console import say
        from ddh_twin_py.rig.writer import write_rig

        if diagnosis.report["verdict"] == "insufficient":
            say(f"{args.output}: not written, as the recordings allow no answer")
            return
        write_rig(args.output, diagnosis.rig, _heading(diagnosis, case, rig.file))
        if not args.quiet:
            doubts = [*(["what acts is unknown and not in it"] * diagnosis.nameless), *diagnosis.damage]
            careful = f"; careful, {'; '.join(doubts)}" if doubts else ""
            say(f"{args.output}: rig {diagnosis.rig.rig_id}{careful}")


def _heading(diagnosis, case, given: str) -> str:
    """Comment for the top of the rig file."""
    from ddh_twin_py.rig.files import printable

    bags = ", ".join(printable(path) for path in (*case.field, case.commissioning) if path is not None)
    alone = "those of the commissioning recording alone" if case.commissioning else "fitted as if nothing acted, and may have taken it up"
    unknown = f"What acts is unknown and not in this file; its parameters are {alone}.\n" if diagnosis.nameless else ""
    at_end = [] if diagnosis.nameless and case.commissioning else [p.name for p in diagnosis.parameters if p.informed and p.at_end]
    pressed = f"At the end of their tolerance, which is as far as a fit goes: {', '.join(at_end)}\n" if at_end else ""
    return (f"Written by ddh-twin gap from {bags}\npriors: {printable(given)}\n{printable(diagnosis.sentence)}\n{unknown}{pressed}"
            "Entries that are not named here are the reference sheet's.\n"
            "std: one standard deviation; correlations between fitted values are not kept here.")
