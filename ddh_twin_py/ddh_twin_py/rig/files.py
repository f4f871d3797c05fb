"""Files that people ask for: written whole or not at all."""

from __future__ import annotations

from pathlib import Path

SUFFIX = ".part"
"""Of a file's name while it is written."""


def write_whole(path: str | Path, content: str) -> Path:
    """Write a file whole or not at all, making its folder where needed.

    Raises:
        OSError: with the path that was given; nothing is left behind.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(path.name + SUFFIX)
    try:
        partial.write_text(content, encoding="utf-8")
        partial.replace(path)
    except BaseException as error:
        try:
            partial.unlink(missing_ok=True)
        except OSError:
            pass  # what went wrong before is what counts
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror, str(path)) from None
        raise
    return path
