"""The process of one diagnosis: `python -m ddh_twin_py.diagnosis.child`; see `process.DiagnosisProcess`.

Reads one line of JSON from standard input: field, commissioning, validation, rig, without, only, engine, nice. Answers on
standard output in lines of JSON: {"done", "stage"} as it goes on, and at the end {"report", "sentence", "seconds",
"megabytes"} or {"error", "passing"}, the latter true where the system refused something. It ends when its standard input
does, so that no diagnosis outlives who asked.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from importlib import import_module
from pathlib import Path
from typing import TextIO

from ddh_twin_py.bags.errors import of_the_system

ENGINE = "ddh_twin_py.diagnosis.of_bags:diagnose"
"""``module:function`` that diagnoses, where the request names no other; the module's `stage_of`, where it has one, says what is done
at a share of the work."""


def peak_megabytes() -> float | None:
    """Largest resident memory of this process so far, MB (10^6 byte); None where the system does not say."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) * 1024e-6
    except OSError:
        pass
    return None


def main() -> int:
    """The process: 0 a report was made, 2 the input cannot be used."""
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as out:
        os.dup2(2, 1)  # whatever else prints must not come between the answers
        return _answer(out)


def _answer(out: TextIO) -> int:
    one_at_a_time = threading.Lock()  # what is compiled is told by the thread that compiles

    def tell(**message: object) -> None:
        with one_at_a_time:
            print(json.dumps(message, allow_nan=False), file=out, flush=True)

    request = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_input, daemon=True).start()
    os.nice(int(request.get("nice") or 0))
    started = time.perf_counter()
    try:
        diagnosis = _diagnose(request, lambda done, stage: tell(done=float(done), stage=str(stage)))
    except (ValueError, OSError) as error:
        if not isinstance(error, OSError) and not type(error).__module__.startswith("ddh_twin_py."):
            raise  # a fault of ours and not of the input
        said = f"{error.filename}: {error.strerror}" if isinstance(error, OSError) and error.filename else str(error)
        tell(error=" ".join(said.split()), passing=of_the_system(error))
        return 2
    tell(report=diagnosis.report, sentence=diagnosis.sentence, seconds=time.perf_counter() - started, megabytes=peak_megabytes())
    return 0


def _diagnose(request: dict, progress):
    from ddh_twin_py.bags.case import case_of
    from ddh_twin_py.physics.compiling import COMPILING, watched
    from ddh_twin_py.rig import load_rig

    module, _, name = (request.get("engine") or ENGINE).partition(":")
    engine = getattr(import_module(module), name)
    stage_of = getattr(import_module(module), "stage_of", lambda done: "")
    case = case_of(request["field"], request.get("commissioning"), request.get("validation"), request.get("rig"))
    far = 0.0, "reading"

    def told(done: float, stage: str = "") -> None:
        nonlocal far
        far = done, stage or stage_of(done)
        progress(*far)

    with watched(lambda: progress(far[0], COMPILING if compiling() else far[1])) as compiling:
        return engine(case.field, case.commissioning, case.validation, load_rig(case.rig), without=tuple(request.get("without") or ()),
                      only=request.get("only"), progress=told)


def _end_with_input() -> None:
    sys.stdin.read()
    os._exit(3)


if __name__ == "__main__":
    sys.exit(main())
