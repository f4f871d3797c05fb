"""YAML files that people write: read with an error of one line that says where and what."""

from __future__ import annotations

import re
from pathlib import Path

import yaml

from ddh_twin_py.rig.files import did_you_mean, no_regular_file
from ddh_twin_py.rig.unique_keys import DuplicateKeyError, EndlessError, Loader, SurrogateError, read_unique

_CLINGS = re.compile(r"\s*[\w.]+:[^\s/]")  # a name and its value without the blank between them, no address
LARGEST_FILE = 1_000_000
"""Bytes; the reference sheet has a few ten thousand."""


def read_yaml(path: str | Path, kind: str, error: type[ValueError], loader: type[Loader] = Loader) -> object:
    """What a file holds.

    Args:
        path: the file. kind: what it is, such as ``rig file``, for the message. error: what to raise. loader: how values are read.

    Raises:
        error: file missing, not readable, no regular file or larger than `LARGEST_FILE`, not YAML, a key given twice, an alias to what
            it lies in, or a lone surrogate.
    """
    try:
        if (found := no_regular_file(path)) not in ("", "a folder"):
            raise error(f"{path}: cannot be read as a {kind}: it is {found}, a regular file is needed")
        if (size := Path(path).stat().st_size) > LARGEST_FILE:
            raise error(f"{path}: cannot be read as a {kind}: it has {size} bytes, allowed are {LARGEST_FILE}")
        text = Path(path).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise error(f"{path}: no such {kind}{did_you_mean(path)}") from None
    except OSError as cause:
        raise error(f"{path}: cannot be read as a {kind}: {cause.strerror}") from None
    except UnicodeDecodeError as cause:
        raise error(f"{path}: cannot be read as a {kind}: {cause}") from None
    return parse_yaml(text, str(path), error, loader)


def parse_yaml(text: str, name: str, error: type[ValueError], loader: type[Loader] = Loader) -> object:
    """What a text holds; ``name`` is put before what is wrong, see `read_yaml`."""
    try:
        return read_unique(text, loader)
    except (DuplicateKeyError, EndlessError, SurrogateError) as cause:
        raise error(f"{name}: {cause}") from None
    except yaml.YAMLError as cause:
        line, why = _fault(cause, text)
        raise error(f"{name}: is not YAML (line {line}): {why}") from None
    except RecursionError:
        raise error(f"{name}: is nested too deep to be read") from None


def mapping(tree: object, name: str, kind: str, error: type[ValueError], entries: str = "entries") -> dict:
    """What `read_yaml` gave, where it is a mapping.

    Args:
        tree: what the file holds. name: of the file. kind: what it is. error: what to raise. entries: what it is a mapping of.

    Raises:
        error: the file is empty, or holds something else.
    """
    if isinstance(tree, dict):
        return tree
    held = "is empty" if tree is None else f"holds {'a list' if isinstance(tree, list) else repr(tree)}"
    raise error(f"{name}: {held}; a {kind} is a mapping of {entries}")


def shown(value: object) -> str:
    """A value of a file as it is told: that there is none, or what it is."""
    return "nothing" if value is None else repr(value)


def _fault(cause: yaml.YAMLError, text: str) -> tuple[int, str]:
    """The line of a mistake, counted from 1 and none behind the last that holds something, and what it is."""
    if isinstance(cause, yaml.reader.ReaderError):
        return text.count("\n", 0, cause.position) + 1, f"it holds the character {chr(cause.character)!r}"
    problem, mark = cause.problem, cause.problem_mark
    if problem == "could not find expected ':'":  # told of the line after
        mark, problem = cause.context_mark, "a ':' is missing"
    elif cause.context == "while scanning a quoted scalar":
        mark, problem = cause.context_mark, "a quote is not closed"
    elif cause.context in ("while parsing a flow sequence", "while parsing a flow mapping"):
        problem = f"a bracket is not closed, or a comma is missing by line {_line(mark, text)}"
        mark = cause.context_mark
    elif problem == "expected the node content, but found '<stream end>'":
        problem = "a bracket is not closed"
    elif problem == "found character '\\t' that cannot start any token":
        problem = "there is a tab where blanks are needed"
    elif problem.endswith("that cannot start any token"):
        problem = f"{problem.removeprefix('found ').removesuffix(' that cannot start any token')} begins no value; put it in quotes"
    elif problem == "but found another document":
        problem = "a second document begins"
    elif problem == "mapping values are not allowed here" and _CLINGS.match(text.splitlines()[mark.line - 1] if mark.line else ""):
        return mark.line, "a blank is missing after the ':'"
    elif problem == "mapping values are not allowed here":
        problem = "there is a ':' too many, or a line is indented too far"
    return _line(mark, text), problem


def _line(mark: yaml.Mark, text: str) -> int:
    return min(mark.line, text.rstrip().count("\n")) + 1
