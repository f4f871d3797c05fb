"""What lies below a folder, links followed, every folder once: a link that leads back, or to another of them, doubles nothing."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path


def below(folder: Path, failed: Callable[[OSError], None] | None = None) -> Iterator[tuple[Path, list[str], list[str]]]:
    """Every folder from the given one down, with names of folders and files in it, as `os.walk` gives them.

    Names that are taken out of the list of folders are not looked into. ``failed`` is told of a folder that cannot be looked into.
    """
    seen: set[str] = set()
    for here, folders, files in os.walk(folder, onerror=failed, followlinks=True):
        real = os.path.realpath(here)
        if real in seen:
            folders.clear()
            continue
        seen.add(real)
        folders.sort(key=lambda name: (os.path.islink(os.path.join(here, name)), name))  # what a link leads to keeps its own name
        yield Path(here), folders, files
