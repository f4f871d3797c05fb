"""Reads the records of the electro-hydraulic actuator: one file for each load and stroke."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.real_rigs.archives import arrays
from ddh_twin_py.real_rigs.study import RecordingsError

LOADS, STROKES = (1, 2, 3, 4, 5), (1, 2, 3, 4)
STEP = 5.0e-3
"""s between the samples of a record as it is used; the files hold one a millisecond, of which so many are averaged."""
WHERE = ("the public repository ivliev123/Electro-Hydraulic-Actuator, as exp_data_<load 1-5>_<stroke 1-4>.npz with arrays in SI units "
         "(time in ms, speed in rpm)")
_LEAST = 1000  # samples of a file
_NEEDED = ("time", "pressure_a", "pressure_b", "speed", "position", "valve_command")


@dataclass(frozen=True)
class Actuation:
    """One record, (n,) each, `STEP` apart.

    Attributes:
        name: of the file. load, stroke: numbers. time: s. speed: rad/s of the pump, above 0 when it fills the piston side.
        position: m. pressure_a, pressure_b: Pa gauge, piston and rod side. valve: 1 where the rod side is at the accumulator, -1 where
            the piston side is, 0 where the command is off.
    """

    name: str
    load: int
    stroke: int
    time: np.ndarray
    speed: np.ndarray
    position: np.ndarray
    pressure_a: np.ndarray
    pressure_b: np.ndarray
    valve: np.ndarray


def name_of(load: int, stroke: int) -> str:
    """File of a record."""
    return f"exp_data_{load}_{stroke}.npz"


def present(folder: Path) -> bool:
    """Whether all records are there."""
    return all((folder / name_of(load, stroke)).is_file() for load in LOADS for stroke in STROKES)


def read(folder: Path, loads: Sequence[int], strokes: Sequence[int] = STROKES) -> list[Actuation]:
    """Records of some loads, and of no other.

    Raises:
        RecordingsError: a file or array that is missing, or of another shape.
    """
    return [_read(folder / name_of(load, stroke), load, stroke) for load in loads for stroke in strokes]


def _read(path: Path, load: int, stroke: int) -> Actuation:
    raw = arrays(path, _NEEDED, WHERE)
    size = raw["time"].size
    for name, values in raw.items():
        if values.shape != (size,) or size < _LEAST:
            raise RecordingsError(f"{path}: {name} has shape {values.shape}, allowed are {_LEAST} or more samples, alike for all arrays")
        if not np.isfinite(values).all():
            raise RecordingsError(f"{path}: {name}, sample {int(np.argmin(np.isfinite(values)))}: a value that is not finite")
    step = 1e-3 * float(np.median(np.diff(raw["time"])))
    if not 0.0 < step <= STEP or abs(STEP / step - round(STEP / step)) > 1e-6:
        raise RecordingsError(f"{path}: time advances by {1e3 * step:g} ms, allowed is a whole part of {1e3 * STEP:g} ms")
    many = round(STEP / step)
    mean = {name: values[: size // many * many].reshape(-1, many).mean(axis=1) for name, values in raw.items()}
    valve = np.sign(raw["valve_command"][: size // many * many].reshape(-1, many)[:, -1])
    time, speed = 1e-3 * (mean["time"] - raw["time"][0]), mean["speed"] * (2.0 * np.pi / 60.0)
    return Actuation(path.name, load, stroke, time, speed, mean["position"], mean["pressure_a"], mean["pressure_b"], valve)
