"""How long a diagnosis of a long recording takes, and how much memory: a rig of the independent plant, all sensors, 50 Hz."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.benchmarks.timed_process import timed
from ddh_twin_py.gap_bench.duties import drawn
from ddh_twin_py.gap_bench.recordings import recording_of
from ddh_twin_py.plant.listed_faults import LISTED
from ddh_twin_py.plant.machine import build
from ddh_twin_py.plant.sensors import SENSORS, Instruments, measure
from ddh_twin_py.rig import Rig

COMMISSIONED = {"pump_1.leakage": 0.12, "motor.cooling": -0.45}
"""Effects since the rig was commissioned, and their departures."""
UNCOMMISSIONED = {"motor.copper_resistance": 0.25}
"""The same where no recording tells how the rig was built."""
FULL = 1800.0
_RATE, _SLOW_RATE = 50.0, 1.0  # Hz
_COMMISSIONING, _VALIDATION = 600.0, 540.0  # s
_SECONDS, _MEGABYTES = 180.0, 2000.0
_SHARE = re.compile(r"^diagnosing: (\d+) %", re.MULTILINE)  # of a line that `ddh-twin gap` tells now and then
_DAY = 86_400 * 10**9
_EPOCH = 1_767_225_600 * 10**9


def time_diagnosis(sheet: Rig, scratch: Path, seconds: float = FULL, progress: Callable[[float], None] | None = None) -> list[Figure]:
    """Time (s) and peak memory (MB) of `ddh-twin gap`, a process of its own, with and without commissioning.

    Args:
        scratch: folder for the recordings. seconds: of field data; limits are stated for `FULL` alone.
        progress: told the share done.

    Raises:
        ProcessFailed: the diagnosis ended without a report.
    """
    figures, cases = [], ((True, COMMISSIONED), (False, UNCOMMISSIONED))
    for k, (commissioned, effects) in enumerate(cases):
        label = "with" if commissioned else "without"
        make_case(scratch / label, sheet, effects, commissioned, seconds)
        took, memory, verdict = _diagnosed(scratch / label, scratch / "report.json",
                                             progress and (lambda share, k=k: progress((k + share) / len(cases))))
        name = f"diagnosis of {seconds / 60:.0f} min at 50 Hz, {label} commissioning"
        limits = (_SECONDS, _MEGABYTES, "limit") if seconds == FULL else (None, None, "")
        figures += [Figure(f"{name} ({verdict})", took, "s", limits[0], limits[2]),
                    Figure(f"{name}, peak memory", memory, "MB", limits[1], limits[2])]
    return figures


def make_case(case: Path, sheet: Rig, effects: dict[str, float], commissioned: bool, seconds: float) -> None:
    """Write the bags of one rig, always the same one, with effects acting in field and validation."""
    rng = np.random.default_rng(50)
    machine = build(sheet, rng)
    instruments = Instruments.drawn(sheet, machine.rig["sensors.temperature.time_constant"], rng)
    parts = {"commissioning": _COMMISSIONING, "field": seconds, "validation": _VALIDATION}
    for days, (part, duration) in enumerate(parts.items()):
        duty = drawn(rng, duration, 180.0, _RATE, warm=False)
        if part == "commissioning" and not commissioned:
            continue
        faults = [] if part == "commissioning" else [(LISTED[name], departure) for name, departure in effects.items()]
        course = machine.run(duty.exercise, faults, duty.drive_time, duty.hydraulic_time)
        readings = measure(course, instruments, duty.exercise.ambient, SENSORS, _SLOW_RATE, rng)
        write_recording(case / part, recording_of(readings, case.name, duty.exercise.payload, _EPOCH + days * _DAY))


def _diagnosed(case: Path, out: Path, progress: Callable[[float], None] | None) -> tuple[float, float, str]:
    """Seconds, megabytes and verdict; reading of the bags included."""

    def told(said: str) -> None:
        if progress is not None and (shares := _SHARE.findall(said)):
            progress(float(shares[-1]) / 100.0)

    seconds, megabytes = timed("gap", str(case), "--json", str(out), told=told)
    return seconds, megabytes, json.loads(out.read_text())["verdict"]
