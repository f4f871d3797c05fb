"""Folders of a recorder that was started again: NAME, NAME_2, NAME_3 ..."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path


def numbered(bag: str | Path) -> Iterator[Path]:
    """The folder's own name, then with a number; without end."""
    yield Path(bag)
    yield from (Path(f"{bag}_{number}") for number in itertools.count(2))
