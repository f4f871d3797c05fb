"""A diagnosis in a process of its own, which can be stopped, and whose crash is a result; see `child` for its protocol."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import ddh_twin_py
from ddh_twin_py.bags.case import Case
from ddh_twin_py.physics.compiling import COMPILING

COMMAND = (sys.executable, "-m", "ddh_twin_py.diagnosis.child")
_TURN = 0.2  # s between looks at how far it is
_PATIENCE = 3.0  # s between asking the process to end and ending it


@dataclass(frozen=True)
class Outcome:
    """What came of it: `report` by the contract's schema and its `sentence`, or `error` in one line.

    `answered`: the diagnosis said so itself and would again; it neither crashed nor was stopped, nor did the system refuse it anything.
    `seconds` and `megabytes` (10^6 byte, the most that was resident) are what a report took; NaN where they are not known.
    """

    report: dict = field(default_factory=dict)
    sentence: str = ""
    error: str = ""
    answered: bool = False
    seconds: float = math.nan
    megabytes: float = math.nan


class DiagnosisProcess:
    """A diagnosis under way: `done` 0 to 1, `stage`, and `outcome` once it has ended, else None.

    Args:
        case: what to diagnose. nice: how much the process steps back behind others, 0 to 19.
        command: what to run in place of the project's own; it must keep to the protocol of `child`.
        without, only: effects that are not asked about, or alone asked about; None asks about all.
        engine: ``module:function`` that diagnoses, '' is the project's own.
    """

    def __init__(self, case: Case, nice: int = 0, command: Sequence[str] = COMMAND, without: Sequence[str] = (),
                 only: Sequence[str] | None = None, engine: str = "") -> None:
        self.case = case
        self.done, self.stage = 0.0, "starting"
        self.outcome: Outcome | None = None
        self._stopped = False
        self._errors = tempfile.TemporaryFile()  # a pipe could fill up and hold the process
        request = {
            "field": [str(path) for path in case.field], "nice": nice, "without": list(without),
            "only": None if only is None else list(only), "engine": engine,
            **{name: str(path) if path else None for name, path in
               (("commissioning", case.commissioning), ("validation", case.validation), ("rig", case.rig))},
        }  # fmt: skip
        try:
            self._process = subprocess.Popen(
                list(command), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, text=True, start_new_session=True,
                env=_environment(),
            )
        except OSError as error:
            self.outcome = Outcome(error=f"{command[0]}: cannot be started: {error.strerror or error}")
            self._errors.close()
            return
        self._reader = threading.Thread(target=self._read, args=(json.dumps(request) + "\n",), name="diagnosis", daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        """Of the process; 0 where it could not be started."""
        return self._process.pid if hasattr(self, "_process") else 0

    def wait(self, longest: float = math.inf, told: Callable[[float, str], None] | None = None,
             stop: threading.Event | None = None) -> Outcome | None:
        """Wait for the end; None where it goes on after ``longest`` s, without those of compiling the model, or once ``stop`` is set.

        Args:
            told: the share done and the stage, each `_TURN` s.
        """
        waited = 0.0
        while self.outcome is None and waited < longest and not (stop is not None and stop.is_set()):
            began = time.monotonic()
            self._reader.join(min(_TURN, longest - waited))
            waited += (time.monotonic() - began) * (self.stage != COMPILING)
            if told is not None and self.outcome is None and waited < longest:
                told(self.done, self.stage)
        return self.outcome

    def stop(self) -> None:
        """End the process and all that it started, now."""
        if self.outcome is not None:
            return
        self._stopped = True
        self._signal(signal.SIGTERM)
        self._reader.join(_PATIENCE)
        self._signal(signal.SIGKILL)
        self._reader.join(_PATIENCE)

    def _signal(self, number: int) -> None:
        """To the whole group: what the process started may outlive it."""
        try:
            os.killpg(self._process.pid, number)
        except ProcessLookupError:
            pass

    def _read(self, request: str) -> None:
        try:
            self._listen(request)
        except (TypeError, ValueError):  # numbers that are none
            pass
        finally:  # whoever waits is answered, whatever came, and nothing of the process stays
            if self.outcome is None:
                self._signal(signal.SIGKILL)
                self._end()
                self.outcome = Outcome(error="the diagnosis answered what cannot be read")
            self._errors.close()

    def _listen(self, request: str) -> None:
        told: dict = {}
        try:
            self._process.stdin.write(request)
            self._process.stdin.flush()
        except OSError:
            pass  # it has ended already, and says why below
        for line in self._process.stdout:
            try:
                message = json.loads(line)
            except ValueError:
                continue
            if not isinstance(message, dict):
                continue
            if "report" in message or "error" in message:
                told = message
            elif "done" in message:
                self.done, self.stage = float(message["done"]), str(message.get("stage", ""))
        self.outcome = self._outcome(told, self._end())

    def _end(self) -> int:
        """Wait for the process and let go of its streams; its exit code."""
        code = self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            try:
                stream.close()
            except OSError:
                pass
        return code

    def _outcome(self, told: dict, code: int) -> Outcome:
        if self._stopped:
            return Outcome(error="the diagnosis was stopped")
        if "error" in told:
            return Outcome(error=" ".join(str(told["error"]).split()), answered=not told.get("passing"))
        if isinstance(told.get("report"), dict):
            self.done, self.stage = 1.0, "done"
            took = {key: float(told[key]) for key in ("seconds", "megabytes") if told.get(key) is not None}
            return Outcome(told["report"], str(told.get("sentence", "")), answered=True, **took)
        self._errors.seek(0)
        lines = self._errors.read().decode("utf-8", "replace").strip().splitlines()
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        return Outcome(error=f"the diagnosis ended with {how} and no report" + (f": {lines[-1].strip()}" if lines else ""))


def _environment() -> dict[str, str]:
    """Of the process: this installation, and BLAS on one thread, as its matrices are small and the free runs use the cores."""
    here = str(Path(ddh_twin_py.__file__).resolve().parent.parent)
    path = os.pathsep.join(filter(None, (here, os.environ.get("PYTHONPATH", ""))))
    return {"OPENBLAS_NUM_THREADS": "1", **os.environ, "PYTHONPATH": path}
