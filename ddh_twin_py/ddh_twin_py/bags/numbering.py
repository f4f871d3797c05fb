"""Names of what must not overwrite an earlier one, such as the folder of a recorder that was started again: NAME, NAME_2, NAME_3 ..."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path


def numbered(path: str | Path) -> Iterator[Path]:
    """The name itself, then with a number; without end."""
    yield Path(path)
    yield from (Path(f"{path}_{number}") for number in itertools.count(2))
