"""The command `ddh-twin`."""

from __future__ import annotations

import keyword
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from ddh_twin_py.cli.arguments import Parser
from ddh_twin_py.cli.exit_codes import EXIT_CODES
from ddh_twin_py.cli.interruption import Interruption
from ddh_twin_py.cli.standard_output import STANDARD_OUTPUT, name_standard_output
from ddh_twin_py.names import short

VERBS = ("demo", "replay", "calibrate", "gap", "gap-design", "fleet", "info", "doctor", "export", "import", "fmu", "layouts", "simulate",
         "up", "view", "paper", "study", "motor", "verify", "bench", "gap-bench", "real", "completion")
"""Verbs in the order of the help; each is a module of this package."""

_WITH_NODES = frozenset({"demo", "up", "view"})
"""Verbs that take the time that their nodes need to leave."""
_ROS = frozenset({"rclpy", "ddh_msgs", "sensor_msgs", "diagnostic_msgs", "std_srvs", "rosgraph_msgs", "rcl_interfaces"})

_EPILOG = """\
examples:
  ddh-twin demo                                   the paper's cycle through the live nodes, with a report
  ddh-twin replay bags/paper_cycle --html r.html  any recording in one process
  ddh-twin up --help                              the twin beside a machine

exit codes: """ + "; ".join(f"{code} {about}" for code, about in EXIT_CODES.items()) + "\n"


def build_parser() -> Parser:
    """The parser of all verbs."""
    parser = Parser(
        prog="ddh-twin",
        description="Digital twin of a direct driven hydraulic unit: temperatures, pressures and losses from drive and "
        "pressure telemetry.",
        epilog=_EPILOG,
    )
    parser.add_argument("--version", action="store_true", help="say versions and leave")
    subparsers = parser.add_subparsers(dest="verb", metavar="VERB", title="verbs", parser_class=Parser)
    for name in VERBS:
        import_module(_module(name)).add_parser(subparsers)
    return parser


def _module(verb: str) -> str:
    name = verb.replace("-", "_")
    return f"ddh_twin_py.cli.{name}{'_' if keyword.iskeyword(name) else ''}"


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb; returns the exit code."""
    name_standard_output()
    with Interruption("ddh-twin") as interruption:
        try:
            return _run(argv, interruption)
        except KeyboardInterrupt:
            interruption.say()
            return interruption.code
        except Exception:
            if not interruption.asked:
                raise
            interruption.say()  # what was interrupted made another error of it
            return interruption.code


def _asked(argv: Sequence[str] | None, interruption: Interruption) -> int:
    """Do what the command line says; the exit code."""
    parser = build_parser()
    args = parser.parse_args(argv)
    if args.version:
        from ddh_twin_py.report.page.document import versions

        print(", ".join(f"{name} {number}" for name, number in versions().items()))
        return 0
    if args.verb is None:
        parser.print_help()
        return 0
    interruption.name = f"ddh-twin {args.verb}"
    if args.verb in _WITH_NODES:
        interruption.release()
    return import_module(_module(args.verb)).run(args)


def _run(argv: Sequence[str] | None, interruption: Interruption) -> int:
    try:
        try:
            code = _asked(argv, interruption)
        except SystemExit as left:
            if left.code and not isinstance(left.__context__, BrokenPipeError):
                raise
            code = 0  # a help that was asked for; rich makes the other of a closed pipe
        sys.stdout.flush()  # what cannot be written is told here, not on the way out
        return code
    except BrokenPipeError:
        _write_no_more()
        return 0
    except ModuleNotFoundError as error:
        from ddh_twin_py.doctor.installation import OF_SINGLE_VERBS

        package, beside = (error.name or "").split(".")[0], {"aiohttp", *OF_SINGLE_VERBS}
        if package not in _ROS | beside:
            raise
        said = f"{error.name} is not here: run .venv/bin/ddh-twin, or source the ROS 2 workspace first"
        if package in beside:
            said = f"{package} is not here: run .venv/bin/ddh-twin, or pip install {package}"
        print(f"{interruption.name}: error: {said}", file=sys.stderr)
        return 2
    except (ValueError, OSError) as error:
        if interruption.asked:
            raise
        if not isinstance(error, OSError) and not type(error).__module__.startswith("ddh_twin_py."):
            raise  # a fault of ours and not of the input
        said = str(error)
        if isinstance(error, OSError) and error.filename and error.strerror:
            said = f"{error.filename}: {error.strerror}"
            if error.filename == STANDARD_OUTPUT:
                _write_no_more()
        from ddh_twin_py.rig.files import printable

        print(short(f"{interruption.name}: error: {printable(' '.join(said.split()))}"), file=sys.stderr)
        return 2


def _write_no_more() -> None:
    """What is still to be written to standard output goes nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
