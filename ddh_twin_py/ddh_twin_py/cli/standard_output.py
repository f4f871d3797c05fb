"""Standard output as a file that has a name where it cannot be written."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

STANDARD_OUTPUT = "standard output"


@contextmanager
def _named() -> Iterator[None]:
    """Names standard output in the error of what is written within. A closed pipe stays one."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, STANDARD_OUTPUT) from None


class _StandardOutput(io.TextIOWrapper):
    def write(self, text: str) -> int:
        with _named():
            return super().write(text)

    def flush(self) -> None:
        with _named():
            super().flush()


def name_standard_output() -> None:
    """From here on errors of standard output name it, names of files that are not UTF-8 can be printed, and a closed one takes all."""
    out = sys.stdout
    if out is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")
    elif type(out) is io.TextIOWrapper:  # and no stand-in of a test
        settings = {"encoding": out.encoding, "line_buffering": out.line_buffering, "write_through": out.write_through}
        sys.stdout = _StandardOutput(out.detach(), errors="backslashreplace", **settings)  # standard error does so by itself
