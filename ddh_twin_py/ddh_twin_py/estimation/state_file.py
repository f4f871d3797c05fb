"""The filter's state on disk, so that a twin does not start cold on a warm machine."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.estimation.temperature_fusion import FusionState

_VERSION = 1
OLDEST = 30 * 86400.0
"""s; an older state says nothing any more."""


class StateFileError(ValueError):
    """A state file that cannot be used; the message names the file and what is wrong."""


@dataclass(frozen=True)
class SavedState:
    """A state with the rig it belongs to and the stamp of the data it had seen, ns."""

    state: FusionState
    rig_id: str
    stamp_ns: int


def save_state(path: str | Path, state: FusionState, rig_id: str, stamp_ns: int) -> None:
    """Write a state file; it replaces the old one in one move, so that a crash leaves one of the two.

    Raises:
        OSError: where the folder cannot be written.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    with open(partial, "wb") as file:
        np.savez(file, version=_VERSION, rig_id=rig_id, stamp_ns=np.int64(stamp_ns), **asdict(state))
        file.flush()
        os.fsync(file.fileno())
    os.replace(partial, path)


def load_state(path: str | Path, like: FusionState) -> SavedState | None:
    """Read a state file; None where there is none yet.

    Args:
        like: a state of this version of the filter; shapes must agree.

    Raises:
        StateFileError: not a state file, of another version, or with values that are not finite.
    """
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
    except FileNotFoundError:
        return None
    except (OSError, ValueError, EOFError, KeyError) as error:
        raise StateFileError(f"{path}: is no state file: {error}") from None
    try:
        if int(arrays["version"]) != _VERSION:
            raise StateFileError(f"{path}: is of version {int(arrays['version'])}, this twin reads version {_VERSION}")
        values = {name: arrays[name] for name in asdict(like)}
        for name, wanted in asdict(like).items():
            if np.shape(values[name]) != np.shape(wanted) or not np.all(np.isfinite(values[name])):
                raise StateFileError(f"{path}: {name}: shape {np.shape(values[name])} or a value is not this filter's")
        values["ambient"] = float(values["ambient"])
        values["ambient_known"] = bool(values["ambient_known"])
        return SavedState(FusionState(**values), str(arrays["rig_id"]), int(arrays["stamp_ns"]))
    except KeyError as error:
        raise StateFileError(f"{path}: is no state file: {error} is missing") from None
