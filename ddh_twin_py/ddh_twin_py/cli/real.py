"""`ddh-twin real`: the gap diagnosis on recordings of real rigs that others measured."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from ddh_twin_py.cli.arguments import InputError, add_json, add_verb, named_file, refuse_same, refuse_unwritable
from ddh_twin_py.names import no_such

TABLE = "real.csv"
"""In the folder of outputs: every figure of every study."""
_EXAMPLE = "  ddh-twin real emps cascaded_tanks --data /data/real --out out/real"


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "real", "diagnose recordings of real rigs, with figures on data that took no part",
        "Runs the gap engine on public recordings of rigs that are not direct driven units: finds effects on the identification\n"
        "data, sizes them on data that took no part, and runs the negative controls. The recordings are not part of the project;\n"
        "each rig says where to get them. A rig whose recordings cannot be used is said in one line and left out, with exit code 2; the\n"
        "others are studied.",
        _EXAMPLE,
    )
    parser.add_argument("rigs", metavar="RIG", nargs="*", help="rigs to study (default: all that have a folder there)")
    parser.add_argument("--data", metavar="FOLDER", type=named_file, required=True,
                        help="folder with one folder of recordings for each rig")
    parser.add_argument("--out", metavar="FOLDER", type=named_file, default="out/real",
                        help="one page and one JSON for each rig, further files of a study, "
                        "and real.csv (default out/real)")
    add_json(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress, no table")


def run(args: argparse.Namespace) -> int:
    """Study, write pages and table, print the table."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from ddh_twin_py.cli.console import put_json, say, stage
    from ddh_twin_py.real_rigs.registry import RIGS, study_of
    from ddh_twin_py.rig.files import did_you_mean

    data, out = Path(args.data), Path(args.out)
    if not data.is_dir():
        raise InputError(f"--data: {data} is no folder{did_you_mean(data)}")
    for rig in args.rigs:
        if rig not in RIGS:
            raise InputError(no_such("rig", rig, list(RIGS)))
    wanted = list(dict.fromkeys(args.rigs)) or [rig for rig in RIGS if (data / rig).is_dir()]
    if not wanted:
        raise InputError(f"--data: {data} holds recordings of no rig; looked for the folders {', '.join(RIGS)}")
    _look_at_outputs(out, args.json, wanted)
    with stage("loading", args.quiet):
        from ddh_twin_py.real_rigs.study import RecordingsError
        from ddh_twin_py.report.page.document import write_text
        from ddh_twin_py.report.studies.real_rig import as_csv, real_rig_document, real_rig_end
    studies, told, refused = [], [], []
    for rig in wanted:
        try:
            with stage(rig, args.quiet) as progress:
                study = study_of(rig).run(data, progress)
        except RecordingsError as error:
            refused.append(rig)
            say(f"ddh-twin real: error: {rig}: {error}")
            continue
        real_rig_document(study).write(out / f"{rig}.html")
        told.append({**study.as_json(), "end_matter": real_rig_end(study).as_json()})
        put_json(str(out / f"{rig}.json"), told[-1])
        for name, text in study.files.items():
            write_text(out / name, text)
        studies.append(study)
    if studies:
        write_text(out / TABLE, as_csv(studies))
    if args.json and studies:
        put_json(args.json, told)
    if not args.quiet:
        for rig in RIGS:
            if rig not in wanted and not args.rigs:
                say(f"{rig}: no recordings in {data}")
        if args.json != "-" and studies:
            print_table(studies, out)
    return 2 if refused else 0


def _look_at_outputs(out: Path, numbers: str | None, rigs: Sequence[str]) -> None:
    """What is to be written can be, and is written once; looked at before anything is computed.

    Raises:
        InputError: it cannot.
    """
    own = [out / TABLE, *(out / f"{rig}.{end}" for rig in rigs for end in ("html", "json"))]
    refuse_unwritable("--out", out, own)
    refuse_same("--out", own, {"--json": numbers})


def print_table(studies, out: Path) -> None:
    """What was found, and the figures of every study, on standard output."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from ddh_twin_py.cli.console import output
    from ddh_twin_py.report.units import plain

    console = output()
    for study in studies:
        passed = sum(c.passed for c in study.controls)
        console.print(f"{study.rig}: {study.sentence} Negative controls: {passed} of {len(study.controls)} passed.", highlight=False)
        table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
        for name in ("figure", "data", "before", "after", "unit"):
            table.add_column(name, justify="right" if name in ("before", "after") else "left", no_wrap=name in ("before", "after", "unit"))
        for row in study.rows:
            table.add_row(row.what, row.split, plain(row.before), plain(row.after), row.unit)
        console.print(table)
    console.print(f"pages and the whole table: {out}", highlight=False)
