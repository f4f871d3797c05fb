"""How the plant's kernels are compiled: cached by a digest of every file that can change them."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numba
import numpy


def _cache_directory() -> Path:
    package = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256()
    for source in sorted((package / "plant").glob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    for source in sorted((package / "rig").iterdir()):  # the fields of the sheet's record
        if source.suffix in (".py", ".yaml"):
            digest.update(source.read_bytes())
    digest.update(f"{numba.__version__} {numpy.__version__}".encode())
    base = os.environ.get("DDH_TWIN_CACHE") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "ddh_twin" / "plant" / digest.hexdigest()[:16]


_before = numba.config.CACHE_DIR
if "NUMBA_CACHE_DIR" not in os.environ:
    try:
        _directory = _cache_directory()
        _directory.mkdir(parents=True, exist_ok=True)
        numba.config.CACHE_DIR = str(_directory)
    except (OSError, RuntimeError):
        pass  # a read-only home, or none: kernels are compiled again in each process

kernel = numba.njit(cache=True, error_model="numpy", nogil=True)
"""Decorator of every compiled function of the plant."""


def done() -> None:
    """Give the cache folder of other kernels back; called once all of the plant's are declared."""
    numba.config.CACHE_DIR = _before
