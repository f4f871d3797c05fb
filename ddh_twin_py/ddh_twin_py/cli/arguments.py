"""Command line parsing: errors in one line with the nearest valid choice, an example in every help."""

from __future__ import annotations

import argparse
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from ddh_twin_py.names import no_such, short

_OF_BAGS = (".mcap", ".db3", ".zstd")
_BESIDE_BAGS = ("metadata.yaml", "rig.yaml")
_LONGEST_NAME = 246  # bytes; what is added to it while it is written has room below 255
_NAMESPACE = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+", re.ASCII)
_LONGEST_NAMESPACE = 180  # of the 245 that ROS has for a namespace, a topic and a node included


class InputError(ValueError):
    """What was given cannot be used; one line for people."""


class Formatter(argparse.RawDescriptionHelpFormatter):
    """Wraps descriptions, leaves examples as they are."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=30, width=min(100, shutil.get_terminal_size().columns))

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        wrap = argparse.RawDescriptionHelpFormatter if text.startswith("example") else argparse.HelpFormatter
        return wrap._fill_text(self, text, width, indent)


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def __init__(self, *args: object, **kwargs: object) -> None:
        kwargs.setdefault("formatter_class", Formatter)
        kwargs.setdefault("allow_abbrev", False)
        super().__init__(*args, **kwargs)

    def error(self, message: str) -> None:
        """Say what is wrong in one line and leave with 2."""
        from ddh_twin_py.rig.files import printable

        example = f" (how: {self.prog} --help)" if "arguments are required" in message else ""
        self.exit(2, f"{self.prog}: error: {short(printable(' '.join(message.split())))}{example}\n")

    def _print_message(self, message: str, file=None) -> None:
        if message and file is sys.stdout:
            file.write(message)  # argparse says nothing where it cannot be written
        else:
            super()._print_message(message, file)

    def _check_value(self, action: argparse.Action, value: object) -> None:
        if action.choices is None or value in action.choices:
            return
        what = "verb" if isinstance(action, argparse._SubParsersAction) else (action.metavar or action.dest).lower()
        raise argparse.ArgumentError(None, no_such(what, str(value), [str(c) for c in action.choices]))

    def parse_args(self, args=None, namespace=None) -> argparse.Namespace:
        """Parse; an option that no parser knows is an error that names the nearest one."""
        found, extra = self.parse_known_args(args, namespace)
        if extra:
            parser = self.verb_parser(found)
            option = next((given for given in extra if given.startswith("-")), None)
            if option is None:
                parser.error(f"argument {extra[0]!r} is one too many")
            valid = [name for name in parser._option_string_actions if name.startswith("--")]
            parser.error(no_such("option", option.split("=")[0], valid))
        verb = self.verb_parser(found)
        verb.refuse_twice(found)
        verb.refuse_inputs(found)
        return found

    def verb_parser(self, found: argparse.Namespace) -> Parser:
        """The parser of the verb that was given, this one where there is none."""
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                return action.choices.get(getattr(found, action.dest, None), self)
        return self

    def refuse_twice(self, found: argparse.Namespace) -> None:
        """One path for two outputs, or one that lies in another, is an error: it would overwrite the first, or be written into it."""
        taken: dict[str, str] = {}
        for action in self._actions:
            given = getattr(found, action.dest, None)
            if action.type not in OUTPUTS or not isinstance(given, str):
                continue
            name = action.option_strings[-1] if action.option_strings else action.metavar
            path = given if given == "-" else os.path.realpath(given)
            if path in taken:
                self.error(f"{taken[path]} and {name} both write to {given!r}; give each a path of its own")
            taken[path] = name
        for path, name in taken.items():
            if around := next((str(one) for one in Path(path).parents if str(one) in taken), None):
                self.error(f"{name} would write {path!r} into what {taken[around]} writes as a whole; give each a path of its own")

    def refuse_inputs(self, found: argparse.Namespace) -> None:
        """An output that is one of the inputs is an error: it would be lost, and a bag with it."""
        given = {action: getattr(found, action.dest, None) for action in self._actions}
        read = [value for action, values in given.items() if action.type not in OUTPUTS
                for value in (values if isinstance(values, list) else [values]) if isinstance(value, str) and value]
        for action, value in given.items():
            source = next((s for s in read if reads(s, value)), "") if action.type in OUTPUTS and isinstance(value, str) else ""
            if source:
                name = action.option_strings[-1] if action.option_strings else action.metavar
                self.error(f"{name} would overwrite {value!r}, an input of this run ({source}); give it a path of its own")


def reads(given: str, written: str) -> bool:
    """Whether what an argument reads, a file or a folder of recordings however deep, is or holds the file that is to be written.

    One file of a bag stands for the whole of it.
    """
    try:
        path = Path(given)
        if path.is_file():
            if os.path.realpath(path) == os.path.realpath(written):
                return True
            if path.suffix not in _OF_BAGS or not (path.parent / "metadata.yaml").is_file():
                return False
            path = path.parent
        file = Path(os.path.realpath(written))
        of_a_bag = file.suffix in _OF_BAGS or file.name in _BESIDE_BAGS
        if not (of_a_bag and file.is_file() and path.is_dir()):
            return False
        return any(Path(way(path)) in Path(way(written)).parents for way in (os.path.abspath, os.path.realpath))
    except (OSError, ValueError):
        return False


def add_verb(subparsers, name: str, help: str, description: str, example: str) -> Parser:
    """A verb's parser with a description and an example below its options."""
    return subparsers.add_parser(name, help=help, description=description, epilog=f"example:\n{example}")


def positive(text: str) -> float:
    """A number above 0."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is no number above 0")
    return value


def seed(text: str) -> int:
    """A whole number from 0 on that a node's parameter can hold."""
    if not text.strip().isdecimal() or len(text.strip()) > 18:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is no whole number from 0 on of at most 18 digits")
    return int(text)


def whole(lowest: int, highest: int) -> Callable[[str], int]:
    """A whole number within bounds."""

    def parse(text: str) -> int:
        if not (text.strip().isdecimal() and len(text.strip()) < 20) or not lowest <= int(text) <= highest:
            raise argparse.ArgumentTypeError(f"{text!r} is no whole number from {lowest} to {highest}")
        return int(text)

    return parse


def between(lowest: float, highest: float, unit: str = "") -> Callable[[str], float]:
    """A number within bounds."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not lowest <= value <= highest:
            raise argparse.ArgumentTypeError(f"{text!r} is no number from {lowest:g} to {highest:g} {unit}".rstrip())
        return value

    return parse


RATE = between(0.0, 10000.0)
"""Speed of a source against real time; 0 is as fast as it goes."""


def output_file(text: str) -> str:
    """A file that can be written, looked at before anything is computed; its folder need not exist."""
    from ddh_twin_py.rig.files import why_no_file

    path = Path(text)
    try:
        if text.endswith(("/", os.sep)) or path.is_dir():
            raise argparse.ArgumentTypeError(f"{text!r} is a folder and no file")
        if path.exists() and not path.is_file():
            raise argparse.ArgumentTypeError(f"{text!r} is no regular file")
        if len(os.fsencode(path.name)) > _LONGEST_NAME:
            raise argparse.ArgumentTypeError(f"{text!r} is too long a name")
        there = path.absolute().parent
        while not there.exists():
            if there.is_symlink():
                raise argparse.ArgumentTypeError(f"{text!r} cannot be written: {there} points to nothing")
            there = there.parent
    except OSError as error:
        raise argparse.ArgumentTypeError(f"{text!r} cannot be written: {error.strerror}") from None
    if not there.is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} cannot be written: {there} is no folder")
    if why := why_no_file(there):
        raise argparse.ArgumentTypeError(f"{text!r} cannot be written: {there}: {why}")
    return text


def refuse_missing(name: str, path: str | Path) -> None:
    """Raise InputError, with the nearest that is there, where an input does not exist."""
    from ddh_twin_py.rig.files import did_you_mean

    if not Path(path).exists():
        raise InputError(f"{name}: there is no {path}{did_you_mean(path)}")


def refuse_unwritable(name: str, folder: Path, files: Iterable[Path]) -> None:
    """Raise InputError where a folder for results is none, or one of the files in it cannot be written; before anything is computed."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{name}: {folder} is no folder")
    for path in files:
        try:
            output_file(str(path))
        except argparse.ArgumentTypeError as error:
            raise InputError(f"{name}: {error}") from None


def refuse_same(name: str, own: Iterable[str | Path], given: Mapping[str, str | Path | None]) -> None:
    """Raise InputError where a file of ``given``, option to path, is one that ``name`` writes, or lies in a folder that it fills: it
    would overwrite what is there."""
    there = {Path(os.path.realpath(path)) for path in own}
    for option, path in given.items():
        if path is None or str(path) == "-":
            continue
        file = Path(os.path.realpath(path))
        if not there.isdisjoint((file, *file.parents)):
            raise InputError(f"{option} and {name} both write to {str(path)!r}; give each a path of its own")


def refuse_recording(name: str, folder: Path) -> None:
    """Raise InputError where a folder for results is a recording, a bag or a case of bags, or lies in a rosbag2 folder."""
    from ddh_twin_py.bags.case import is_case
    from ddh_twin_py.bags.folder import METADATA, holds_bag

    if holds_bag(folder) or is_case(folder):
        raise InputError(f"{name}: {folder} is a recording, nothing is written into it; give a folder of its own")
    if around := next((one for one in folder.absolute().parents if (one / METADATA).is_file()), None):
        raise InputError(f"{name}: {folder} lies in the recording {around}, nothing is written into it; give a folder of its own")


def new_folder(text: str) -> str:
    """A folder that does not exist yet and can be made."""
    if os.path.lexists(text.rstrip(os.sep) or text):
        raise argparse.ArgumentTypeError(f"{text!r} exists; nothing is overwritten")
    return output_file(text.rstrip(os.sep))


def kept_file(text: str) -> str:
    """A file that is read where it is there, and else made."""
    return text if os.path.isfile(text) else output_file(text)


def json_file(text: str) -> str:
    """The same, or `-` for standard output."""
    return text if text == "-" else output_file(text)


def named_file(text: str) -> str:
    """A name that is not empty; whether there is such a file or folder says who reads it."""
    if not text.strip():
        raise argparse.ArgumentTypeError("an empty name of a file or folder")
    return text


OUTPUTS = frozenset({output_file, kept_file, new_folder, json_file})
"""Types of arguments that something is written to."""


def add_html(parser: Parser, help: str = "write the report, one self-contained page") -> None:
    """The option `--html`."""
    parser.add_argument("--html", metavar="FILE", type=output_file, help=help)


def add_rig(parser: Parser) -> None:
    """The option `--rig`."""
    parser.add_argument("--rig", metavar="FILE", type=named_file, help="rig file with what differs from the reference sheet")


def add_namespace(parser: Parser) -> None:
    """The option `--namespace`."""
    parser.add_argument("--namespace", metavar="NS", help="of the rig, where a bag holds more than one")


def add_json(parser: Parser, help: str = "write the numbers as JSON; - is standard output") -> None:
    """The option `--json`."""
    parser.add_argument("--json", metavar="FILE", type=json_file, help=help)


def add_bag(parser: Parser) -> None:
    """The argument `BAG`."""
    parser.add_argument("bag", metavar="BAG", type=named_file, help="rosbag2 folder, or one .mcap or .db3 file")


def add_interval(parser: Parser) -> None:
    """The option `--interval`, s; None where it is not given."""
    parser.add_argument(
        "--interval", metavar="S", type=between(0.01, 0.2, "s"), default=None,
        help="tick of the twin, over which it integrates and takes means, 0.01 to 0.2 s (default 0.05); no thinning of what is written",
    )


def add_quiet(parser: Parser, help: str = "no progress, no summary") -> None:
    """The option `--quiet`."""
    parser.add_argument("--quiet", action="store_true", help=help)


def namespace(given: str) -> str:
    """A namespace as ROS wants it; raises InputError where it would not take it."""
    name = "/" + given.strip("/")
    if name != "/" and not _NAMESPACE.fullmatch(name):
        raise InputError(
            f"--namespace is {given!r}; allowed are names of letters, digits and _, not beginning with a digit, joined by /"
        )
    if len(name) > _LONGEST_NAMESPACE:
        raise InputError(f"--namespace has {len(name)} characters, allowed are {_LONGEST_NAMESPACE}")
    return name
