"""`ddh-twin simulate`: a bag from a simulated rig."""

from __future__ import annotations

import argparse
from datetime import datetime

from ddh_twin_py.cli.arguments import InputError, add_json, add_quiet, add_rig, add_verb, between, new_folder, seed
from ddh_twin_py.twin.duty_file import duty_file

_EXAMPLE = """\
  ddh-twin simulate paper_cycle -o out/simulated --seed 3 --duration 600
  ddh-twin simulate mixed -o out/next_day --seed 3 --noise-seed 4 --begin 2026-01-02T08:00:00Z --duration 600    the same rig again"""
LONGEST = 86400.0
"""s; a recording is put together in memory."""
START_NS = 1_767_225_600_000_000_000
"""Stamp of the first sample where none is asked for, 2026-01-01 UTC: the same seed gives the same bag."""
_LAST_NS = (2**31 - round(LONGEST)) * 10**9
"""Latest stamp of a first sample: seconds of a message end in 2038."""


def moment(text: str) -> int:
    """ns since 1970 UTC of an ISO 8601 moment."""
    from ddh_twin_py.exchange.mapping import iso_to_ns

    try:
        stamp = iso_to_ns(datetime.fromisoformat(text.strip()))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no moment such as 2026-05-01T08:00:00Z") from None
    if not 0 <= stamp <= _LAST_NS:
        raise argparse.ArgumentTypeError(f"{text!r} is beyond what a stamp can say, 1970 to 2038-01-18")
    return stamp


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "simulate", "record a simulated rig that does a duty",
        "Draws a rig within the tolerances of the sheet, lets it do a duty, and writes what its sensors say, with\n"
        "their noise, as a bag. The twin does not know what was drawn; with --exact nothing but noise is. The bag is of the rig_id\n"
        "of the rig file; where none is given, of simulated_SEED.",
        _EXAMPLE,
    )
    parser.add_argument(
        "duty", metavar="DUTY", help="duty file, or the name of one of the project's, such as paper_cycle or mixed"
    )
    parser.add_argument("-o", "--output", metavar="BAG", type=new_folder, required=True, help="folder to write, must not exist")
    parser.add_argument("--seed", type=seed, default=1,
                        help="of the rig, its sensors' zeros and their noise: the same seed gives the same bag (default 1)")
    parser.add_argument("--noise-seed", metavar="SEED", type=seed,
                        help="of the noise alone: another recording of the rig that --seed draws (default: as --seed says)")
    parser.add_argument("--begin", metavar="TIME", type=moment, default=START_NS,
                        help="stamp of the first sample, such as 2026-05-01T08:00:00Z; UTC where no zone is given (default 2026-01-01)")
    add_rig(parser)
    parser.add_argument("--exact", action="store_true", help="the rig of the file itself, drawn is its noise alone")
    parser.add_argument("--duration", metavar="S", type=between(0.05, LONGEST, "s"),
                        help=f"stop after so many seconds, at most {LONGEST:g}")
    add_json(parser, "write what the bag holds as JSON; - is standard output")
    add_quiet(parser, "no progress")


def run(args: argparse.Namespace) -> int:
    """Simulate and write."""
    from ddh_twin_py.cli.console import put_json, say, stage
    from ddh_twin_py.twin.duty import load_duty

    path = duty_file(args.duty)
    duty = load_duty(path)
    if duty.repeat == 0 and args.duration is None:
        raise InputError(f"{path}: repeat is 0, for ever; say with --duration when to stop")
    with stage("loading", args.quiet):
        from ddh_twin_py.bags.reader import read_recording
        from ddh_twin_py.bags.writer import write_recording
        from ddh_twin_py.cli.info import recording_json
        from ddh_twin_py.cli.simulated import collect
        from ddh_twin_py.rig import load_rig
        from ddh_twin_py.twin.simulated_rig import SimulatedRig
    rig = SimulatedRig(load_rig(args.rig), duty, args.seed, exactly=args.exact, noise_seed=args.noise_seed)
    with stage("simulating", args.quiet) as progress:
        recording = collect(rig.run(args.duration or LONGEST), args.begin, args.duration, progress)
    if args.duration is None and recording.duration > LONGEST - 1.0:
        raise InputError(f"{path}: the duty takes more than {LONGEST:g} s; say with --duration when to stop")
    with stage(f"writing {args.output}", args.quiet):
        write_recording(args.output, recording)
    if args.json:
        put_json(args.json, recording_json(read_recording(args.output)))
    if not args.quiet:
        say(f"{args.output}: {recording.duration:.1f} s of {recording.rig.rig_id}")
    return 0
