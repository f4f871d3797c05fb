"""YAML files that people write: read with an error of one line that says where and what."""

from __future__ import annotations

from pathlib import Path

import yaml

from ddh_twin_py.rig.files import did_you_mean, no_regular_file
from ddh_twin_py.rig.unique_keys import DuplicateKeyError, EndlessError, SurrogateError, read_unique

LARGEST_FILE = 1_000_000
"""Bytes; the reference sheet has a few ten thousand."""


def read_yaml(path: str | Path, kind: str, error: type[ValueError]) -> object:
    """What a file holds.

    Args:
        path: the file. kind: what it is, such as ``rig file``, for the message. error: what to raise.

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
    return parse_yaml(text, str(path), error)


def parse_yaml(text: str, name: str, error: type[ValueError]) -> object:
    """What a text holds; ``name`` is put before what is wrong, see `read_yaml`."""
    try:
        return read_unique(text)
    except (DuplicateKeyError, EndlessError, SurrogateError) as cause:
        raise error(f"{name}: {cause}") from None
    except yaml.YAMLError as cause:
        mark = getattr(cause, "problem_mark", None)
        raise error(f"{name}: is not YAML{f' (line {mark.line + 1})' if mark else ''}") from None
    except RecursionError:
        raise error(f"{name}: is nested too deep to be read") from None
    except ValueError as cause:  # such as an impossible date
        raise error(f"{name}: is not YAML: {cause}") from None
