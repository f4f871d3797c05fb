"""A command of the project in a process of its own: how long it took, start of Python included, and its peak memory."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_LOOK = 1.0  # s
_MOST = 65_536  # byte of what is said that are looked at


class ProcessFailed(ValueError):
    """A timed command that did not end well; one line for people."""


def timed(*arguments: str, told: Callable[[str], None] | None = None) -> tuple[float, float]:
    """Run `ddh-twin` with arguments; ``told`` is what it has said on standard error, each `_LOOK` s.

    Returns:
        seconds, and megabytes (10^6 byte) of resident memory at most.

    Raises:
        ProcessFailed: it left with another status than 0; the last of what it said is kept.
    """
    command = [sys.executable, "-m", "ddh_twin_py.cli.main", *arguments]
    with tempfile.TemporaryFile() as said:
        started = time.perf_counter()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said)
        try:
            with _looking(said.fileno(), told):
                _, status, usage = os.wait4(process.pid, 0)
        except BaseException:  # interrupted: nobody waits for it any more
            process.kill()
            raise
        elapsed = time.perf_counter() - started
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            said.seek(0)
            raise ProcessFailed(f"ddh-twin {' '.join(arguments)} left with {process.returncode}: "
                                f"{said.read().decode(errors='replace').strip()[-300:]}")
    return elapsed, usage.ru_maxrss * 1024e-6


@contextmanager
def _looking(file: int, told: Callable[[str], None] | None) -> Iterator[None]:
    """Meanwhile a thread tells the end of what stands in an open file, which somebody else writes."""
    ended = threading.Event()

    def look() -> None:
        while not ended.wait(_LOOK):
            told(os.pread(file, _MOST, max(os.fstat(file).st_size - _MOST, 0)).decode(errors="replace"))

    thread = threading.Thread(target=look, daemon=True, name="timed")
    if told is not None:
        thread.start()
    try:
        yield
    finally:
        ended.set()
        if told is not None:
            thread.join()
