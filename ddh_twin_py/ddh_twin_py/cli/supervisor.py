"""Keeps processes running: one log, restart with a back-off, nothing left behind."""

from __future__ import annotations

import ctypes
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TextIO

BACK_OFF = (1.0, 2.0, 4.0, 8.0, 16.0, 30.0)
"""s of waiting before the first, second ... restart in a row."""
STEADY = 60.0
"""s of running after which the back-off begins anew."""
CUT_OFF = 1
"""Exit code where a child that is run once crashed."""
SILENT = 10
"""s in which the main thread of a node never runs, after which it does not answer: one that waits wakes every second."""
KILLED = 1
"""Exit code where a child did not stop and had to be killed."""
UNUSABLE = 2
"""Exit code of a node that cannot use what it was given; a restart would not help."""
# Not SIGINT first: a Python that is still importing answers it with a traceback.
_GRACE = ((signal.SIGTERM, 10.0), (signal.SIGKILL, 2.0))
_PR_SET_PDEATHSIG = 1
_REFUSED = ("error:", "FATAL ")  # what a node says that cannot use what it was given
_GRAVE = (*_REFUSED, "WARN ", "ERROR ")
_ALIKE = 60.0  # s for which a warning that another child gives in the same words is in the file alone
_SEVERITIES = (*_GRAVE, "DEBUG ", "INFO ")


@dataclass
class Child:
    """A process to be kept: its name in the log, its command.

    `source`: may end, and the whole ends when all sources have. `once`: begins from the start if started again, so that the whole ends
    where it crashes. `last`: stopped after the others.
    """

    name: str
    command: Sequence[str]
    source: bool = False
    once: bool = False
    last: bool = False
    process: subprocess.Popen | None = None
    restarts: int = 0
    in_a_row: int = 0
    started: float = 0.0
    again_at: float | None = None
    rest: bytes = b""
    pulse: str = ""
    still: int = 0

    @property
    def running(self) -> bool:
        return self.process is not None and self.process.poll() is None


class Supervisor:
    """Runs children until all that are sources have done their work, or until it is told to stop.

    `log` gets every line of every child as `time name | line`. Must be used from the main
    thread: children are told by the kernel when the thread that started them dies.
    """

    def __init__(
        self, children: Sequence[Child], log: Callable[[str], None], environment: Mapping[str, str], linger: float = 4.0
    ) -> None:
        self.children = list(children)
        self._log, self._environment, self._linger = log, dict(environment), linger
        self._selector = selectors.DefaultSelector()
        self._stop = False
        self._libc = ctypes.CDLL(None, use_errno=True)

    def ask_to_stop(self, *_: object) -> None:
        """End `run` soon; fit for a signal handler."""
        self._stop = True

    def run(self) -> int:
        """Start all, keep them, stop them; returns the exit code."""
        code = 0
        try:
            for child in self.children:
                self._start(child)
            done_at, felt_at = None, 0.0
            while not self._stop:
                self._read(0.2)
                for child in self.children:
                    code = self._look_after(child) or code
                if time.monotonic() - felt_at >= 1.0:
                    felt_at = time.monotonic()
                    for child in self.children:
                        self._feel_pulse(child)
                if code:
                    break
                sources = [child for child in self.children if child.source]
                if sources and all(c.process is None and c.again_at is None for c in sources):
                    done_at = done_at or time.monotonic()
                    if time.monotonic() - done_at > self._linger:
                        self.say("the source has come to its end, stopping")
                        break
            if self._stop:
                self.say("told to stop, stopping all")
        finally:
            killed = self.stop()
        if not killed:
            self.say("all have ended")
        return code or (KILLED if killed else 0)

    def say(self, text: str) -> None:
        """A line of our own in the log."""
        self._line("up", text)

    # --- one child ---------------------------------------------------------------------------

    def _start(self, child: Child) -> None:
        parent = os.getpid()

        def die_with_parent() -> None:
            self._libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
            if os.getppid() != parent:
                os._exit(1)

        child.process = subprocess.Popen(
            child.command, env=self._environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=die_with_parent,
        )  # fmt: skip
        child.started, child.again_at, child.pulse, child.still = time.monotonic(), None, "", 0
        os.set_blocking(child.process.stdout.fileno(), False)
        self._selector.register(child.process.stdout, selectors.EVENT_READ, child)

    def _look_after(self, child: Child) -> int:
        """Notice an end, restart when it is time; the code with which everything must end, else 0."""
        if child.again_at is not None and time.monotonic() >= child.again_at:
            child.restarts += 1
            self._start(child)
            self._line("up", f"{child.name} started again (restart {child.restarts})")
            return 0
        if child.process is None or child.process.poll() is None:
            return 0
        code = child.process.returncode
        self._drain(child)
        child.process = None
        if code == 0 and child.source:
            self._line("up", f"{child.name} has ended")
            return 0
        if code == UNUSABLE and not child.restarts:
            self._line("up", f"ERROR {child.name} cannot use what it was given, stopping")
            return UNUSABLE
        ran = time.monotonic() - child.started
        if child.once:
            self._line("up", f"ERROR {child.name} ended ({_reason(code)}) after {ran:.1f} s; again it would begin from the start, stopping")
            return CUT_OFF
        child.in_a_row = 0 if ran > STEADY else child.in_a_row
        wait = BACK_OFF[min(child.in_a_row, len(BACK_OFF) - 1)]
        child.in_a_row += 1
        child.again_at = time.monotonic() + wait
        self._line("up", f"WARN {child.name} ended ({_reason(code)}) after {ran:.1f} s, starting it again in {wait:g} s")
        return 0

    def _feel_pulse(self, child: Child) -> None:
        """Say once that a node does not answer, and once that it does again."""
        pulse = _pulse(child.process.pid) if child.running else ""
        if not pulse or pulse != child.pulse:
            if child.still >= SILENT and pulse:
                self._line("up", f"WARN {child.name} answers again, after {child.still} s")
            child.pulse, child.still = pulse, 0
            return
        child.still += 1
        if child.still == SILENT:
            self._line("up", f"WARN {child.name} (process {child.process.pid}) does not answer: it has done nothing for {SILENT} s; it was "
                       "stopped from outside or waits in vain, and it is started again where it is killed")

    def stop(self) -> bool:
        """Stop all that runs, those marked `last` after the others; nothing is left behind. Whether one had to be killed."""
        killed = False
        for child in self.children:
            child.again_at = None
        for last in (False, True):
            group = [child for child in self.children if child.last is last and child.running]
            for number, grace in _GRACE:
                still = [child for child in group if child.running]
                if not still:
                    break
                if number == signal.SIGKILL:
                    killed = True
                    names = ", ".join(c.name for c in still)
                    self._line("up", f"ERROR {names} did not stop within {_GRACE[0][1]:g} s, sending {number.name}")
                for child in still:
                    child.process.send_signal(number)
                deadline = time.monotonic() + grace
                while any(child.running for child in group) and time.monotonic() < deadline:
                    self._read(0.05)
            for child in group:
                self._drain(child)
                if child.process.returncode not in (0, -signal.SIGTERM):
                    self._line("up", f"WARN {child.name} ended with {_reason(child.process.returncode)}")
        return killed

    # --- log ---------------------------------------------------------------------------------

    def _read(self, timeout: float) -> None:
        if not self._selector.get_map():
            time.sleep(timeout)
            return
        for key, _ in self._selector.select(timeout):
            self._take(key.data)

    def _take(self, child: Child) -> bool:
        """Log what waits in a child's pipe; whether there may be more."""
        try:
            data = os.read(child.process.stdout.fileno(), 65536)
        except BlockingIOError:
            return False
        *lines, child.rest = (child.rest + data).split(b"\n")
        for line in lines:
            self._line(child.name, line.decode("utf-8", "replace"))
        if not data:
            self._close(child)
        return bool(data)

    def _drain(self, child: Child) -> None:
        """Log the last words of a child that has ended; what it left running may still hold the pipe."""
        if not child.process.stdout.closed:
            while self._take(child):
                pass
            self._close(child)

    def _close(self, child: Child) -> None:
        pipe = child.process.stdout
        if pipe.closed:
            return
        if child.rest:
            self._line(child.name, child.rest.decode("utf-8", "replace"))
            child.rest = b""
        self._selector.unregister(pipe)
        pipe.close()

    def _line(self, name: str, text: str) -> None:
        now = datetime.now()
        self._log(f"{now:%H:%M:%S}.{now.microsecond // 1000:03d} {name:<18} | {text}")


def combined_log(file: TextIO | None, screen: TextIO | None = sys.stdout, errors: TextIO | None = None) -> Callable[[str], None]:
    """A log of which a file gets all; warnings, errors and tracebacks go to ``errors``, by default standard error, the rest to the screen.

    What several children say alike goes to ``errors`` once: what they cannot use for good, warnings and errors for `_ALIKE`.
    """
    failing: set[str] = set()
    said: dict[str, tuple[str, float]] = {}  # by whom and when, s, each grave line was said first

    def grave(name: str, text: str) -> bool:
        if text.startswith("Traceback"):
            failing.add(name)
        elif text.startswith(_SEVERITIES):
            failing.discard(name)
        return name in failing or text.startswith(_GRAVE)

    def write(line: str) -> None:
        head, _, text = line.partition(" | ")
        who, now = head.split()[-1], time.monotonic()
        wrong = grave(who, text)
        for old in [told for told, (_, at) in said.items() if now - at >= _ALIKE and not told.startswith(_REFUSED)]:
            del said[old]
        first, at = said.get(text, (who, now))
        again = text in said and (text.startswith(_REFUSED) or first != who and now - at < _ALIKE)
        if text.startswith(_GRAVE) and not again:
            said[text] = who, now
        for target in (file, None if wrong and again else (errors or sys.stderr) if wrong else screen):
            if target is not None:
                target.write(line + "\n")
                target.flush()

    return write


def _pulse(process: int) -> str:
    """How long the main thread of a process has run, how long it waited to run and how often it did; '' where the system does not tell."""
    try:
        with open(f"/proc/{process}/schedstat", encoding="ascii") as file:
            return file.read()
    except OSError:
        return ""


def _reason(code: int) -> str:
    if code >= 0:
        return f"exit code {code}"
    try:
        return f"signal {signal.Signals(-code).name}"
    except ValueError:
        return f"signal {-code}"
