"""The filter's state on disk, so that a twin does not start cold on a warm machine."""

from __future__ import annotations

import io
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.estimation.fusion.state import FusionState
from ddh_twin_py.rig.files import write_whole

_VERSION = 1
_ROUNDING = 1e-6
_DAMAGE = (
    ValueError, TypeError, KeyError, EOFError, AttributeError, MemoryError, OverflowError, NotImplementedError, RuntimeError,
    SyntaxError, tokenize.TokenError, zipfile.BadZipFile, zlib.error, struct.error,
)
"""What zip and array readers raise on bytes that are not theirs."""
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
    content = io.BytesIO()
    np.savez(content, version=_VERSION, rig_id=rig_id, stamp_ns=np.int64(stamp_ns), **asdict(state))
    write_whole(path, content.getvalue())


def load_state(path: str | Path, like: FusionState) -> SavedState | None:
    """Read a state file; None where there is none yet.

    Args:
        like: a state of this version of the filter; shapes must agree.

    Raises:
        StateFileError: not a state file, damaged, of another version, or with values that no filter has.
    """
    path = Path(path)
    wanted = asdict(like)
    try:
        arrays = _arrays(path, ("version", "rig_id", "stamp_ns", *wanted))
        if arrays is None:
            return None
        version = _scalar(arrays, "version", "iu")
        if version != _VERSION:
            raise StateFileError(f"is of version {version}, this twin reads version {_VERSION}")
        values = {name: _value(arrays, name, value) for name, value in wanted.items()}
        _check_covariance(values["covariance"])
        stamp_ns = int(_scalar(arrays, "stamp_ns", "iu"))
        return SavedState(FusionState(**values), str(_scalar(arrays, "rig_id", "U")), stamp_ns)
    except StateFileError as error:
        raise StateFileError(f"{path}: {error}") from None


def _arrays(path: Path, names: Sequence[str]) -> dict[str, np.ndarray] | None:
    """What is in the file under these names; None where there is no file."""
    try:
        with open(path, "rb") as file:
            if not zipfile.is_zipfile(file):
                raise StateFileError("is no state file, or was cut short")
            file.seek(0)
            with np.load(file, allow_pickle=False) as data:
                return {name: data[name] for name in names if name in data.files}
    except FileNotFoundError:
        return None
    except StateFileError:
        raise
    except _DAMAGE:
        raise StateFileError("is no state file, or is damaged") from None
    except OSError as error:
        raise StateFileError(f"cannot be read: {error.strerror or 'unknown cause'}") from None


def _scalar(arrays: Mapping[str, np.ndarray], name: str, kinds: str):
    value = _present(arrays, name)
    if value.shape != () or value.dtype.kind not in kinds:
        raise StateFileError(f"{name} is of type {value.dtype} and shape {value.shape}, which no state file has")
    return value.item()


def _value(arrays: Mapping[str, np.ndarray], name: str, like: object):
    """One entry of the state, as it is in `like`."""
    value, wanted = _present(arrays, name), np.asarray(like)
    if value.shape != wanted.shape or not np.can_cast(value.dtype, wanted.dtype, "same_kind"):
        raise StateFileError(
            f"{name} is of type {value.dtype} and shape {value.shape}, this filter has {wanted.dtype} and {wanted.shape}"
        )
    if not np.all(np.isfinite(value)):
        raise StateFileError(f"{name} has a value that is not finite")
    return value.astype(wanted.dtype) if wanted.shape else type(like)(value.item())


def _present(arrays: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    if name not in arrays:
        raise StateFileError(f"is no state file: {name} is missing")
    return arrays[name]


def _check_covariance(covariance: np.ndarray) -> None:
    variance = np.diag(covariance)
    if np.any(variance < 0.0):
        raise StateFileError(f"covariance has a negative variance, {variance.min():.3g}")
    deviation = np.sqrt(variance)
    largest = np.outer(deviation, deviation) * (1.0 + _ROUNDING)
    if np.any(np.abs(covariance) > largest) or np.any(np.abs(covariance - covariance.T) > _ROUNDING * largest):
        raise StateFileError("covariance is not one: not symmetric, or a correlation beyond 1")
