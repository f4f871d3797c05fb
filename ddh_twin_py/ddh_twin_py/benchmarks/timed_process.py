"""A command of the project in a process of its own: how long it took, start of Python included, and its peak memory."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time


class ProcessFailed(ValueError):
    """A timed command that did not end well; one line for people."""


def timed(*arguments: str) -> tuple[float, float]:
    """Run `ddh-twin` with arguments.

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
