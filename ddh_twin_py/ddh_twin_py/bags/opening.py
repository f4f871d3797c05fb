"""Open the files of a bag, whichever storage they are of and however they are packed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from ddh_twin_py.bags.compression import unpack_file
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.mcap_storage import McapStorage
from ddh_twin_py.bags.sqlite_storage import SqliteStorage
from ddh_twin_py.bags.storage import Storage


def unpacked(file: Path, scratch: Path) -> Path:
    """The file itself; of one that is packed as a whole what could be unpacked, in `scratch`. Raises BagError where that is nothing."""
    if file.suffix != ".zstd":
        return file
    target = scratch / file.stem
    try:
        unpack_file(file, target)
    except ValueError as error:
        if not target.exists() or not target.stat().st_size:
            raise BagError(f"{file} cannot be unpacked: {error}") from None
    return target


def open_storage(file: Path) -> Storage:
    """A file that is not packed as a whole. Raises BagError where it is none of its storage."""
    return McapStorage(file) if file.suffix == ".mcap" else SqliteStorage(file)


@contextmanager
def readable(path: str | Path) -> Iterator[None]:
    """Raises BagError for what the system does not let be read; `path` as it was given."""
    try:
        yield
    except OSError as error:
        raise BagError(f"{error.filename or path} cannot be read: {error.strerror or error}") from error


def of_file(said: Iterable[str], file: Path, files: Sequence[Path]) -> list[str]:
    """What is said of one file of a bag, with its name where there are several."""
    return [f"{one} ({file.name})" for one in said] if len(files) > 1 else list(said)
