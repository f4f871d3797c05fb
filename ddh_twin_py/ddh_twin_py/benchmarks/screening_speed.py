"""How long screening takes: a whole recording, and the few samples that a live node gets at a time."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import DRIVE_FIELDS, DRIVE_TOPIC, Recording
from ddh_twin_py.telemetry.screening.screening import StreamScreen, screen_by_sheet

_REPETITIONS = 3
_CHUNKS, _SAMPLES = 1000, 5
_SAMPLE_NS = 10_000_000
_LONGEST_CHUNK = 60.0  # µs: a node that hears two topics at 100 Hz in chunks of 50 ms spends less than 0.3 % of a core


def time_screening(recording: Recording, rig: Rig) -> list[Figure]:
    """Messages a second of a whole recording, and µs for one chunk of live drive telemetry."""
    values = np.random.default_rng(1).normal(size=(_SAMPLES, len(DRIVE_FIELDS)))
    stamps = _SAMPLE_NS * np.arange(_SAMPLES)
    screen = StreamScreen(DRIVE_TOPIC, {name: spec.noise for name, spec in rig.sensors.items()})

    def live() -> None:
        for k in range(_CHUNKS):
            screen.screen(stamps + k * _SAMPLES * _SAMPLE_NS, values)

    messages = sum(len(stream) for _, stream in recording.streams())
    return [Figure("screening a recording", messages / _best(lambda: screen_by_sheet(recording, rig)) / 1e3, "k messages/s", None),
            Figure(f"screening {_SAMPLES} live samples", _best(live) / _CHUNKS * 1e6, "µs", _LONGEST_CHUNK, "limit")]


def _best(run: Callable[[], object]) -> float:
    """Shortest of some runs, s; the first of all, in which kernels may be compiled, does not count."""
    run()
    times = []
    for _ in range(_REPETITIONS):
        started = time.perf_counter()
        run()
        times.append(time.perf_counter() - started)
    return min(times)
