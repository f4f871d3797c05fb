"""Which recordings are copies of one another: the same bytes in their data files, under whatever names."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable, Mapping
from pathlib import Path

from ddh_twin_py.bags.case import Case
from ddh_twin_py.bags.folder import DATA_ENDINGS


def alike(cases: Mapping[str, Case]) -> list[list[str]]:
    """Names of cases, those with the same content together, in the order in which they are given.

    Of two copies every bag in its role has data files of the same sizes and SHA-256, in order of their names; files are read where sizes
    agree alone. What holds no data, or cannot be read, is no copy of anything.
    """
    groups: list[list[str]] = []
    for same_size in _grouped(list(cases), lambda name: _of_all(cases[name], lambda file: file.stat().st_size)):
        groups += [same_size] if len(same_size) == 1 else _grouped(same_size, lambda name: _of_all(cases[name], _digest))
    order = {name: i for i, name in enumerate(cases)}
    return sorted(groups, key=lambda group: order[group[0]])


def _grouped(names: list[str], key: Callable[[str], Hashable]) -> list[list[str]]:
    """Names with the same key together; those without one by themselves."""
    groups: dict[Hashable, list[str]] = {}
    for name in names:
        told = key(name)
        groups.setdefault((name,) if told is None else (told, ""), []).append(name)
    return list(groups.values())


def _of_all(case: Case, of: Callable[[Path], Hashable]) -> Hashable:
    """What ``of`` says of the data files of each bag; None where a file cannot be read, or the field recordings hold nothing."""
    bags = (*case.field, case.commissioning, case.validation)
    try:
        files = [None if bag is None else _data(bag) for bag in bags]
        if not any(file.stat().st_size for part in files[: len(case.field)] for file in part):
            return None
        return tuple(None if part is None else tuple(map(of, part)) for part in files)
    except OSError:
        return None


def _data(bag: Path) -> list[Path]:
    """The data files of a bag, which may be one itself."""
    return [bag] if bag.is_file() else sorted(file for file in bag.iterdir() if file.name.endswith(DATA_ENDINGS) and file.is_file())


def _digest(file: Path) -> bytes:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").digest()
