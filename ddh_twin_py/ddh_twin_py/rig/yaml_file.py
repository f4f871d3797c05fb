"""YAML files that people write: read with an error of one line that says where and what."""

from __future__ import annotations

from datetime import date
from pathlib import Path

import yaml

from ddh_twin_py.names import cited
from ddh_twin_py.rig.files import did_you_mean, no_regular_file
from ddh_twin_py.rig.unique_keys import DuplicateKeyError, EndlessError, Loader, SurrogateError, read_unique
from ddh_twin_py.rig.yaml_fault import fault

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
        text = decoded(Path(path).read_bytes())
    except FileNotFoundError:
        raise error(f"{path}: no such {kind}{did_you_mean(path)}") from None
    except OSError as cause:
        raise error(f"{path}: cannot be read as a {kind}: {cause.strerror}") from None
    except UnicodeError as cause:
        raise error(f"{path}: cannot be read as a {kind}: {cause}") from None
    return parse_yaml(text, str(path), error, loader)


def decoded(content: bytes) -> str:
    """The text that a file holds, with line ends as YAML has them.

    Raises:
        UnicodeError: it is no UTF-8; the message says where.
    """
    try:
        return content.decode("utf-8").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as cause:
        if content.startswith((b"\xff\xfe", b"\xfe\xff")):
            raise UnicodeError("it is UTF-16, UTF-8 is needed") from None
        line = content.count(b"\n", 0, cause.start) + 1
        raise UnicodeError(f"it is no UTF-8: line {line} holds the byte 0x{content[cause.start]:02x}; save it as UTF-8") from None


def parse_yaml(text: str, name: str, error: type[ValueError], loader: type[Loader] = Loader) -> object:
    """What a text holds; ``name`` is put before what is wrong, see `read_yaml`."""
    try:
        return read_unique(text, loader)
    except (DuplicateKeyError, EndlessError, SurrogateError) as cause:
        raise error(f"{name}: {cause}") from None
    except yaml.YAMLError as cause:
        line, why = fault(cause, text)
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
    held = "is empty" if tree is None else f"holds {'a list' if isinstance(tree, list) else cited(tree)}"
    raise error(f"{name}: {held}; a {kind} is a mapping of {entries}")


def shown(value: object) -> str:
    """A value of a file as it is told: that there is none, or what it is."""
    return "nothing" if value is None else str(value) if isinstance(value, date) else cited(value)
