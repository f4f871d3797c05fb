"""What people see while a verb runs: stages with progress, warnings."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ddh_twin_py.physics.compiling import COMPILING, watched

if TYPE_CHECKING:
    from ddh_twin_py.telemetry.recording import Finding

_MOST_WARNINGS = 8
_NOW_AND_THEN = 15.0  # s between lines where no terminal shows a bar
_ALIVE = 30.0  # s of silence after which a line comes although nothing was told


@contextmanager
def stage(name: str, quiet: bool = False, part: Callable[[float], str] | None = None) -> Iterator[Callable[[float], None]]:
    """One stage of work; call what it yields with the share done, 0 to 1. What is under way at a share may be named by ``part``.

    On a terminal a bar with the remaining time, else a line at least every 30 s and one at the end; all on standard error. Either says
    where kernels are being compiled.
    """
    started = time.perf_counter()
    if quiet:
        yield lambda share: None
    elif not sys.stderr.isatty():
        begun = threading.Event()  # since the last line
        with watched(begun.set) as compiling, _lines(name, started, part, lambda: compiling() or begun.is_set(), begun.clear) as line:
            yield line
        print(f"{name}: {time.perf_counter() - started:.1f} s", file=sys.stderr, flush=True)
    else:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeRemainingColumn

        columns = (
            SpinnerColumn(finished_text="✓"), TextColumn("{task.description}", markup=False), BarColumn(24), TimeRemainingColumn()
        )
        with Progress(*columns, console=Console(stderr=True)) as progress:
            task, words = progress.add_task(name, total=None), name

            def name_it() -> None:
                progress.update(task, description=f"{words}, {COMPILING}" if compiling() else words)

            def done(share: float) -> None:
                nonlocal words
                words = f"{name}, {part(share)}" if part else name
                progress.update(task, total=1.0, completed=share)
                name_it()

            with watched(name_it) as compiling:
                yield done
            took = f"{name}, {time.perf_counter() - started:.1f} s"
            progress.update(task, total=1.0, completed=1.0, description=took)


@contextmanager
def _lines(name: str, started: float, part: Callable[[float], str] | None,
           compiling: Callable[[], bool], told_it: Callable[[], None]) -> Iterator[Callable[[float], None]]:
    """Lines of a stage: what it yields puts one where the last is `_NOW_AND_THEN` ago, a thread where it is `_ALIVE` ago."""
    told, done = started, None
    lock, ended = threading.Lock(), threading.Event()

    def put(silence: float) -> float:
        """A line where the last is so many s ago; returns how long ago the last now is, s."""
        nonlocal told
        with lock:
            now = time.perf_counter()
            if now - told < silence:
                return now - told
            told = now
            far = "going on" if done is None else f"{100.0 * done:.0f} %{f', {part(done)},' if part else ''}"
            far += f"{',' * (done is None or part is None)} {COMPILING}," if compiling() else ""
            told_it()
            print(f"{name}: {far} after {now - started:.0f} s", file=sys.stderr, flush=True)
            return 0.0

    def line(share: float) -> None:
        nonlocal done
        done = share
        put(_NOW_AND_THEN)

    def live() -> None:
        silent = 0.0
        while not ended.wait(_ALIVE - silent):
            silent = put(_ALIVE)

    thread = threading.Thread(target=live, daemon=True, name="progress")
    thread.start()
    try:
        yield line
    finally:
        ended.set()
        thread.join()


def output():
    """The terminal, or what standard output leads to: no colour unless it is a terminal, none with NO_COLOR.

    Square brackets and colons are what people wrote: names of rigs, paths, notes.
    """
    from rich.console import Console

    return Console(markup=False, emoji=False)


def say(message: str) -> None:
    """A line on standard error."""
    print(message, file=sys.stderr, flush=True)


def show_findings(findings: Sequence[Finding], where_all: str) -> None:
    """Warnings about the input on standard error, a few lines at most."""
    warnings = [finding for finding in findings if finding.severity != "info"]
    for finding in warnings[:_MOST_WARNINGS]:
        say(str(finding))
    if len(warnings) > _MOST_WARNINGS:
        say(f"{len(warnings) - _MOST_WARNINGS} further warnings are in {where_all}")


def put_json(target: str, data: object) -> None:
    """Write JSON to a file, or to standard output where the target is `-`."""
    from ddh_twin_py.report.page.document import json_text, write_json

    if target == "-":
        print(json_text(data), flush=True)
    else:
        write_json(target, data)
