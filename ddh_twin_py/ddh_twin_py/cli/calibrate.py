"""`ddh-twin calibrate`: fit a rig's uncertain parameters to recordings of it."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from ddh_twin_py.cli.arguments import add_html, add_json, add_namespace, add_quiet, add_rig, add_verb, between, named_file, output_file

_EXAMPLE = "  ddh-twin calibrate bags/paper_cycle --held-out 0.3 -o out/rig.yaml --html out/calibration.html"


def _name(text: str) -> str:
    """A name that is not empty."""
    if not text.strip():
        raise argparse.ArgumentTypeError("an empty name")
    return text


def _given_twice(bags: Sequence[str]) -> tuple[str, str] | None:
    """Two arguments that hold the same file of a bag, None where there are none."""
    from ddh_twin_py.bags.folder import open_folder

    seen: dict[Path, str] = {}
    for bag in bags:
        for file in open_folder(bag).files:
            if file.resolve() in seen:
                return seen[file.resolve()], bag
        seen |= {file.resolve(): bag for file in open_folder(bag).files}
    return None


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "calibrate", "fit a rig's uncertain parameters to recordings of it",
        "Fits what the rig file gives a tolerance to commissioning recordings of one rig, with the tolerances as prior, and\n"
        "says which parameters the recordings inform. The rig file that it writes is taken by every --rig.\n"
        "Exit code 1: nothing, or nothing that --only asked for, can be identified, and no rig file is written; or the fit does not\n"
        "describe the machine, as more than half of the signals stay beyond 5 times noise, and the rig file that is written says so.",
        _EXAMPLE,
    )
    parser.add_argument("bags", metavar="BAG", nargs="+", type=named_file, help="rosbag2 folders, or .mcap or .db3 files, of one rig")
    parser.add_argument("-o", "--output", metavar="FILE", type=output_file, help="rig file to write")
    add_rig(parser)
    add_namespace(parser)
    parser.add_argument("--only", metavar="PATH", nargs="+", default=[], type=_name,
                        help="fit these alone (such as pump_1.leakage) and zero errors; all else is held exact; "
                             "one given twice counts once")
    parser.add_argument("--held-out", metavar="SHARE", type=between(0.0, 0.9), default=0.0,
                        help="share at the end of each recording that is only predicted (default 0)")
    add_html(parser)
    add_json(parser)
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Fit, write what was asked for, print the summary."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices; the free runs use the cores
    import time

    from ddh_twin_py.cli.console import output, put_json, say, show_findings, stage
    from ddh_twin_py.rig import load_rig

    rig = load_rig(args.rig)
    with stage("loading", args.quiet):
        from ddh_twin_py.bags.reader import read_recording
        from ddh_twin_py.estimation.fitting.calibration import CalibrationError, calibrate, check_paths
        from ddh_twin_py.estimation.fitting.experiment import Experiment
        from ddh_twin_py.estimation.fitting.held_out import held_out
        from ddh_twin_py.estimation.fitting.unknowns import with_offsets
        from ddh_twin_py.gap.recordings.contradictions import contradictions
        from ddh_twin_py.gap.recordings.suitability import one_clock
        from ddh_twin_py.gap.words import careful
        from ddh_twin_py.report.calibration.groups import signal_fits, unfitted, verdict
        from ddh_twin_py.report.calibration.page import calibration_document, calibration_json
        from ddh_twin_py.report.calibration.summary import print_calibration
        from ddh_twin_py.telemetry.recording import announced_id
    errors = [path for path in args.only if path.startswith("measurement.") and path in rig.quantities]
    check_paths(with_offsets(rig, errors), args.only)  # what the recordings do not read is refused with them
    twice = _given_twice(args.bags)
    if twice:
        raise CalibrationError(f"BAG: {twice[0]} and {twice[1]} are the same bag or share a file of it; its samples would count twice")
    experiments = []
    for bag in args.bags:
        with stage(f"reading {bag}", args.quiet) as progress:
            recording = read_recording(bag, args.namespace, progress).held_against(rig.oil_grade)
            one_clock([recording])
            experiments.append(Experiment(recording, rig, used=1.0 - args.held_out))
        for text in contradictions(recording, rig):  # the fit takes minutes
            say(f"ddh-twin calibrate: warning: {text}")
    another = [text for text in [rig.of_another(announced_id(e.recording for e in experiments))] if text]
    for text in another:
        say(f"ddh-twin calibrate: warning: {text}")
    started = time.perf_counter()
    with stage("fitting", args.quiet) as progress:
        fit = calibrate(experiments, rig, tuple(dict.fromkeys(args.only)), progress=progress)
    seconds = time.perf_counter() - started
    signals = signal_fits(fit, held_out(experiments, fit.rig) if args.held_out else {})
    said, mood = verdict(fit, signals, args.held_out)
    said = careful(another) + said
    if args.html:
        with stage(f"writing {args.html}", args.quiet):
            calibration_document(fit, experiments, signals, args.held_out, said, mood, rig.file, seconds).write(args.html)
    if args.json:
        put_json(args.json, calibration_json(fit, experiments, signals, args.held_out, said, rig.file, seconds))
    for experiment in experiments:
        show_findings(experiment.recording.findings, "what `ddh-twin info` tells of the bag")
    failed = unfitted(signals)
    if not args.quiet and args.json != "-":
        print_calibration(fit, signals, said, output())
    elif failed:
        say(f"ddh-twin calibrate: error: {failed}")
    code = _finish(args, fit, rig, failed, another)
    if not fit.settled:
        say("ddh-twin calibrate: warning: the fit was stopped before it had settled")
    return code


def _finish(args: argparse.Namespace, fit, rig, failed: str, another: Sequence[str]) -> int:
    """Say what was refused and write the rig file; the exit code.

    Args:
        failed: that the fit does not describe the machine, empty where it does; the file says so then.
        another: that the priors are another rig's; empty where they are not. The file says so.
    """
    from ddh_twin_py.cli.console import say
    from ddh_twin_py.gap.words import careful
    from ddh_twin_py.report.calibration.groups import grouped, pressed
    from ddh_twin_py.rig.files import printable
    from ddh_twin_py.rig.writer import write_rig

    for p in fit.refused:
        say(f"ddh-twin calibrate: {p.name} refused: the recordings leave {100 * p.share:.0f} % of its prior deviation; it keeps its prior")
    if args.only and len(fit.refused) == len(set(args.only)):
        say("ddh-twin calibrate: error: nothing that was asked for can be identified from these recordings; no rig file was written")
        return 1
    groups = grouped(fit)
    if not groups["informed"] and not groups["partly informed"]:
        say("ddh-twin calibrate: error: these recordings inform no parameter, too little happens in them; no rig file was written")
        return 1
    if args.output:
        heading = "Fitted by ddh-twin calibrate to " + ", ".join(printable(bag) for bag in args.bags)
        heading += "".join(f"\n{text}" for text in (careful(another).strip(), failed, pressed(fit)) if text)
        heading += f"\npriors: {printable(rig.file)}\nEntries that are not named here are the reference sheet's.\n"
        heading += "std: one standard deviation; correlations between fitted values are not kept here."
        write_rig(args.output, fit.rig, heading)
        if not args.quiet:
            say(f"{args.output}: rig {fit.rig.rig_id}" + (", which does not describe the machine" if failed else ""))
    return 1 if failed else 0
