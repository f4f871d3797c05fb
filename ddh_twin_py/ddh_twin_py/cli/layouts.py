"""`ddh-twin layouts`: layouts for PlotJuggler, Foxglove and rqt."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import add_json, add_quiet, add_verb, named_file, namespace, refuse_recording, refuse_same, refuse_unwritable

_EXAMPLE = "  ddh-twin layouts out/layouts --namespace /crane_1"


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "layouts", "write layouts for PlotJuggler, Foxglove or Lichtblick, and rqt",
        "Writes plotjuggler_live.xml (topics of a running twin, or a bag of ddh-twin export --mcap), plotjuggler_table.xml (a table of\n"
        "ddh-twin export --csv or --parquet), foxglove.json and diagnostic_aggregator.yaml (the tree of rqt_robot_monitor). Those for\n"
        "the namespace /ddh are installed in share/ddh_twin_py/config/layouts.",
        _EXAMPLE,
    )
    parser.add_argument("folder", metavar="FOLDER", type=named_file, help="folder to write into")
    parser.add_argument("--namespace", metavar="NS", default="/ddh", help="of the twin's topics (default /ddh)")
    add_json(parser, "write the names of the files as JSON; - is standard output")
    add_quiet(parser, "do not list the files")


def run(args: argparse.Namespace) -> int:
    """Write the files."""
    from pathlib import Path

    from ddh_twin_py.bags.topics import normalised
    from ddh_twin_py.cli.console import put_json
    from ddh_twin_py.exchange.layouts.files import layout_files
    from ddh_twin_py.rig.files import write_whole

    folder = Path(args.folder)
    files = {folder / name: content for name, content in layout_files(normalised(namespace(args.namespace))).items()}
    refuse_unwritable("FOLDER", folder, files)
    refuse_same("FOLDER", files, {"--json": args.json})
    refuse_recording("FOLDER", folder)
    written = [write_whole(path, content) for path, content in files.items()]
    if args.json:
        put_json(args.json, {"files": [str(path) for path in written]})
    if not args.quiet and args.json != "-":
        print(*written, sep="\n")
    return 0
