"""`ddh-twin fmu`: the twin as an FMU for other simulation tools."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import InputError, add_json, add_quiet, add_rig, add_verb, output_file

_EXAMPLE = """\
  ddh-twin fmu out/twin.fmu
  ddh-twin fmu out/crane_1.fmu --rig crane_1.yaml"""


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "fmu", "write the twin as an FMU (FMI 2.0, co-simulation)",
        "Compiles the free run of a rig into an FMU: speed command, payload and ambient in, pressures, motion, powers, losses and\n"
        "temperatures out, every number of the rig file that it reads a parameter. It runs without Python on Linux x86-64; to make it\n"
        "takes a C compiler.",
        _EXAMPLE,
    )
    parser.add_argument("output", metavar="FILE", type=output_file, help="FMU to write, NAME.fmu")
    add_rig(parser)
    add_json(parser, "write the variables as JSON; - is standard output")
    add_quiet(parser, "no progress")


def run(args: argparse.Namespace) -> int:
    """Compile, pack, write."""
    from dataclasses import asdict

    from ddh_twin_py.cli.console import put_json, say, stage
    from ddh_twin_py.rig import load_rig

    if not args.output.endswith(".fmu"):
        raise InputError(f"{args.output}: the name of an FMU ends in .fmu")
    rig = load_rig(args.rig)
    with stage("loading", args.quiet):
        from ddh_twin_py.exchange.fmu.archive import write_fmu
        from ddh_twin_py.exchange.fmu.variables import variables
    with stage("compiling the model", args.quiet) as progress:
        write_fmu(args.output, rig, progress)
    if args.json:
        put_json(args.json, {"fmu": args.output, "rig_file": rig.file, "variables": [asdict(variable) for variable in variables(rig)]})
    if not args.quiet:
        say(f"{args.output}: rig {rig.rig_id}, {len(variables(rig))} variables")
    return 0
