"""Make a bench: all of its cases, then the seal."""

from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from ddh_twin_py.gap_bench.making import make
from ddh_twin_py.gap_bench.plan import SUITES, PlanError, Planned, plan
from ddh_twin_py.gap_bench.running import executor, results
from ddh_twin_py.gap_bench.sealing import SEAL, seal
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.files import held, read_json, write_whole

RECIPE = "recipe.json"
"""What a bench was asked to be."""
_LOCK = ".make.lock"  # held as long as cases are made; the file stays


def make_bench(out: Path, cases: int, seed: int, suites: tuple[str, ...] = (), jobs: int = 1, cluster: str | None = None,
               progress: Callable[[float], None] | None = None) -> list[str]:
    """Make the cases that are not there yet and seal them.

    Args:
        out: folder. cases, seed, suites: see `plan`; () is all suites. jobs: processes at once. cluster: see `running.run_bench`.

    Returns:
        one line per case that could not be made; it is no part of the sealed bench.

    Raises:
        PlanError: the folder holds another bench, or something that is none, or cases are being made in it. SealError: see `seal`.
    """
    suites = suites or SUITES
    recipe = {"cases": cases, "seed": seed, "suites": list(suites)}
    file = out / RECIPE
    if file.is_file():
        try:
            found = read_json(file)
        except ValueError as error:
            raise PlanError(f"{file}: is no recipe of a bench ({error}); use another folder") from None
        if found != recipe:
            raise PlanError(f"{file}: holds the bench {found}, asked for is {recipe}; use another folder")
    elif out.is_dir() and (strange := sorted(entry.name for entry in out.iterdir() if entry.name != _LOCK)):
        raise PlanError(f"{out / strange[0]}: is of no bench, there is no {RECIPE} beside it; use an empty folder or a new one")
    if (out / SEAL).is_file():
        seal(out)
        return []
    busy = PlanError(f"{out}: another ddh-twin gap-bench is making cases there; wait for it, or use another folder")
    with held(out, _LOCK, busy):
        write_whole(file, json.dumps(recipe))
        planned = plan(cases, seed, suites)
        failed = []
        with _makers(jobs, cluster) as pool:
            waiting = [pool.submit(_made, one, str(out.absolute())) for one in planned]
            for done, wrong in enumerate(results(waiting), 1):
                if wrong:
                    failed.append(wrong)
                if progress is not None:
                    progress(done / len(waiting))
        seal(out)
    return sorted(failed)


def _makers(jobs: int, cluster: str | None) -> Executor:
    if cluster is not None:
        return executor(jobs, cluster)
    return ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_end_with, initargs=(os.getpid(),))


def _end_with(parent: int) -> None:
    """Let this process end within a second of its parent, which may be killed."""
    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _made(planned: Planned, out: str) -> str:
    """'' or why the case could not be made."""
    try:
        make(planned, Path(out), load_rig())
    except PlanError as error:
        return str(error)
    return ""
