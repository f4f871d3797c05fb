"""Run the diagnosis over a sealed bench: one fresh process per case and question, finished ones are kept.

Per case: the blind diagnosis; where the suite leaves the true effect out, once more without it and the class that it was found
in; where effects of the catalogue are hidden, the oracle that is told them, to compare how far the gap closes.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor, as_completed
from importlib.util import find_spec
from pathlib import Path

from ddh_twin_py.bags.case import case_of
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.diagnosis.child import ENGINE
from ddh_twin_py.diagnosis.process import DiagnosisProcess
from ddh_twin_py.gap_bench.result_files import is_answered, read_result, result_file
from ddh_twin_py.gap_bench.sealing import suite_of, truth_of, verify
from ddh_twin_py.rig.files import held, write_whole

_LOCK = ".run.lock"  # held as long as cases are answered; the file stays
TIMEOUT = 1800.0
"""s after which a diagnosis counts as crashed."""


class BenchError(ValueError):
    """A bench that cannot be run; one line for people."""


def questions(out: Path, truth: dict, oracle: bool = True) -> list[str]:
    """What is asked of a case: blind, left_out, oracle."""
    listed = [e["effect"] for e in truth["effects"] if e["listed"]]
    asked = ["blind"]
    if truth["suite"] == "left_out":
        asked.append("left_out")
    elif listed and oracle:
        asked.append("oracle")
    return asked


def run_case(out: str, name: str, engine: str = ENGINE, oracle: bool = True, timeout: float = TIMEOUT,
             told: Callable[[float, str], None] | None = None) -> tuple[str, bool]:
    """Ask everything about one case that has no answer yet; ``told`` is the share done of it, and what is done.

    Returns:
        the case's name, and whether every process ended well.
    """
    folder = Path(out)
    truth = truth_of(folder, name)
    well = True
    asked = questions(folder, truth, oracle)
    for k, question in enumerate(asked):
        target = result_file(folder, name, question)
        if not is_answered(target):
            _ask(folder, name, question, truth, engine, timeout,
                 told and (lambda done, stage, k=k: told((k + done) / len(asked), stage)))
        well = well and "error" not in read_result(target)
    return name, well


def _ask(out: Path, name: str, question: str, truth: dict, engine: str, timeout: float,
         told: Callable[[float, str], None] | None) -> None:
    true = [e["effect"] for e in truth["effects"] if e["listed"]]
    target = result_file(out, name, question)
    target.parent.mkdir(parents=True, exist_ok=True)
    asked: dict = {"without": left_out(true, out, name)} if question == "left_out" else {"only": true} if question == "oracle" else {}
    started = time.perf_counter()
    try:
        case = case_of([out / "cases" / name])
    except BagError as error:
        write_whole(target, json.dumps({"error": str(error), "seconds": 0.0}))
        return
    process = DiagnosisProcess(case, engine=engine, **asked)
    outcome = process.wait(timeout, told)
    if outcome is None:
        process.stop()
    if outcome is None or outcome.error:
        error = f"no answer within {timeout:g} s" if outcome is None else outcome.error
        write_whole(target, json.dumps({"error": error, "seconds": time.perf_counter() - started}))
    else:
        write_whole(target, json.dumps({"report": outcome.report, "seconds": outcome.seconds, "megabytes": outcome.megabytes}))


def left_out(true: list[str], out: Path, name: str) -> list[str]:
    """The true effects and whatever the blind report could not tell from them."""
    answer = read_result(result_file(out, name, "blind"))
    gone = set(true)
    for group in answer.get("report", {}).get("classes", []):
        if gone & set(group):
            gone |= set(group)
    return sorted(gone)


def run_bench(out: Path, jobs: int = 1, suites: tuple[str, ...] = (), cases: int | None = None, engine: str = ENGINE,
              oracle: bool = True, cluster: str | None = None, again: str = "",
              progress: Callable[[float, Mapping[str, tuple[float, str]], int], None] | None = None) -> list[str]:
    """Run what is not done yet.

    Args:
        out: folder of a sealed bench. jobs: processes at once. suites: only these; () is all. cases: only the first so many.
        engine: ``module:function``. oracle: whether the oracle is asked too. cluster: address of a dask scheduler whose
            workers see ``out`` under the same path. again: 'crashed' or 'all': answers that are asked for once more.
        progress: told the share done of all cases, and of each that is under way here, by name, with its stage; and how many of those
            that were asked about did not end well.

    Returns:
        names of the cases of which a process did not end well.

    Raises:
        SealError: the truth is not what was sealed. BenchError: no such case, no such engine, no dask, or another process runs it.
    """
    names = selected(out, suites, cases)
    module = engine.partition(":")[0]
    if engine == ENGINE and find_spec(module) is None:
        raise BenchError(f"{module}: this installation has no gap diagnosis, there is nothing to run")
    ended: dict[str, bool] = {}
    running: dict[str, tuple[float, str]] = {}
    busy = BenchError(f"{out}: another ddh-twin gap-bench is running there; wait for it")
    with held(out, _LOCK, busy), executor(jobs, cluster) as pool:
        if again:
            forget(out, names, crashed=again == "crashed")
        before = answered(out, names, oracle)

        def tell() -> None:
            if progress is not None:
                now = {name: far for name, far in dict(running).items() if name not in ended}
                failed = sum(not well for name, well in dict(ended).items() if name not in before)
                progress((len(ended) + sum(share for share, _ in now.values())) / len(names), now, failed)

        def teller(name: str) -> Callable[[float, str], None]:
            def told(done: float, stage: str) -> None:
                running[name] = done, stage
                tell()

            return told

        waiting = [pool.submit(run_case, str(out.absolute()), name, engine, oracle, told=None if cluster else teller(name))
                   for name in names]
        for name, well in results(waiting):
            ended[name] = well
            tell()
    return sorted(name for name, well in ended.items() if not well)


def answered(out: Path, names: Sequence[str], oracle: bool = True) -> list[str]:
    """Those of cases of which every question has an answer."""
    return [name for name in names if all(is_answered(result_file(out, name, q)) for q in questions(out, truth_of(out, name), oracle))]


def results(waiting: Sequence[Future]) -> Iterator:
    """What tasks give, as they end; where one fails, those that have not begun are not begun, and it is told once the others have ended."""
    try:
        for future in as_completed(waiting):
            yield future.result()
    except BaseException:
        for future in waiting:
            future.cancel()
        raise


def forget(out: Path, names: list[str], crashed: bool) -> None:
    """Remove the answers of cases, or those of a process that did not end well, with what was built on them."""
    for name in names:
        files = sorted((out / "results").glob(f"{name}.*.json"))
        if not crashed or any(not is_answered(file) or "error" in read_result(file) for file in files):
            for file in files:
                file.unlink()


def selected(out: Path, suites: tuple[str, ...], cases: int | None) -> list[str]:
    """Sealed cases of the suites, the first so many.

    Raises:
        SealError: see `verify`. BenchError: none is left.
    """
    names = [name for name in verify(out) if not suites or suite_of(out, name) in suites][:cases]
    if not names:
        raise BenchError(f"{out}: no case of suite {', '.join(suites)}")
    return names


def executor(jobs: int, cluster: str | None) -> Executor:
    """Threads that each wait for one process, or the workers of a dask cluster.

    Raises:
        BenchError: dask.distributed is not installed.
    """
    if cluster is None:
        return ThreadPoolExecutor(jobs)
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise BenchError(
            "--cluster: dask.distributed is not installed; run pip install distributed on this machine and on the workers") from None
    return Client(cluster).get_executor()
