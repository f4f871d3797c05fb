"""Standard output as a file that has a name where it cannot be written."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

STANDARD_OUTPUT = "standard output"


@contextmanager
def to_standard_output() -> Iterator[None]:
    """Names standard output in the error of what is written within. A closed pipe stays one."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, STANDARD_OUTPUT) from None
