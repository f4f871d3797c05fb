"""The results of a fleet on disk: one file for each recording, so that a run goes on where it was cut off."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from ddh_twin_py.fleet.recordings import Found
from ddh_twin_py.fleet.row import Row, kept_row
from ddh_twin_py.rig.files import read_json, write_whole

_VERSION = 2
_UNSAFE = re.compile(r"[^A-Za-z0-9._-]+")


class Results:
    """Files below a folder; each holds the row and the whole report of one recording."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)

    def path(self, name: str) -> Path:
        """Of a recording's file: readable, and no two recordings share one."""
        return self.folder / f"{_UNSAFE.sub('-', name)[:80]}-{hashlib.sha256(os.fsencode(name)).hexdigest()[:10]}.json"

    def finished(self, found: Found) -> Row | None:
        """The row of a recording that was diagnosed as it is now, with its rig file; None where it was not, or the file is damaged or holds
        something else."""
        try:
            content = read_json(self.path(found.name))
            if content["version"] == _VERSION and content["recording"] == found.name:
                row = kept_row(content["row"])
                return row if row.recording == found.name and content["input"] == fingerprint(found.of_rig(row.rig)) else None
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            pass
        return None

    def keep(self, found: Found, before: Mapping[str, str], row: Row, report: dict) -> None:
        """Write a recording's result, whole or not at all. Raises OSError.

        Args:
            before: its `fingerprints` before it was diagnosed; one that changed meanwhile is not finished then.
        """
        unchanged = before.get(row.rig, before[""])
        content = {"version": _VERSION, "recording": found.name, "input": unchanged, "row": asdict(row), "report": report}
        write_whole(self.path(found.name), json.dumps(content, indent=1) + "\n")


def fingerprints(found: Found) -> dict[str, str]:
    """By the rig that it may name: which of several rig files is its own is known once it is read. '' is any other rig."""
    return {rig_id: fingerprint(found.of_rig(rig_id)) for rig_id in ("", *dict(found.rigs))}


def fingerprint(found: Found) -> str:
    """Changes with the name, size or time of writing of any file of the case."""
    case, digest = found.case, hashlib.sha256()
    for part in (*case.field, case.commissioning, case.validation, case.rig):
        try:
            files = [part] if part is None or part.is_file() else sorted(p for p in part.rglob("*") if p.is_file())
        except OSError:
            files = [part]
        for file in files:
            digest.update(os.fsencode(f"{file and file.resolve()}\0{_state(file)}\n"))
    return digest.hexdigest()


def _state(file: Path | None) -> tuple[int, int] | None:
    """Size and time of writing; None of no file, and of one that is gone or cannot be looked at."""
    try:
        stat = file.stat() if file is not None else None
    except OSError:
        return None
    return (stat.st_size, stat.st_mtime_ns) if stat else None
