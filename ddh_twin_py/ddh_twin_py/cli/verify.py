"""`ddh-twin verify`: whether the estimate is as wrong as it says, on simulated rigs."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import add_json, add_quiet, add_rig, add_verb, between, duty_file, whole

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
    add_json(parser)
    add_quiet(parser, "no progress, no table")


def run(args: argparse.Namespace) -> int:
    """Simulate, estimate, judge."""
    from dataclasses import asdict

    import numpy as np

    from ddh_twin_py.cli.console import put_json, stage
    from ddh_twin_py.rig import load_rig
    from ddh_twin_py.twin.duty import load_duty

    rig, duty = load_rig(args.rig), load_duty(duty_file(args.duty))
    with stage("loading", args.quiet):
        from ddh_twin_py.estimation.consistency import hot_spot_inside, many_seeds, nees_band, nis_band, verdict
    with stage(f"{args.seeds} rigs", args.quiet) as progress:
        errors = many_seeds(rig, duty, range(args.first, args.first + args.seeds), args.duration, progress=progress)
    nees, nis, inside = nees_band(errors), nis_band(errors), hot_spot_inside(errors)
    squares = [float(np.mean([getattr(e, name) for e in errors])) for name in ("squared", "smoothed_squared")]
    spread = float(np.mean([e.hot_spot_std for e in errors]))
    said = verdict(nees, nis, inside, args.seeds)
    if args.json:
        put_json(args.json, {
            "verdict": said,
            "seeds": [args.first, args.first + args.seeds - 1], "duration_s": args.duration, "duty": duty.file, "rig_file": rig.file,
            "nees_per_node": asdict(nees), "nis_per_reading": asdict(nis), "hot_spot_inside_95": inside, "hot_spot_std_mean_K": spread,
            "mean_squared_error_K2": {"filtered": squares[0], "smoothed": squares[1]},
        })
    if not args.quiet and args.json != "-":
        print(said)
        for name, band in (("errors of all nodes, whitened", nees), ("innovations", nis)):
            print(f"{name}: mean {band.mean:.3f}, band of one instant {band.lower:.3f} to {band.upper:.3f}, "
                  f"{band.inside:.0%} of {band.instants} instants inside")
        print(f"winding hot spot without its sensor: {inside:.1%} within the 95 % interval, sigma {spread:.1f} K on average")
        print(f"mean squared error of all nodes: filtered {squares[0]:.3f} K2, smoothed {squares[1]:.3f} K2")
    return 0
