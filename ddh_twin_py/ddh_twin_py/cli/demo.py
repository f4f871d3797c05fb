"""`ddh-twin demo`: a recording through the live node graph, with a report of what came out."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from ddh_twin_py.bags.numbering import numbered
from ddh_twin_py.cli.arguments import (
    InputError,
    add_json,
    add_quiet,
    add_rig,
    add_verb,
    named_file,
    reads,
    refuse_recording,
    refuse_same,
    refuse_unwritable,
)

_EXAMPLE = "  ddh-twin demo --out out/demo"
_REPORT, _NUMBERS, _LOG = "report.html", "report.json", "nodes.log"
_OWN = "recorded_by_demo"  # in the folder of a recording that the next demo may replace


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "demo", "replay the paper's cycle through the live nodes and write a report",
        "Starts each node as its own process in a ROS 2 domain of its own, plays a bag through them as fast as they\n"
        "take it, records what they publish, and reports it beside what was measured and beside the replay in one\n"
        "process. A twin that runs on this machine is not disturbed.",
        _EXAMPLE,
    )
    parser.add_argument("--bag", metavar="BAG", type=named_file, help="another recording than bags/paper_cycle")
    parser.add_argument("--out", metavar="FOLDER", default="out/demo", type=named_file, help="where the report goes (default out/demo)")
    add_rig(parser)
    add_json(parser, "write the numbers as JSON once more; - is standard output (default report.json in --out)")
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Compile, play, report."""
    import shutil
    from dataclasses import asdict

    from ddh_twin_py.cli.console import output, put_json, say, show_findings, stage

    out = Path(args.out)
    bag = Path(args.bag) if args.bag else _example_bag()
    recorded = next(path for path in numbered(out / "twin") if not os.path.lexists(path) or (path / _OWN).is_file())
    _look_at_outputs(out, recorded, bag, args.json)
    with stage("loading", args.quiet):
        from ddh_twin_py.bags.reader import read_recording
        from ddh_twin_py.cli.live_play import play
        from ddh_twin_py.cli.live_result import live_result
        from ddh_twin_py.cli.replay import leave_one_out
        from ddh_twin_py.estimation.replay import replay
        from ddh_twin_py.report.replay.agreement import compare
        from ddh_twin_py.report.replay.live_differences import differences, sentence
        from ddh_twin_py.report.replay.page import replay_document, replay_json
        from ddh_twin_py.report.replay.summary import print_summary
        from ddh_twin_py.rig import load_rig
        from ddh_twin_py.twin.intervals import INTERVAL
    rig = load_rig(args.rig)
    recording = read_recording(bag)
    with stage("compiling the model, once", args.quiet):
        replay(recording.between(0.0, 5.0), rig)
    with stage("replaying in one process, to compare with", args.quiet) as progress:
        offline = replay(recording, rig, progress=progress)
    with stage("estimating each location without its sensor", args.quiet) as progress:
        left_out = leave_one_out(offline, recording, INTERVAL, progress)
    shutil.rmtree(recorded, ignore_errors=True)
    try:
        played = play(bag, recorded, out / _LOG, rig_file=args.rig, quiet=args.quiet)
    finally:
        if recorded.is_dir():
            (recorded / _OWN).touch()
    with stage(f"writing {out / _REPORT}", args.quiet):
        live, share = live_result(recorded, offline)
        apart = differences(live, offline)
        agreement = compare(live, left_out)
        how = (
            f"live: bag_player, hydraulic_model, machine_thermal, temperature_fusion and bag_recorder as processes; "
            f"{played.sent} messages, {played.lost} lost, {played.speed:.1f} times real time, {played.cores:.1f} cores"
        )
        rows = [
            ("Live against one process", sentence(apart)),
            ("Intervals that came over the topics", f"{100.0 * share:.2f} % of {live.time.size}"),
            ("What the nodes said", str(out / _LOG)),
            ("What the nodes published", str(recorded)),
        ]
        replay_document(live, agreement, how, rows).write(out / _REPORT)
        told = {
            "messages_sent": played.sent, "messages_lost": played.lost, "times_real_time": played.speed,
            "cores": played.cores, "share_of_intervals": share, "against_one_process": [asdict(d) for d in apart],
        }
        numbers = replay_json(live, agreement, how, {"live": told})
        put_json(str(out / _NUMBERS), numbers)
    if args.json:
        put_json(args.json, numbers)
    show_findings(live.recording.findings, str(out / _REPORT))
    if not args.quiet and args.json != "-":
        speed = f"live at {played.speed:.1f} times real time, {played.lost} messages lost"
        print_summary(agreement, f"{recording.path}, {speed}", output())
        print(f"live against one process: {sentence(apart)}.")
        print(f"report: {out / _REPORT}")
    if played.lost or share < 0.99:
        came = f"{100.0 * share:.1f} % of the intervals came"
        say(f"warning: {played.lost} messages were lost and {came}; see {out / _LOG}")
    return 0


def _example_bag() -> Path:
    for root in (Path.cwd(), Path(__file__).resolve().parents[3]):
        if (root / "bags" / "paper_cycle").is_dir():
            bag = root / "bags" / "paper_cycle"
            return bag.relative_to(Path.cwd()) if bag.is_relative_to(Path.cwd()) else bag
    raise InputError("bags/paper_cycle is not here; name a recording with --bag")


def _look_at_outputs(out: Path, recorded: Path, bag: Path, numbers: str | None) -> None:
    """What is to be written can be, is written once, and is not of the recording to play.

    Raises:
        InputError: it cannot, or is.
    """
    own = [out / name for name in (_REPORT, _NUMBERS, _LOG)]
    refuse_unwritable("--out", out, own)
    refuse_recording("--out", out)
    refuse_same("--out", [*own, recorded], {"--json": numbers})
    if numbers and reads(str(bag), numbers):
        raise InputError(f"--json would overwrite {numbers!r} of the recording to play, {bag}; give it a path of its own")
    if bag.resolve().is_relative_to(recorded.resolve()):
        raise InputError(f"--bag: {bag} would be overwritten by what is recorded; give --out another folder")
