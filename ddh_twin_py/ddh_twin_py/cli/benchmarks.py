"""What `ddh-twin bench` measures."""

from __future__ import annotations

import json
import os
import platform
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.benchmarks.calibration_speed import time_calibration
from ddh_twin_py.benchmarks.diagnosis_speed import FULL, time_diagnosis
from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.benchmarks.filters import compare_filters
from ddh_twin_py.benchmarks.free_run_speed import compare_solvers
from ddh_twin_py.benchmarks.recorded_run_speed import time_recorded_run
from ddh_twin_py.benchmarks.screening_speed import time_screening
from ddh_twin_py.benchmarks.timed_process import timed
from ddh_twin_py.cli.console import stage
from ddh_twin_py.cli.simulate import START_NS
from ddh_twin_py.cli.simulated import collect
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.duty_file import duty_file
from ddh_twin_py.twin.simulated_rig import SimulatedRig

Progress = Callable[[float], None]


def _solvers(quick: bool, progress: Progress) -> tuple[list[Figure], list[str]]:
    return compare_solvers(load_rig(), load_duty(duty_file("paper_cycle")), 60.0 if quick else 300.0)


def _filters(quick: bool, progress: Progress) -> tuple[list[Figure], list[str]]:
    return compare_filters(500 if quick else 5000)


def _diagnosis(quick: bool, progress: Progress) -> tuple[list[Figure], list[str]]:
    with tempfile.TemporaryDirectory(prefix="ddh_diagnosis_") as scratch:
        return time_diagnosis(load_rig(), Path(scratch), 300.0 if quick else FULL, progress), []


def _calibration(quick: bool, progress: Progress) -> tuple[list[Figure], list[str]]:
    return time_calibration(load_rig(), load_duty(duty_file("mixed")), 120.0 if quick else 600.0), []


COMPARISONS: tuple[tuple[str, Callable[[bool, Progress], tuple[list[Figure], list[str]]]], ...] = (
    ("free run beside general solvers", _solvers),
    ("Kalman filter beside others", _filters),
    ("calibration of six parameters", _calibration),
    ("diagnosis of a long recording", _diagnosis),
)
"""Comparisons in one run: what the progress says, and a function of ``quick`` and of what is told the share done
that gives figures and what was left out, each with its reason. A further benchmark is one more row."""


LIVE_FAILED = "the live nodes failed"
"""How the reason begins that says so."""


def measure(quick: bool = False, live: bool = True, quiet: bool = False) -> tuple[list[Figure], list[str], str]:
    """All figures, what was left out and why, and what machine they are of."""
    duration = 600.0 if quick else 3600.0
    with tempfile.TemporaryDirectory(prefix="ddh_bench_") as scratch:
        bag = Path(scratch) / "telemetry"
        with stage(f"simulating {duration / 60:.0f} min of telemetry", quiet) as progress:
            simulated = SimulatedRig(load_rig(), load_duty(duty_file("paper_cycle")), seed=1)
            write_recording(bag, collect(simulated.run(duration), START_NS, duration, progress))
        with stage("compiling the model, once", quiet):
            replay(read_recording(bag).between(0.0, 5.0), load_rig())
        figures, left_out = [], []
        with stage("replay in a process of its own", quiet):
            figures += _replay(bag, Path(scratch), duration)
        with stage("reading", quiet):
            figures += _decode(bag)
        recording, rig = read_recording(bag), load_rig()
        with stage("screening", quiet):
            figures += time_screening(recording, rig)
        with stage("free run and filter", quiet):
            figures += time_recorded_run(recording, rig)
        for label, benchmark in COMPARISONS:
            with stage(label, quiet) as progress:
                found, reasons = benchmark(quick, progress)
            figures += found
            left_out += reasons
        if live:
            from ddh_twin_py.cli.live_bench import live_figures
            from ddh_twin_py.cli.page_bench import page_figures

            try:
                for of_the_graph in (live_figures, page_figures):
                    for figure in of_the_graph(bag, Path(scratch), quick, quiet):
                        figures.append(figure)
            except (ValueError, OSError) as error:  # what was measured before is kept
                left_out.append(f"{LIVE_FAILED}: {error}")
    return figures, left_out, _machine()


def _replay(bag: Path, scratch: Path, duration: float) -> Iterator[Figure]:
    """Replay with report and JSON, start of Python included."""
    out = scratch / "replay.json"
    runs = []
    for _ in range(2):  # the second finds everything in the file cache, as the first of a user's would
        elapsed, memory = timed("replay", str(bag), "--quiet", "--json", str(out), "--html", str(scratch / "replay.html"))
        runs.append((elapsed, sum(json.loads(out.read_text())["end_matter"]["computing_time_s"].values()), memory))
    elapsed, seconds, memory = min(runs)
    label, share = f"replay {duration / 60:.0f} min", duration / 3600.0
    limit = "limit" if share == 1.0 else "limit of 1 h"
    yield Figure(f"{label}, computing", seconds, "s", 2.0 * share, "limit" if share == 1.0 else "limit, scaled")
    yield Figure(f"{label}, end to end", elapsed, "s", 8.0, limit)
    yield Figure(f"{label}, peak memory", memory, "MB", 500.0, limit)


def _decode(bag: Path) -> Iterator[Figure]:
    best, messages = float("inf"), 0
    for _ in range(3):
        started = time.perf_counter()
        recording = read_recording(bag)
        best = min(best, time.perf_counter() - started)
        messages = sum(len(stream) for _, stream in recording.streams())
    yield Figure("reading a bag", messages / best / 1e3, "k messages/s", 60.0, "rosbags", smaller=False)


def _machine() -> str:
    name = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        name = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return f"{os.cpu_count()} cores, {name}, load {os.getloadavg()[0]:.1f}"
