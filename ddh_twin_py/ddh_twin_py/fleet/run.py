"""Diagnoses a fleet's recordings, each in its own process: here, or on a Dask cluster."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace

from ddh_twin_py.bags.errors import BagError, of_the_system
from ddh_twin_py.diagnosis.process import COMMAND, DiagnosisProcess, Outcome
from ddh_twin_py.fleet.recordings import FleetError, Found
from ddh_twin_py.fleet.results import Results, fingerprints
from ddh_twin_py.fleet.row import COPY, Row, facts, row_of, with_one_probability
from ddh_twin_py.report.page.document import version

LONGEST = 3600.0
"""s after which the diagnosis of one recording is given up."""
_READING = "reading"
_LOOK = 1.0  # s between looks at how far recordings are
Progress = Callable[[float, Mapping[str, tuple[float, str]], int], None]
"""Told the share done of all recordings, and of each that is under way here, by name, with its stage; and how many ended with an error."""


@dataclass(frozen=True)
class Settings:
    """How each recording is diagnosed: `longest` s of wall time, without those of compiling the model; `command` and its protocol as in
    `DiagnosisProcess`."""

    longest: float = LONGEST
    command: tuple[str, ...] = COMMAND


@dataclass(frozen=True)
class Diagnosed:
    """What came of one recording. `final`: an answer that the same recording would get again."""

    row: Row
    report: dict
    final: bool


def diagnose_recording(found: Found, settings: Settings, stop: threading.Event | None = None,
                       told: Callable[[float, str], None] | None = None) -> Diagnosed:
    """Diagnose one recording in a process of its own; whatever goes wrong is a row with the error. ``told`` is the share done and the
    stage."""
    known: dict = {"recording": found.name, "version": version()}
    if found.refused:
        return Diagnosed(Row(**known, error=found.refused), {}, True)
    try:
        known |= facts(found.name, found.case)
    except (BagError, OSError) as error:
        return Diagnosed(Row(**known, error=" ".join(str(error).split())), {}, not of_the_system(error))
    except Exception as error:  # one recording of many; a damaged file may raise anything
        return Diagnosed(Row(**known, error=f"{type(error).__name__}: {' '.join(str(error).split())}"), {}, False)
    process = DiagnosisProcess(found.of_rig(known["rig"]).case, command=settings.command)
    outcome = process.wait(settings.longest, told, stop)
    if outcome is None:
        process.stop()
        late = "" if stop is not None and stop.is_set() else f", it took longer than {settings.longest:g} s"
        return Diagnosed(row_of(known, Outcome(error=f"the diagnosis was stopped{late}")), {}, False)
    return Diagnosed(row_of(known, outcome), outcome.report, outcome.answered)


def run_fleet(found: Sequence[Found], results: Results, settings: Settings, jobs: int = 1, cluster: str = "", again: bool = False,
              progress: Progress | None = None, unkept: Callable[[OSError], None] | None = None) -> list[Row]:
    """Rows of all recordings, in their order; those that are finished are taken from their files.

    Args:
        jobs: how many are diagnosed at once here. cluster: address of a Dask scheduler, '' for none; its workers must see
            the recordings at the same paths. again: also what is finished. unkept: told why a result cannot be written, whose row
            is returned all the same; where nobody is told, that ends the run.

    Raises:
        FleetError: no cluster there, or dask.distributed is not installed. OSError: a result cannot be written, and nobody is told.
    """
    rows = {} if again else {f.name: row for f in found if (row := results.finished(f)) is not None}
    left = [f for f in found if f.name not in rows]
    failed = 0
    running: dict[str, tuple[float, str]] = {}

    def tell() -> None:
        if progress is not None:
            now = {name: far for name, far in dict(running).items() if name not in rows}
            progress((len(rows) + sum(share for share, _ in now.values())) / len(found), now, failed)

    for one, before, diagnosed in (_on_cluster(left, settings, cluster) if cluster else _here(left, settings, jobs, running, tell)):
        rows[one.name] = diagnosed.row
        failed += bool(diagnosed.row.error)
        if diagnosed.final:
            try:
                results.keep(one, before, diagnosed.row, diagnosed.report)
            except OSError as error:
                if unkept is None:
                    raise
                unkept(error)
        tell()
    return [replace(with_one_probability(row), copies=COPY.join(f.copies), sheet="" if row.error else f.sheet(row.rig))
            for f, row in ((f, rows[f.name]) for f in found)]


def _here(left: Sequence[Found], settings: Settings, jobs: int, running: dict[str, tuple[float, str]],
          look: Callable[[], None]) -> Iterator[tuple[Found, dict[str, str], Diagnosed]]:
    """Each with its fingerprints as its diagnosis began: what is changed under way is another recording.

    Args:
        running: kept as recordings begin, go on and end: name to share done and stage. look: called now and then meanwhile.
    """
    stop = threading.Event()

    def one(found: Found) -> tuple[Found, dict[str, str], Diagnosed]:
        running[found.name] = 0.0, _READING
        try:
            return found, fingerprints(found), diagnose_recording(found, settings, stop, lambda *far: running.update({found.name: far}))
        finally:
            del running[found.name]

    with ThreadPoolExecutor(jobs, thread_name_prefix="fleet") as pool:
        futures = {pool.submit(one, found) for found in left}
        try:
            while futures:
                ended, futures = wait(futures, _LOOK, FIRST_COMPLETED)
                for future in ended:
                    yield future.result()
                if not ended:
                    look()
        finally:
            stop.set()
            pool.shutdown(cancel_futures=True)


def _on_cluster(left: Sequence[Found], settings: Settings, address: str) -> Iterator[tuple[Found, dict[str, str], Diagnosed]]:
    try:
        import distributed
    except ImportError:
        raise FleetError("--cluster needs dask.distributed, which is not installed here: pip install distributed") from None
    try:
        client = distributed.Client(address, timeout=20)
    except (OSError, ValueError) as error:
        raise FleetError(f"--cluster {address}: no scheduler answers ({' '.join(str(error).split())})") from None
    with client:
        before = {found.name: fingerprints(found) for found in left}
        futures = {client.submit(diagnose_recording, found, settings, pure=False): found for found in left}
        for future in distributed.as_completed(list(futures)):
            found = futures[future]
            error = future.exception()
            if error is not None:
                said = f"on the cluster: {type(error).__name__}: {' '.join(str(error).split())}"
                yield found, before[found.name], Diagnosed(Row(found.name, error=said, version=version()), {}, False)
            else:
                yield found, before[found.name], future.result()
