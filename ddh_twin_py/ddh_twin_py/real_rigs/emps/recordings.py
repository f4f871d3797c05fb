"""Recordings of the EMPS benchmark: one file for identification, one with force pulses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from ddh_twin_py.real_rigs.study import RecordingsError

SOURCE = ("Janot, Gautier, Brunot: Data set and reference models of EMPS, 2019 Workshop on Nonlinear System Identification Benchmarks; "
          "nonlinearbenchmark.org")
FOLDER, IDENTIFICATION, PULSES = "emps", "DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"
STEP = 1.0e-3
"""s between samples."""
PERIOD = 6240
"""Samples after which the reference repeats itself."""
LEAST = 2 * PERIOD
"""Samples of a record: what two repeats of one motion scatter is its noise."""
_GAINS = ("gtau", "kp", "kv")


@dataclass(frozen=True)
class EmpsRecord:
    """One recording at 1 kHz.

    Attributes:
        path: file. time: s, (n,). reference, position: of the motor's encoder, m, (n,). command: of the motor's force, V, (n,).
        pulses: force that is added to the controller's, N, (n,). force_gain: N/V. position_gain: 1/s. velocity_gain: V*s/m.
    """

    path: Path
    time: np.ndarray
    reference: np.ndarray
    position: np.ndarray
    command: np.ndarray
    pulses: np.ndarray
    force_gain: float
    position_gain: float
    velocity_gain: float

    @property
    def force(self) -> np.ndarray:
        """What the motor is told to give, N, (n,)."""
        return self.force_gain * self.command


def present(data: Path) -> bool:
    """Whether both recordings are there."""
    return all((data / FOLDER / name).is_file() for name in (IDENTIFICATION, PULSES))


def read(data: Path, name: str) -> EmpsRecord:
    """One of `IDENTIFICATION` and `PULSES` from the folder ``emps`` of ``data``.

    Raises:
        RecordingsError: it is not there, is no MATLAB file, or a variable is missing or of another length.
    """
    path = data / FOLDER / name
    if not path.is_file():
        raise RecordingsError(f"{path}: no such file; the set is at nonlinearbenchmark.org (EMPS)")
    wanted = ("t", "qg", "qm", "vir", "gtau", "kp", "kv", *(("pulses_N",) if name == PULSES else ()))
    try:
        found = loadmat(path, variable_names=wanted)
    except Exception as error:  # a damaged file makes the parser stumble in many ways
        raise RecordingsError(f"{path}: cannot be read as a MATLAB file: {' '.join(str(error).split())}") from None
    values = {}
    for key in wanted:
        if key not in found:
            raise RecordingsError(f"{path}: {key} is missing; expected are {', '.join(wanted)}")
        own = np.asarray(found[key])
        if own.dtype.kind not in "biuf":
            raise RecordingsError(f"{path}: {key} holds {own.dtype}, allowed are numbers")
        values[key] = own.astype(float).ravel()
    n = values["t"].size
    if n < LEAST:
        raise RecordingsError(f"{path}: {n} samples, needed are {LEAST} or more")
    for key, own in values.items():
        if key not in _GAINS and own.size != n:
            raise RecordingsError(f"{path}: {key} has {own.size} samples, t has {n}")
        if own.size == 0 or not np.isfinite(own).all():
            raise RecordingsError(f"{path}: {key} holds a value that is no number" if own.size else f"{path}: {key} is empty")
    step = float(np.median(np.diff(values["t"])))
    if abs(step - STEP) > 1e-3 * STEP:
        raise RecordingsError(f"{path}: t advances by {step:g} s, allowed is {STEP:g} s")
    for key in _GAINS:
        if not values[key][0] > 0.0:
            raise RecordingsError(f"{path}: {key} is {values[key][0]:g}, allowed is more than 0")
    record = EmpsRecord(path, values["t"], values["qg"], values["qm"], values["vir"], np.zeros(n), float(values["gtau"][0]),
                        float(values["kp"][0]), float(values["kv"][0]))
    return replace(record, pulses=_pulses(record, values["pulses_N"])) if name == PULSES else record


def _pulses(record: EmpsRecord, shape: np.ndarray) -> np.ndarray:
    """Pulses in N: their shape times what the recorded command has beyond the controller's; the set gives them in volts."""
    position = record.position
    rate = (position - np.roll(position, 2)) / (2.0 * STEP)
    told = record.velocity_gain * (record.position_gain * (record.reference - position) - rate)
    beyond, shape = record.force - record.force_gain * told, np.asarray(shape)
    inner = slice(2, None)
    return shape * float(shape[inner] @ beyond[inner]) / max(float(shape[inner] @ shape[inner]), 1e-12)
