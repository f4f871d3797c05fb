"""Arrays of a `.npz` archive that a user brings."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ddh_twin_py.real_rigs.study import RecordingsError


def arrays(path: Path, names: Sequence[str], where: str) -> dict[str, np.ndarray]:
    """Arrays of an archive as float64, by name.

    Args:
        names: that are needed; others are not looked at. where: a user gets the set.

    Raises:
        RecordingsError: the file is not there, is no whole archive, or an array is missing or holds no numbers.
    """
    if not path.is_file():
        raise RecordingsError(f"{path}: no such file; get the set from {where}")
    try:
        with np.load(path) as archive:
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise RecordingsError(f"{path}: one array alone; allowed is an .npz archive with {', '.join(names)}")
            missing = [name for name in names if name not in archive.files]
            if missing:
                raise RecordingsError(f"{path}: there is no {missing[0]}; needed are {', '.join(names)}")
            return {name: _numbers(path, name, archive[name]) for name in names}
    except RecordingsError:
        raise
    except (OSError, ValueError, EOFError, KeyError, NotImplementedError, zipfile.BadZipFile, zlib.error) as error:
        raise RecordingsError(f"{path}: not a whole .npz archive ({' '.join(str(error).split())})") from None


def _numbers(path: Path, name: str, values: np.ndarray) -> np.ndarray:
    if values.dtype.kind not in "biuf":
        raise RecordingsError(f"{path}: {name} holds {values.dtype}, allowed are numbers")
    return values.astype(np.float64)
