"""`ddh-twin verify`: whether the estimate is as wrong as it says, on simulated rigs."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import add_html, add_json, add_quiet, add_rig, add_verb, between, whole
from ddh_twin_py.twin.duty_file import duty_file

_EXAMPLE = "  ddh-twin verify --seeds 40 --duration 600 --json out/consistency.json"


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "verify", "hold the estimate's errors against its own uncertainty, on simulated rigs",
        "Draws rigs within the sheet's tolerances, with starts, unknown heats, sensor lags and offsets of their own, and\n"
        "estimates each with all sensors and without the winding's. Errors of all nodes (whitened with their whole\n"
        "covariance) and innovations are averaged over the rigs and held against the 95 % band of their chi-square\n"
        "distribution. A rig of 600 s takes about 3 s.",
        _EXAMPLE,
    )
    add_rig(parser)
    parser.add_argument("--seeds", metavar="N", type=whole(1, 10_000), default=40, help="number of rigs, 1 to 10000 (default 40)")
    parser.add_argument("--first", metavar="N", type=whole(0, 10**9), default=0, help="seed of the first rig, 0 to 1000000000 (default 0)")
    parser.add_argument("--duration", metavar="S", type=between(60.0, 86400.0, "s"), default=600.0,
                        help="of each, 60 to 86400 s (default 600)")
    parser.add_argument("--duty", metavar="FILE", default="mixed", help="duty file, or a name of config/duty (default mixed)")
    add_html(parser)
    add_json(parser)
    add_quiet(parser, "no progress, no table")


def run(args: argparse.Namespace) -> int:
    """Simulate, estimate, judge."""
    from ddh_twin_py.cli.console import put_json, stage
    from ddh_twin_py.rig import load_rig
    from ddh_twin_py.twin.duty import load_duty

    rig, duty = load_rig(args.rig), load_duty(duty_file(args.duty))
    with stage("loading", args.quiet):
        from ddh_twin_py.estimation.consistency import many_seeds
        from ddh_twin_py.report.studies.consistency import consistency_document, consistency_json
    with stage(f"{args.seeds} rigs", args.quiet) as progress:
        errors = many_seeds(rig, duty, range(args.first, args.first + args.seeds), args.duration, progress=progress)
    told = (rig, errors, args.first, args.duration, duty.file)
    if args.html:
        with stage(f"writing {args.html}", args.quiet):
            consistency_document(*told).write(args.html)
    if args.json:
        put_json(args.json, consistency_json(*told))
    if not args.quiet and args.json != "-":
        print_consistency(consistency_json(*told))
    return 0


def print_consistency(told: dict) -> None:
    """The verdict and the numbers behind it, on standard output."""
    print(told["verdict"])
    for name, band in (("errors of all nodes, whitened", told["nees_per_node"]), ("innovations", told["nis_per_reading"])):
        print(f"{name}: mean {band['mean']:.3f}, band of one instant {band['lower']:.3f} to {band['upper']:.3f}, "
              f"{100.0 * band['inside']:.0f} % of {band['instants']} instants inside")
    print(f"winding hot spot without its sensor: {100.0 * told['hot_spot_inside_95']:.1f} % within the 95 % interval, "
          f"sigma {told['hot_spot_std_mean_K']:.1f} K on average")
    square = told["mean_squared_error_K2"]
    print(f"mean squared error of all nodes: filtered {square['filtered']:.3f} K2, smoothed {square['smoothed']:.3f} K2")
