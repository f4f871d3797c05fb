"""SIGINT and SIGTERM end a verb within seconds, whatever it is at.

Python looks at a signal between two of its own steps: a kernel that runs long, a compilation, or a
wait for other threads puts it off, and callbacks from C swallow KeyboardInterrupt. So a thread hears
of the signal at once, asks again where it was swallowed, and ends the process after `GRACE`.
"""

from __future__ import annotations

import _thread
import atexit
import os
import signal
import sys
import threading
import time

GRACE = 1.2
"""s from the signal until the process is ended from outside of the main thread."""
_WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
_LAST = 0.5  # s for what is to be done at exit, such as removing temporary folders


class Interruption:
    """Within it SIGINT and SIGTERM raise KeyboardInterrupt, once, and the process ends soon after.

    Args:
        name: of the command, for what is said.

    Attributes:
        asked: one of them has come.
        number: which of them came first, SIGINT before any.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.asked, self.number = False, signal.SIGINT
        self._raised = self._said = False
        self._late, self._tidied = threading.Event(), threading.Event()
        self._before: tuple | None = None

    def __enter__(self) -> Interruption:
        if threading.current_thread() is not threading.main_thread():
            return self  # signals belong to the main thread
        ends = os.pipe()
        os.set_blocking(ends[1], False)
        handlers = {number: signal.signal(number, self._interrupt) for number in _WORDS}
        self._before = (handlers, signal.set_wakeup_fd(ends[1], warn_on_full_buffer=False), sys.unraisablehook, ends)
        sys.unraisablehook = self._swallowed
        # Both from the start: no thread can be started once Python is on its way out.
        threading.Thread(target=self._watch, args=(ends[0],), daemon=True, name="interruption").start()
        threading.Thread(target=self._tidy, daemon=True, name="tidying").start()
        return self

    def __exit__(self, *exception: object) -> None:
        if not self.asked:  # then it stays in force: threads may keep the process from ending
            self.release()

    def release(self) -> None:
        """Signals are again what they were before."""
        if self._before is None:
            return
        handlers, wakeup, hook, ends = self._before
        self._before = None
        signal.set_wakeup_fd(wakeup)
        for number, handler in handlers.items():
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)
        sys.unraisablehook = hook
        os.close(ends[1])  # which ends the one thread
        self._late.set()  # and the other

    @property
    def code(self) -> int:
        """With which the process ends, as a shell has it: 130 or 143."""
        return 128 + self.number

    def say(self) -> None:
        """That the verb was interrupted or terminated, once."""
        if not self._said:
            self._said = True
            print(f"{self.name}: {_WORDS[self.number]}", file=sys.stderr, flush=True)

    def _interrupt(self, number: int, frame: object) -> None:
        self._hear(number)
        if not self._raised:
            self._raised = True
            raise KeyboardInterrupt

    def _hear(self, number: int) -> None:
        if not self.asked:
            self.asked, self.number = True, signal.Signals(number)

    def _swallowed(self, unraisable) -> None:
        if self.asked and unraisable.exc_type is not None and issubclass(unraisable.exc_type, KeyboardInterrupt):
            self._raised = False
        else:
            sys.__unraisablehook__(unraisable)

    def _tidy(self) -> None:
        self._late.wait()
        if self.asked:
            atexit._run_exitfuncs()
            self._tidied.set()

    def _watch(self, end: int) -> None:
        heard = b""
        while not _WORDS.keys() & set(heard):
            heard = os.read(end, 64)
            if not heard:
                os.close(end)
                return
        self._hear(next(number for number in heard if number in _WORDS))
        until = time.monotonic() + GRACE
        while time.monotonic() < until:
            time.sleep(0.1)
            if not self._raised:
                _thread.interrupt_main()
        self.say()
        self._late.set()
        self._tidied.wait(_LAST)
        os._exit(self.code)
