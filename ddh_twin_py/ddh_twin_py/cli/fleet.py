"""`ddh-twin fleet`: every recording below a folder diagnosed, one row each."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ddh_twin_py.cli.arguments import (
    InputError,
    add_html,
    add_json,
    add_quiet,
    add_verb,
    named_file,
    output_file,
    positive,
    refuse_recording,
    refuse_same,
    refuse_unwritable,
    whole,
)

if TYPE_CHECKING:
    from ddh_twin_py.rig import Rig

_EXAMPLE = """\
  ddh-twin fleet bags --html out/fleet.html
  ddh-twin fleet /data/cranes --jobs 4 --out out/cranes --parquet out/cranes.parquet"""

_TABLE = "fleet.csv"
_LOCK = ".fleet.lock"  # held as long as recordings are diagnosed; the file stays


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "fleet", "diagnose every recording below a folder, with trends per rig",
        "Finds case folders (field/, perhaps commissioning/ and validation/) and single bags, diagnoses each in a process of its\n"
        "own, and writes one row for each. What is finished is kept, so that a run that was cut off goes on where it was; a\n"
        "recording that changed is diagnosed anew. A recording that cannot be used is a row with the error.",
        _EXAMPLE,
    )
    parser.add_argument("folder", metavar="FOLDER", help="folder with the recordings")
    parser.add_argument("--out", metavar="FOLDER", default="out/fleet", help="results, one file each, and fleet.csv (default out/fleet)")
    parser.add_argument("--jobs", metavar="N", type=whole(1, 256), default=max(1, (os.cpu_count() or 1) // 2),
                        help="recordings at once (default half of the processors)")
    parser.add_argument("--cluster", metavar="ADDRESS", default="", help="run on this Dask scheduler (tcp://host:8786), whose workers see "
                        "the recordings at the same paths; needs dask.distributed")
    parser.add_argument("--again", action="store_true", help="diagnose also what is finished")
    parser.add_argument("--longest", metavar="S", type=positive, default=3600.0, help="give a recording up after so many seconds, "
                        "without those of compiling the model (default 3600)")
    parser.add_argument("--rig", metavar="FILE", type=named_file, action="append", default=[], help="rig file with what differs from the "
                        "reference sheet, for all recordings; given several times, each is for the recordings that name its rig_id, and "
                        "others are held against the reference sheet. A machine of another design (stroke, pumps ...) needs its own")
    parser.add_argument("--csv", metavar="FILE", type=output_file, help="the table (default fleet.csv in --out)")
    parser.add_argument("--parquet", metavar="FILE", type=output_file, help="the table as Parquet")
    add_html(parser, "write the page with the trend of each rig")
    add_json(parser, "write the rows as JSON; - is standard output")
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Find, diagnose, write the table and the page, print what came of it."""
    from dataclasses import asdict

    from ddh_twin_py.cli.console import put_json, stage
    from ddh_twin_py.fleet.page import fleet_document, fleet_end, newest_gaps, of_other_versions, of_reference, remark, verdict
    from ddh_twin_py.fleet.parquet import write_parquet
    from ddh_twin_py.fleet.progress import FleetProgress
    from ddh_twin_py.fleet.recordings import FleetError, find_recordings
    from ddh_twin_py.fleet.results import Results
    from ddh_twin_py.fleet.row import as_csv
    from ddh_twin_py.fleet.run import Settings, run_fleet
    from ddh_twin_py.report.page.document import write_text
    from ddh_twin_py.rig import load_rig
    from ddh_twin_py.rig.files import held, printable

    rigs = [load_rig(file) for file in args.rig]
    by_id = _by_id(rigs)
    sheets = ", ".join([*args.rig, *[load_rig().file] * (len(args.rig) != 1)])
    for name, given in (("FOLDER", args.folder), ("--out", args.out)):
        if not given.strip():
            raise InputError(f"{name} is {given!r}; allowed is the name of a folder")
    out = Path(args.out)
    refuse_unwritable("--out", out, [out / _TABLE])
    results = Results(out / "results")
    own = [results.folder, out / _LOCK] + [out / _TABLE] * (not args.csv)
    refuse_same("--out", own, {"--csv": args.csv, "--parquet": args.parquet, "--html": args.html, "--json": args.json})
    refuse_recording("--out", out)
    found = find_recordings(args.folder, out, Path(args.rig[0]) if len(args.rig) == 1 else None, by_id)
    busy = FleetError(f"{out}: another ddh-twin fleet writes its results there; wait for it, or give --out another folder")
    unkept: list[OSError] = []
    before = [results.finished(one) is not None and not args.again for one in found]
    far = FleetProgress(len(found), sum(before))
    with held(out, _LOCK, busy), stage(f"diagnosing {len(found)} recordings", args.quiet, far.said) as progress:
        progress(far.share)
        try:
            rows = run_fleet(found, results, Settings(args.longest), args.jobs, args.cluster, args.again, far.then(progress), unkept.append)
        except KeyboardInterrupt:
            kept = sum(results.finished(one) is not None for one in found)
            print(f"{kept} of {len(found)} recordings are finished and kept in {results.folder}; started again, it goes on with the others",
                  file=sys.stderr, flush=True)
            raise
    table = args.csv or str(out / _TABLE)
    write_text(table, as_csv(rows))
    if args.parquet:
        write_parquet(args.parquet, rows)
    if args.json:
        told = {"folder": str(args.folder), "verdict": verdict(rows), "end_matter": fleet_end(rows, sheets).as_json()}
        put_json(args.json, {**told, "rows": [asdict(row) for row in rows]})
    if args.html:
        fleet_document(str(args.folder), rows, sheets).write(args.html)
    if not args.quiet and args.json != "-":
        print(verdict(rows))
        for said in newest_gaps(rows):
            print(f"  {printable(said)}")
        if held := of_reference(rows):
            print(held)
        for row in (row for row in rows if row.copies):
            print(f"  {printable(row.names)}: the same recording, one row")
        for row in rows:
            if said := remark(row):
                print(f"  {printable(row.recording)}: {printable(said)}")
        if others := of_other_versions(rows):
            print(f"answers of other versions: {others}; --again makes them anew")
        further = {"Parquet": args.parquet, "JSON": args.json, "page": args.html}
        print(", ".join([f"table: {table}", *(f"{what}: {path}" for what, path in further.items() if path)]))
    if unkept:
        print(f"{len(unkept)} of {len(found)} results could not be kept ({unkept[0]}); they are in the table, and the next run makes them "
              "anew", file=sys.stderr)
    return 1 if unkept else 0


def _by_id(rigs: Sequence[Rig]) -> dict[str, Path]:
    """Files of several rigs by the id that recordings name; none of one, which holds for all."""
    if len(rigs) < 2:
        return {}
    found: dict[str, Path] = {}
    for rig in rigs:
        if not rig.named:
            raise InputError(f"--rig: {rig.file} has no rig_id of its own; of several rig files each is for the recordings that name its "
                             "rig_id")
        if rig.rig_id in found:
            raise InputError(f"--rig: {found[rig.rig_id]} and {rig.file} both have the rig_id {rig.rig_id}; give one of them")
        found[rig.rig_id] = Path(rig.file)
    return found
