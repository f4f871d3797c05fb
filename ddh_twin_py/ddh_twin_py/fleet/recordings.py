"""Finds the recordings below a folder: cases with field/, and single bags."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ddh_twin_py.bags.case import COMMISSIONING, FIELD, VALIDATION, Case, case_of, is_case
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.folder import DATA_ENDINGS, METADATA, holds_bag
from ddh_twin_py.fleet.below import below
from ddh_twin_py.fleet.copies import alike
from ddh_twin_py.rig.files import did_you_mean
from ddh_twin_py.sources.raw_bag import RawBag

_PART = re.compile(rf"(.*)_(\d+)(?:{'|'.join(map(re.escape, DATA_ENDINGS))})")
REFERENCE = "reference sheet"
"""What a recording is held against without a rig file; where several are given, ``: `` and why follow."""
_BETWEEN = -0.5, 5.0  # s of log time from the end of one part of a bag to the begin of the next


class FleetError(ValueError):
    """A fleet cannot be looked at; one line for people."""


@dataclass(frozen=True)
class Found:
    """One recording to diagnose: its name, which is its path below the folder, and its case; `refused` says why it is none, `copies` are
    names of others with the same content, `rigs` rig ids and files of several rigs, of which the case has none yet (`of_rig`)."""

    name: str
    case: Case
    refused: str = ""
    copies: tuple[str, ...] = ()
    rigs: tuple[tuple[str, Path], ...] = ()

    def of_rig(self, rig_id: str) -> Found:
        """The same with the file of the rig that it names, of several; without one, the reference sheet, where there is none."""
        return replace(self, case=replace(self.case, rig=dict(self.rigs).get(rig_id)), rigs=()) if self.rigs else self

    def sheet(self, rig_id: str) -> str:
        """What it is held against, as the recording of that rig: a rig file, or the reference sheet, and why where several are given."""
        if file := self.of_rig(rig_id).case.rig:
            return str(file)
        why = f"none of the rig files is of {rig_id}" if rig_id else "the recording names no rig"
        return f"{REFERENCE}: {why}" if self.rigs else REFERENCE


def find_recordings(folder: str | Path, leave_out: Path | None = None, rig: Path | None = None,
                    rigs: Mapping[str, Path] | None = None) -> list[Found]:
    """Every recording below a folder, sorted by name, to be held against one rig file, or that of several, by rig id, that it names.

    A folder that holds field/ and is no bag is one case, whatever else lies in it; one with a bag commissioning/ or validation/ and without
    field/ is a case that is refused. A rosbag2 folder is one recording, as are .mcap and .db3 files that belong to no bag, and a folder
    that cannot be looked into. Files NAME_0, NAME_1 ... without metadata.yaml are one bag where the folder has that name, as rosbag2 gives
    it, or where each goes on in time where the one before ends. Hidden folders, and `leave_out`, are not looked into; links are followed,
    and what is reached twice counts once, as do copies (`copies.alike`), under the first of their names.

    Raises:
        FleetError: there is no such folder, it is a file, no recording in it, it is `leave_out` itself, or it is a case without field/.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        such = f", such as {folder.parent}" if _holds_recordings(folder.parent) else ""
        raise FleetError(f"{folder}: is a file; give a folder of recordings{such}")
    if not folder.is_dir():
        raise FleetError(f"{folder}: there is no such folder{did_you_mean(folder)}")
    found: list[Found] = []
    closed: list[Path] = []
    if leave_out is not None and leave_out.resolve() == folder.resolve():
        raise FleetError(f"{folder}: recordings and results are in the same folder; give --out a folder of its own")
    for path, folders, files in below(folder, lambda error: closed.append(Path(error.filename))):
        if leave_out is not None and path.resolve() == leave_out.resolve():
            folders.clear()
            continue
        paths = [path] if _one_case(path) else _bags(path, files)
        found += [_found(p.relative_to(folder).as_posix() if p != folder else folder.resolve().name, p, rig) for p in paths]
        if path == folder and found and found[0].refused and _one_case(path):
            raise FleetError(found[0].refused)
        if path in paths:
            folders.clear()
        folders[:] = [name for name in folders if not name.startswith(".")]
    found += [_found(p.relative_to(folder).as_posix(), p, rig) for p in closed]
    if not found:
        raise FleetError(f"{folder}: holds no recording, neither a folder with field/, nor a rosbag2 folder, nor a .mcap or .db3 file")
    return [replace(one, rigs=tuple((rigs or {}).items())) for one in _without_copies(_once(found))]


def _holds_recordings(folder: Path) -> bool:
    """Whether a bag or a case lies in a folder itself, or in one that lies in it."""
    try:
        return is_case(folder) or holds_bag(folder) or any(is_case(path) or holds_bag(path) for path in folder.iterdir())
    except OSError:
        return False


def _once(found: list[Found]) -> list[Found]:
    """Every recording once, sorted by name: of links to a file that is found by its own name too, or by another link, that alone."""
    first: dict[tuple, Found] = {}
    for one in sorted(found, key=lambda f: (f.case.field[0].is_symlink(), f.name)):
        case = one.case
        first.setdefault(tuple(part and os.path.realpath(part) for part in (*case.field, case.commissioning, case.validation)), one)
    return sorted(first.values(), key=lambda f: f.name)


def _without_copies(found: list[Found]) -> list[Found]:
    """Of copies of one recording the first, with the names of the others."""
    named = {one.name: one for one in found}
    groups = alike({name: one.case for name, one in named.items() if not one.refused})
    copies = {first: tuple(others) for first, *others in groups}
    gone = {name for others in copies.values() for name in others}
    return [replace(one, copies=copies.get(name, ())) for name, one in named.items() if name not in gone]


def _one_case(path: Path) -> bool:
    """Whether a folder is a case: with field/, or without it and with a bag where the rig as built or another duty would be."""
    return is_case(path) and ((path / FIELD).is_dir() or any(holds_bag(path / role) for role in (COMMISSIONING, VALIDATION)))


def _found(name: str, path: Path, rig: Path | None) -> Found:
    """The recording at a path; of one that cannot be used too, so that its row says why."""
    try:
        return Found(name, case_of([path], rig=rig))
    except BagError as error:
        return Found(name, Case((path,), rig=rig), str(error))


def _bags(path: Path, files: list[str]) -> list[Path]:
    """The folder itself where it is a bag, or the bag files that lie in it by themselves."""
    data = sorted(name for name in files if name.endswith(DATA_ENDINGS))
    if METADATA in files:
        return [path]
    parts = [part for name in data if (part := _PART.fullmatch(name))]
    stems, numbers = {part[1] for part in parts}, [int(part[2]) for part in parts]
    if len(parts) == len(data) > 1 and len(stems) == 1 and (
            stems == {path.resolve().name} and min(numbers) == 0 or _follow([path / data[i] for i in np.argsort(numbers)])):
        return [path]  # the parts of one bag whose recorder was stopped hard
    return [path / name for name in data]


def _follow(files: list[Path]) -> bool:
    """Whether each file goes on by its log times where the one before it ends."""
    spans = []
    try:
        for file in files:
            with closing(RawBag(file)) as bag:
                spans.append((bag.first_ns, bag.last_ns))
    except (BagError, OSError):
        return False
    least, most = _BETWEEN
    return all(least <= (begin - end) * 1e-9 <= most for (_, end), (begin, _) in itertools.pairwise(spans))
