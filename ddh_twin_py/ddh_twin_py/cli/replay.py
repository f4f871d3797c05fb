"""`ddh-twin replay`: a recording through the twin in one process."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import add_bag, add_html, add_interval, add_json, add_namespace, add_quiet, add_rig, add_verb

_EXAMPLE = "  ddh-twin replay bags/paper_cycle --html out/report.html --json out/report.json"


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "replay", "run a recording through the twin and say how well they agree",
        "Reads a bag, runs soft sensor, free run and temperature fusion over it in order of time stamps, and\n"
        "compares them with what was measured. The same bag gives the same numbers every time.",
        _EXAMPLE,
    )
    add_bag(parser)
    add_rig(parser)
    add_namespace(parser)
    add_html(parser)
    add_json(parser)
    add_interval(parser)
    parser.add_argument(
        "--leave-one-out", action="store_true",
        help="estimate each location once more without its own sensor: a test of the fusion (takes longer)",
    )
    parser.add_argument(
        "--no-smoothing", action="store_true", help="leave the smoothed temperatures out (90 MB of temporary file an hour)",
    )
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Replay, write what was asked for, print the summary."""
    from ddh_twin_py.cli.console import output, put_json, show_findings, stage
    from ddh_twin_py.rig import load_rig

    rig = load_rig(args.rig)
    with stage("loading", args.quiet):
        from ddh_twin_py.bags.reader import read_recording
        from ddh_twin_py.estimation.replay import replay
        from ddh_twin_py.report.replay.agreement import compare
        from ddh_twin_py.report.replay.doubts import with_doubts
        from ddh_twin_py.report.replay.page import replay_document, replay_json
        from ddh_twin_py.report.replay.summary import print_summary
        from ddh_twin_py.twin.intervals import INTERVAL
    with stage(f"reading {args.bag}", args.quiet) as progress:
        recording = read_recording(args.bag, args.namespace, progress)
    interval = args.interval or INTERVAL
    with stage("running the twin", args.quiet) as progress:
        result = replay(recording, rig, interval, progress=progress, smooth=not args.no_smoothing)
    left_out = {}
    if args.leave_one_out:
        with stage("leaving out one sensor at a time", args.quiet) as progress:
            left_out = leave_one_out(result, recording, interval, progress)
    agreement = compare(result, left_out)
    if args.html:
        with stage(f"writing {args.html}", args.quiet):
            replay_document(result, agreement).write(args.html)
    if args.json:
        put_json(args.json, replay_json(result, agreement))
    summarised = not args.quiet and args.json != "-"
    findings = with_doubts(result.recording, () if summarised else agreement.doubts)
    show_findings(findings, args.html or args.json or "the report (--html FILE)")
    if summarised:
        print_summary(agreement, recording.path, output())
    return 0


def leave_one_out(result, recording, interval: float, progress) -> dict:
    """Each sensor that the fusion used beside an estimate that was made without it."""
    from ddh_twin_py.estimation.replay import replay

    names = [name for name, sensor in result.sensors.items() if sensor.used]
    return {
        name: replay(
            recording, result.rig, interval, without=(name,),
            progress=lambda share, k=k: progress((k + share) / len(names)),
        ).sensors[name]
        for k, name in enumerate(names)
    }
