"""`ddh-twin export`: a recording with the twin's outputs beside it, for other tools."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import (
    InputError,
    add_bag,
    add_interval,
    add_json,
    add_namespace,
    add_quiet,
    add_rig,
    add_verb,
    new_folder,
    output_file,
)

_EXAMPLE = "  ddh-twin export bags/paper_cycle --csv out/paper_cycle.csv --parquet out/paper_cycle.parquet --mcap out/with_twin"


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "export", "write a recording and the twin's outputs for other tools",
        "Replays a bag and writes measurements, soft sensor, free run, estimates and their bands (2 sigma) side by side: as a table\n"
        "(CSV, Parquet; one row for each interval) or as a bag (MCAP) on the topics of the live nodes. --telemetry writes what was\n"
        "measured, sample by sample, with a mapping that ddh-twin import takes.",
        _EXAMPLE,
    )
    add_bag(parser)
    add_rig(parser)
    add_namespace(parser)
    parser.add_argument("--csv", metavar="FILE", type=output_file, help="write a table as CSV, name and unit in its first line")
    parser.add_argument("--parquet", metavar="FILE", type=output_file, help="write the table as Parquet, units in the fields' metadata")
    parser.add_argument("--mcap", metavar="BAG", type=new_folder, help="write a rosbag2 folder with everything in it, must not exist")
    parser.add_argument("--telemetry", metavar="FOLDER", type=new_folder, help="write the samples as CSV, a file for each topic")
    add_interval(parser)
    parser.add_argument("--no-smoothing", action="store_true", help="leave the smoothed temperatures out")
    add_json(parser, "write what each column is, and what the numbers rest on, as JSON; - is standard output")
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Read, replay where a twin is asked for, write."""
    from ddh_twin_py.cli.console import put_json, say, show_findings, stage
    from ddh_twin_py.rig import load_rig

    tables = args.csv or args.parquet or args.mcap or args.json
    if not tables and not args.telemetry:
        raise InputError("nothing to write: say --csv, --parquet, --mcap or --telemetry")
    rig = load_rig(args.rig)
    with stage("loading", args.quiet):
        from ddh_twin_py.bags.reader import read_recording
        from ddh_twin_py.exchange.telemetry_tables import write_telemetry
    with stage(f"reading {args.bag}", args.quiet) as progress:
        recording = read_recording(args.bag, args.namespace, progress).held_against(rig.oil_grade)
    if args.telemetry:
        with stage(f"writing {args.telemetry}", args.quiet):
            write_telemetry(args.telemetry, recording)
    if not tables:
        show_findings(recording.findings, "ddh-twin info")
        return 0
    with stage("loading the twin", args.quiet):
        from ddh_twin_py.estimation.replay import replay
        from ddh_twin_py.exchange.output_bag import write_output_bag
        from ddh_twin_py.exchange.replay_columns import replay_columns
        from ddh_twin_py.exchange.tables import about_columns, write_csv, write_parquet
        from ddh_twin_py.report.replay.doubts import doubts, with_doubts
        from ddh_twin_py.report.replay.page import end_matter_json
        from ddh_twin_py.twin.intervals import INTERVAL
    with stage("running the twin", args.quiet) as progress:
        result = replay(recording, rig, args.interval or INTERVAL, progress=progress, smooth=not args.no_smoothing)
    columns, end, doubtful = replay_columns(result), end_matter_json(result), doubts(result)
    if args.csv:
        with stage(f"writing {args.csv}", args.quiet) as progress:
            write_csv(args.csv, columns, progress)
    if args.parquet:
        with stage(f"writing {args.parquet}", args.quiet):
            write_parquet(args.parquet, columns, end)
    if args.mcap:
        with stage(f"writing {args.mcap}", args.quiet) as progress:
            left_out = write_output_bag(args.mcap, args.bag, result, progress)
        if left_out:
            say(f"warning: {args.mcap}: left out, because the type's definition is nowhere: {', '.join(left_out)}")
    if args.json:
        about = about_columns(columns)
        put_json(args.json, {"recording": recording.path, "rows": int(result.time.size), "doubts": list(doubtful), "columns": about,
                             "end_matter": end})
    show_findings(with_doubts(result.recording, doubtful), "ddh-twin info")
    return 0
