"""`ddh-twin import`: CSV logs of a machine into a bag."""

from __future__ import annotations

import argparse
import os
import sys

from ddh_twin_py.cli.arguments import InputError, add_json, add_quiet, add_verb, namespace, new_folder

_EXAMPLE = """\
  ddh-twin import --example > mapping.yaml
  ddh-twin import drive.csv temperatures.csv --mapping mapping.yaml -o bags/press_7
  ddh-twin import out/samples/*.csv --mapping out/samples/mapping.yaml -o out/again    after ddh-twin export BAG --telemetry out/samples"""


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "import", "make a bag of CSV logs",
        "Reads logs by a mapping file, which says which column is which signal and in which unit, and writes a bag that every other\n"
        "verb takes. What the mapping may say is in the example. Afterwards every sample is screened: a unit or a sign that is\n"
        "wrong is often seen there.",
        _EXAMPLE,
    )
    parser.add_argument("log", metavar="LOG", nargs="*", help="CSV files of one rig")
    parser.add_argument("--mapping", metavar="FILE", help="mapping file (YAML)")
    parser.add_argument("-o", "--output", metavar="BAG", type=new_folder, help="folder to write, must not exist")
    parser.add_argument("--namespace", metavar="NS", default="/ddh", help="of the topics in the bag (default /ddh)")
    parser.add_argument("--example", action="store_true", help="print an example of a mapping file; with logs, their columns as well")
    add_json(parser, "write what the bag holds and what is wrong with it as JSON; - is standard output")
    add_quiet(parser)


def run(args: argparse.Namespace) -> int:
    """Read the mapping and the logs, write the bag, screen it."""
    from ddh_twin_py.cli.console import put_json, say, show_findings, stage

    if args.example:
        return _example(args.log)
    if not args.log:
        raise InputError("no log was given; ddh-twin import --example > mapping.yaml is a beginning")
    for option, given in (("--mapping", args.mapping), ("-o", args.output)):
        if given is None:
            raise InputError(f"{option} is missing; see ddh-twin import --help")
    if twice := [log for i, log in enumerate(args.log) if os.path.realpath(log) in map(os.path.realpath, args.log[:i])]:
        raise InputError(f"{twice[0]}: is given twice; each log is read once")
    to = namespace(args.namespace)
    with stage("loading", args.quiet):
        from ddh_twin_py.bags.reader import read_recording
        from ddh_twin_py.bags.writer import write_recording
        from ddh_twin_py.cli.info import recording_json
        from ddh_twin_py.exchange.import_log import import_logs
        from ddh_twin_py.exchange.mapping import read_mapping
        from ddh_twin_py.rig import load_rig
        from ddh_twin_py.telemetry.screening.screening import screen_by_sheet
    mapping = read_mapping(args.mapping)
    with stage(f"reading {args.log[0] if len(args.log) == 1 else f'{len(args.log)} logs'}", args.quiet):
        recording = import_logs(args.log, mapping)
    with stage(f"writing {args.output}", args.quiet):
        write_recording(args.output, recording, to)
    with stage("screening", args.quiet):
        screened = screen_by_sheet(read_recording(args.output), load_rig())
    if args.json:
        put_json(args.json, recording_json(screened))
    show_findings(screened.findings, f"ddh-twin info {args.output}")
    if not args.quiet:
        say(f"{args.output}: {recording.duration:.1f} s, {sum(len(stream) for _, stream in recording.streams())} samples")
    return 0


def _example(logs: list[str]) -> int:
    from importlib import resources

    sys.stdout.write(resources.files("ddh_twin_py.exchange").joinpath("example_mapping.yaml").read_text("utf-8"))
    if logs:
        from ddh_twin_py.exchange.log_file import headings_of
        from ddh_twin_py.exchange.mapping import Dialect

        for log in logs:
            print(f"\n# columns of {log}: {', '.join(headings_of(log, Dialect()))}")
    return 0
