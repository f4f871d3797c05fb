"""`ddh-twin motor`: a motor's thermal network from its machine description."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import add_html, add_json, add_quiet, add_rig, add_verb, named_file, output_file, whole

_EXAMPLE = """\
  ddh-twin motor --html out/motor.html
  ddh-twin motor --description my_motor.yaml -o my_rig.yaml"""


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "motor", "generate a motor's thermal network from its geometry and compare it with the sheet",
        "Reads slots, dimensions, materials and gaps, meshes one slot, and says what each motor quantity of the data\n"
        "sheet comes to, with the reason where it differs. The twin itself goes on using the sheet unless the rig file\n"
        "that -o writes is given to it.",
        _EXAMPLE,
    )
    parser.add_argument("--description", metavar="FILE", type=named_file, help="machine description with what differs from the 115U2C")
    parser.add_argument("--layers", metavar="N", type=whole(1, 24), default=12, help="of the slot along its depth, 1 to 24 (default 12)")
    add_rig(parser)
    parser.add_argument("-o", "--output", metavar="RIG.yaml", type=output_file, help="write a rig file with the generated quantities")
    add_html(parser)
    add_json(parser)
    add_quiet(parser, "no progress, no table")


def run(args: argparse.Namespace) -> int:
    """Generate, compare, write what was asked for."""
    from ddh_twin_py.cli.console import output, put_json, stage
    from ddh_twin_py.rig import load_rig
    from ddh_twin_py.rig.machine import load_machine

    machine, rig = load_machine(args.description), load_rig(args.rig)
    with stage("loading", args.quiet):
        from ddh_twin_py.physics.motor_condensed import condense
        from ddh_twin_py.physics.motor_geometry import motor_network
        from ddh_twin_py.report.page.document import write_text
        from ddh_twin_py.report.studies import motor_comparison as comparison
        from ddh_twin_py.report.studies.motor_page import motor_document, motor_end, print_motor
    with stage(f"meshing with {args.layers} layers", args.quiet):
        network = motor_network(machine, rig, args.layers)
        condensed = condense(network)
    rows = comparison.rows(condensed, machine, rig)
    overlay = comparison.overlay(condensed, network) if args.output else ""
    if overlay:
        _check(overlay, args.output)
    with stage("refining the mesh", args.quiet) as progress:
        steps = comparison.convergence(machine, rig, args.layers, progress)
    runs = []
    if args.html or args.json:
        with stage("running cycles", args.quiet) as progress:
            runs = comparison.cycles(machine, rig, progress)
    page = None
    if args.html:
        with stage("varying the description", args.quiet):
            sensitive = comparison.sensitivities(machine, rig, min(args.layers, 8))
            page = motor_document(network, condensed, rows, steps, sensitive, runs).html()
    numbers = None
    if args.json:
        numbers = comparison.as_json(network, condensed, rows, steps, runs) | {"end_matter": motor_end(network).as_json()}
    if page is not None:  # nothing is written before everything is computed
        write_text(args.html, page)
    if numbers is not None:
        put_json(args.json, numbers)
    if overlay:
        write_text(args.output, overlay)
    if not args.quiet and args.json != "-":
        print_motor(network, condensed, rows, steps, output())
    return 0


def _check(overlay: str, output: str) -> None:
    """A description can lead out of a rig file's bounds: said before anything is written.

    Raises:
        RigError: with the name of the file that was to be written.
    """
    import tempfile
    from pathlib import Path

    from ddh_twin_py.rig import RigError, load_rig

    with tempfile.TemporaryDirectory(prefix="ddh_motor_") as scratch:
        trial = Path(scratch) / "rig.yaml"
        trial.write_text(overlay, encoding="utf-8")
        try:
            load_rig(trial)
        except RigError as error:
            raise RigError(str(error).replace(str(trial), output)) from None
