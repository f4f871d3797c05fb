"""A case: up to three bags of one rig, given one by one or as a folder that holds them, and perhaps the rig's file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.folder import METADATA, SUFFIXES
from ddh_twin_py.rig.files import did_you_mean, no_regular_file

COMMISSIONING, FIELD, VALIDATION = "commissioning", "field", "validation"
"""Folders of a case: the rig as built, the rig in question, the same on another duty."""

_LONGEST = 255  # characters of a path that are said


@dataclass(frozen=True)
class Case:
    """Bags of one rig; ``field`` has at least one, the others may be None. ``rig``: its file, None is the reference sheet."""

    field: tuple[Path, ...]
    commissioning: Path | None = None
    validation: Path | None = None
    rig: Path | None = None


def case_of(given: Sequence[str | Path], commissioning: str | Path | None = None, validation: str | Path | None = None,
            rig: str | Path | None = None) -> Case:
    """The bags of a case.

    Args:
        given: field bags, or case folders whose ``commissioning``, ``field`` and ``validation`` are found by themselves.
        commissioning, validation: bags; they stand before what a case folder holds. rig: file of the rig.

    Raises:
        BagError: no field recording, no such path, a case folder without ``field``, two case folders
            with a commissioning or validation bag, a folder of cases, one bag given twice, or a path that the system does not take.
    """
    if not given or not all(str(p) for p in given):
        raise BagError(f"{FIELD} is {[str(p) for p in given]}; allowed is one or more paths of bags or case folders, none empty")
    field: list[Path] = []
    found: dict[str, Path | None] = {
        COMMISSIONING: None if commissioning is None else _there(commissioning),
        VALIDATION: None if validation is None else _there(validation),
    }
    told = {role for role, path in found.items() if path is not None}
    for path in (_there(p) for p in given):
        if not is_case(path):
            _refuse_many(path)
            field.append(path)
            continue
        if not (path / FIELD).exists():
            inside = ", ".join(role for role in (COMMISSIONING, VALIDATION) if (path / role).exists())
            raise BagError(f"{path} is a case folder without {FIELD}: it holds {inside}; a case needs {FIELD}/ with the rig in question")
        field.append(path / FIELD)
        for role in (COMMISSIONING, VALIDATION):
            if role in told or not (path / role).exists():
                continue
            if found[role] is not None:
                raise BagError(f"{path / role}: a second {role} bag beside {found[role]}; name the one to use with --{role}")
            found[role] = path / role
    _refuse_twice([*field, *(p for p in found.values() if p is not None)])
    try:
        if rig is not None and not Path(rig).exists():
            raise BagError(f"rig file {_named(rig)} does not exist{did_you_mean(rig)}")
        if rig is not None and (what := no_regular_file(rig)):
            raise BagError(f"rig file {rig} is {what}, a regular file is needed")
    except OSError as error:
        raise BagError(f"rig file {_short(rig)}: {error.strerror}") from None
    return Case(tuple(field), found[COMMISSIONING], found[VALIDATION], None if rig is None else Path(rig))


def _there(path: str | Path) -> Path:
    path = Path(path)
    try:
        there = path.exists()
    except OSError as error:
        raise BagError(f"{_short(path)}: {error.strerror}") from None
    if not there:
        raise BagError(f"{_named(path)} does not exist{did_you_mean(path) or '; a bag is a rosbag2 folder or one .mcap or .db3 file'}")
    return path


def _named(path: str | Path) -> str:
    """A path for an error; in quotes, and what cannot be seen spelled out, where it would else read like another one (a line break)."""
    text = str(path)
    return text if text.isprintable() and text == " ".join(text.split()) else repr(text)


def _short(path: str | Path) -> str:
    """A path for an error, cut where it is longer than any that the system takes."""
    text = str(path)
    return text if len(text) <= _LONGEST else f"{text[:60]}... ({len(text)} characters)"


def is_case(path: Path) -> bool:
    """Whether a folder is no bag itself and has one of the three folders; loose bag files beside ``field`` are no part of it."""
    if not path.is_dir() or (path / METADATA).is_file():
        return False
    if (path / FIELD).is_dir():
        return True
    return any((path / role).is_dir() for role in (COMMISSIONING, VALIDATION)) and not any(p.suffix in SUFFIXES for p in path.iterdir())


def _refuse_many(path: Path) -> None:
    if not path.is_dir() or (path / METADATA).is_file() or not os.access(path, os.R_OK | os.X_OK):
        return
    if inside := sorted(p for p in path.iterdir() if is_case(p)):
        raise BagError(f"{path} holds no bag itself but cases, {len(inside)} of them, the first is {inside[0].name}; name one, or ask "
                       f"ddh-twin fleet {path} about all")


def _refuse_twice(paths: Sequence[Path]) -> None:
    seen: dict[Path, Path] = {}
    for path in paths:
        same = seen.setdefault(path.resolve(), path)
        if same is not path:
            raise BagError(f"{same} and {path} are the same bag; its samples would count twice")
