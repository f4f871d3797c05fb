"""`ddh-twin gap-design`: what a test would tell, before it is made."""

from __future__ import annotations

import argparse
import os

from ddh_twin_py.cli.arguments import InputError, add_html, add_json, add_quiet, add_rig, add_verb, between
from ddh_twin_py.names import no_such
from ddh_twin_py.twin.duty_file import duty_file

_EXAMPLE = "  ddh-twin gap-design paper_cycle --duration 600 --sensors motor_winding,tank_oil --html out/design.html"
_LONGEST = 3600.0  # s
_SHORTEST = 30.0
_COMMISSIONING = "mixed"


def _sensors(text: str) -> list[str]:
    """Temperature sensors, a list with commas, or `none`."""
    named = list(dict.fromkeys(part.strip() for part in text.split(",") if part.strip()))
    if not named:
        raise argparse.ArgumentTypeError("names no sensor; `none` says that there is none")
    return [] if named == ["none"] else named


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "gap-design", "ask what a test would tell before it is made",
        "Rehearses a duty with the rig's model and says which effects a recording of it would detect, how small, and which of\n"
        "them it would not tell apart, with the sensors that there are.",
        _EXAMPLE,
    )
    parser.add_argument("duty", metavar="DUTY", help="duty file, or the name of one of the project's, such as paper_cycle or mixed")
    parser.add_argument("--duration", metavar="S", type=between(_SHORTEST, _LONGEST, "s"),
                        help="of the test (default as the duty says, 600 where it has no end)")
    parser.add_argument("--sensors", metavar="LIST", type=_sensors, help="temperature sensors beside ambient, or none (default all)")
    parser.add_argument("--no-pressure", action="store_true", help="there are no pressure transducers")
    parser.add_argument("--without-commissioning", action="store_true", help="there is no recording of the rig as built")
    parser.add_argument("--commissioning", metavar="DUTY",
                        help=f"duty of the commissioning recording, 600 s (default {_COMMISSIONING})")
    add_rig(parser)
    add_html(parser)
    add_json(parser)
    add_quiet(parser, "no progress, no table")


def run(args: argparse.Namespace) -> int:
    """Rehearse, ask, write what was asked for."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices; the free runs use the cores
    import time
    from concurrent.futures import ThreadPoolExecutor

    from ddh_twin_py.cli.console import output, put_json, stage
    from ddh_twin_py.rig import load_rig
    from ddh_twin_py.twin.duty import load_duty

    if args.without_commissioning and args.commissioning:
        raise InputError(f"--commissioning {args.commissioning} and --without-commissioning exclude each other")
    path = duty_file(args.duty)
    duty, before = load_duty(path), load_duty(duty_file(args.commissioning or _COMMISSIONING))
    rig = load_rig(args.rig)
    with stage("loading", args.quiet):
        from ddh_twin_py.estimation.fitting.experiment import Experiment
        from ddh_twin_py.gap.catalogue import EFFECTS
        from ddh_twin_py.gap.drive.design import design
        from ddh_twin_py.report.gap.design_page import design_document, design_json
        from ddh_twin_py.report.gap.design_summary import print_design
        from ddh_twin_py.twin.rehearsal import rehearse
        from ddh_twin_py.twin.temperature_sensors import SENSORS
    sensors = list(SENSORS) if args.sensors is None else args.sensors
    for name in sensors:
        if name not in SENSORS:
            raise InputError(f"--sensors: {no_such('temperature sensor', name, list(SENSORS))}")
    started = time.perf_counter()
    length = args.duration or (600.0 if duty.repeat == 0 else None)
    with stage("rehearsing", args.quiet):
        field = rehearse(rig, duty, length, sensors, not args.no_pressure, name=path.stem)
        if not _SHORTEST <= field.duration <= _LONGEST:
            raise InputError(f"{path}: the duty takes {field.duration:.0f} s, allowed are {_SHORTEST:g} to {_LONGEST:g} s; say --duration")
        commissioning = None if args.without_commissioning else Experiment(
            rehearse(rig, before, 600.0, sensors, not args.no_pressure, name="commissioning"), rig)
    with stage("asking every effect", args.quiet) as progress, ThreadPoolExecutor(max_workers=2) as pool:
        found = design(Experiment(field, rig), commissioning, rig, list(EFFECTS.values()), pool, progress)
    seconds = time.perf_counter() - started
    if args.html:
        design_document(found, rig, path.stem, seconds).write(args.html)
    if args.json:
        put_json(args.json, design_json(found, rig, path.stem, seconds))
    if not args.quiet and args.json != "-":
        print_design(found, output())
    return 0
