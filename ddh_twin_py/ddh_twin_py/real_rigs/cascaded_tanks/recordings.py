"""Recordings of the cascaded tanks benchmark: one file with an identification and a test record."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.real_rigs.study import RecordingsError

SOURCE = ("Schoukens, Noël: Three benchmarks addressing open challenges in nonlinear system identification, IFAC World Congress 2017; "
          "CC BY-SA 4.0; nonlinearbenchmark.org")
FOLDER, FILE = "cascaded_tanks", "dataBenchmark.csv"
IDENTIFICATION, TEST = "Est", "Val"
STEP = 4.0
"""s between samples."""
LEAST = 100
"""Samples of a record: some minutes, as long as the tanks' own time constants."""


@dataclass(frozen=True)
class TankRecord:
    """One recording: voltage of the pump and of the lower tank's level sensor, V, (n,) each. ``name``: for people."""

    name: str
    pump: np.ndarray
    level: np.ndarray


def present(data: Path) -> bool:
    """Whether the recordings are there."""
    return (data / FOLDER / FILE).is_file()


def read(data: Path, part: str) -> TankRecord:
    """One of `IDENTIFICATION` and `TEST` from the folder ``cascaded_tanks`` of ``data``; nothing of the other is looked at.

    Raises:
        RecordingsError: the file is not there, a column is missing, too short, or holds what is no number.
    """
    path = data / FOLDER / FILE
    if not path.is_file():
        raise RecordingsError(f"{path}: no such file; the set is at nonlinearbenchmark.org (cascaded tanks)")
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    names = [name.strip().strip('"') for name in lines[0].split(",")] if lines else []
    columns = []
    for wanted in (f"u{part}", f"y{part}"):
        if wanted not in names:
            raise RecordingsError(f"{path}: column {wanted} is missing; there are {', '.join(n for n in names if n) or 'none'}")
        place = names.index(wanted)
        cells = [line.split(",")[place] if line.count(",") >= place else "" for line in lines[1:] if line.strip()]
        wrong = next((i for i, cell in enumerate(cells) if not _is_number(cell)), None)
        if wrong is not None:
            raise RecordingsError(f"{path}: column {wanted}, row {wrong + 1}: {cells[wrong]!r} is no number")
        if len(cells) < LEAST:
            raise RecordingsError(f"{path}: column {wanted} has {len(cells)} rows, needed are {LEAST} or more")
        columns.append(np.array([float(cell) for cell in cells]))
    return TankRecord(f"{FILE}, u{part} and y{part}", *columns)


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
