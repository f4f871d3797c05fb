"""How kernels are compiled: once per version of the physics, kept in the user's cache.

numba's own cache looks only at the file of a function and not at the functions that it calls.
The cache folder therefore carries a digest of every source file that holds kernels, or (by its
own word) numbers frozen into kernels, so that a changed equation can never meet an old binary.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from pathlib import Path

import numba
import numpy

_ROOMS_WITH_KERNELS = ("physics", "telemetry", "twin", "estimation", "gap", "bags", "benchmarks", "real_rigs")
_MARKS = (b"physics.compiled import", b"frozen into kernels")


def sources() -> Iterator[tuple[str, bytes]]:
    """Every source file on which a kernel's machine code may depend: its path in the package, and its content."""
    package = Path(__file__).resolve().parent.parent
    for source in sorted((package / "rig").iterdir()):  # the fields of the parameter record
        if source.suffix in (".py", ".yaml"):
            yield source.relative_to(package).as_posix(), source.read_bytes()
    for room in _ROOMS_WITH_KERNELS:
        for source in sorted((package / room).rglob("*.py")):
            content = source.read_bytes()
            if any(mark in content for mark in _MARKS):
                yield source.relative_to(package).as_posix(), content


def cache_directory() -> Path:
    """Folder of the machine code of these sources."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path, content in sources():
        digest.update(path.encode() + content)
    digest.update(f"{numba.__version__} {numpy.__version__}".encode())
    base = os.environ.get("DDH_TWIN_CACHE") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "ddh_twin" / "kernels" / digest.hexdigest()[:16]


if "NUMBA_CACHE_DIR" not in os.environ:
    try:
        directory = cache_directory()
        directory.mkdir(parents=True, exist_ok=True)
        numba.config.CACHE_DIR = str(directory)
    except (OSError, RuntimeError):
        pass  # a read-only home, or none: kernels are compiled again in each process

_COMPILED = {"cache": True, "error_model": "numpy", "nogil": True}
_FUSED = {"contract", "arcp"}  # a product and a sum rounded once, a quotient as a product: the last bit may differ, NaN and inf stay

kernel = numba.njit(**_COMPILED)
"""Decorator of every compiled function of the model."""

inlined = numba.njit(**_COMPILED, inline="never", forceinline=True)
"""Small functions that kernels call and that become part of each; rounded as written."""

equation = numba.njit(**_COMPILED, inline="never", forceinline=True, fastmath=_FUSED)
"""Small equations of the model, part of each kernel that calls them: what one of them knows is not computed again by the next."""
