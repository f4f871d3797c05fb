"""Reads the record of the ZeMA rig: 60 s cycles of 17 signals, one value a second."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.real_rigs.archives import arrays
from ddh_twin_py.real_rigs.study import RecordingsError

SECONDS = 60
"""Samples of a cycle, one a second."""
MEASURED = {"PS1": "bar", "PS2": "bar", "PS3": "bar", "PS4": "bar", "PS5": "bar", "PS6": "bar", "EPS1": "W", "FS1": "L/min", "FS2": "L/min",
            "TS1": "degC", "TS2": "degC", "TS3": "degC", "TS4": "degC"}
"""Signals that are evidence, with their units; the virtual ones CE, CP and SE are computed from these and are none."""
_POSITIVE = ("PS1", "PS2", "FS1", "FS2", "EPS1")
_LEAST, _STRETCH = 30, 3  # cycles of a record, and in a row in best condition
WHERE = ("UCI Machine Learning Repository, set 447 \"Condition monitoring of hydraulic systems\" (Helwig, Pignanelli, Schütze 2015); one "
         "value a second as sensors_1hz.npz, arrays (cycles, 60), beside it calibration_cycles.txt with the cycles in best condition")


@dataclass(frozen=True)
class Record:
    """The whole record.

    Attributes:
        signals: name to samples, (cycles, 60), in the units of `MEASURED`. known: cycles known to be in best condition, (m,), sorted.
    """

    signals: dict[str, np.ndarray]
    known: np.ndarray

    @property
    def cycles(self) -> int:
        """How many cycles there are."""
        return self.signals["PS1"].shape[0]

    def blocks(self) -> list[slice]:
        """Stretches of consecutive cycles that are known to be in best condition."""
        ends = np.flatnonzero(np.diff(self.known) > 1)
        starts = np.concatenate([[0], ends + 1])
        return [slice(int(self.known[a]), int(self.known[b]) + 1) for a, b in zip(starts, [*ends, self.known.size - 1], strict=True)]


def present(folder: Path) -> bool:
    """Whether the record is there."""
    return (folder / "sensors_1hz.npz").is_file() and (folder / "calibration_cycles.txt").is_file()


def read(folder: Path) -> Record:
    """Read a folder with ``sensors_1hz.npz`` and ``calibration_cycles.txt``.

    Raises:
        RecordingsError: a file or signal that is missing, has another shape or reads nothing, or too few cycles, known ones or all.
    """
    sensors, cycles = folder / "sensors_1hz.npz", folder / "calibration_cycles.txt"
    signals = arrays(sensors, tuple(MEASURED), WHERE)
    if not cycles.is_file():
        raise RecordingsError(f"{cycles}: no such file; get the set from {WHERE}")
    shape = signals["PS1"].shape
    for name, values in signals.items():
        if values.shape != shape or values.ndim != 2 or values.shape[1] != SECONDS:
            raise RecordingsError(f"{sensors}: {name} has shape {values.shape}, allowed is (cycles, {SECONDS}), alike for all signals")
        if not np.isfinite(values).all():
            cycle = int(np.argwhere(~np.isfinite(values))[0, 0])
            raise RecordingsError(f"{sensors}: {name} has a value that is not finite in cycle {cycle}")
    if shape[0] < _LEAST:
        raise RecordingsError(f"{sensors}: {shape[0]} cycles, needed are {_LEAST} or more")
    for name in _POSITIVE:
        usual = float(np.median(signals[name]))
        if not usual > 0.0:
            raise RecordingsError(f"{sensors}: {name} reads {usual:g} {MEASURED[name]} in most samples, allowed is more than 0")
    try:
        known = np.unique(np.array(cycles.read_text(encoding="utf-8").split(), dtype=np.int64))
    except (ValueError, OverflowError) as error:
        raise RecordingsError(f"{cycles}: {error}; allowed is one cycle number a line") from None
    if known.size == 0 or known[0] < 0 or known[-1] >= shape[0]:
        own = f"cycles {known[0]} to {known[-1]}" if known.size else "no cycles"
        raise RecordingsError(f"{cycles}: {own}, allowed are two or more of 0 to {shape[0] - 1}")
    record = Record(signals, known)
    longest = max(block.stop - block.start for block in record.blocks())
    if longest < _STRETCH:
        raise RecordingsError(f"{cycles}: no more than {longest} cycles in a row, needed are {_STRETCH} or more")
    return record
