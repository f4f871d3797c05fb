"""How fast the free run and the temperature filter are on a recording."""

from __future__ import annotations

import time

import numpy as np

from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.free_run import COMMAND_PARTS, HYDRAULIC_STEP, free_run, settle
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import DRIVE_FIELDS, Recording
from ddh_twin_py.twin.command import command_at
from ddh_twin_py.twin.intervals import INTERVAL, command_size

_RUNS = 3
_WARMTH, _PRESSURE = 296.15, 3.0e6  # K and Pa at the start


def time_recorded_run(recording: Recording, rig: Rig) -> list[Figure]:
    """Multiples of real time of a free run on recorded commands, and µs of the temperature filter for a tick."""
    result = replay(recording, rig)
    n = result.time.size
    stamps = recording.drive.time - recording.drive.time[0]
    command = command_at(stamps, recording.drive.values[:, DRIVE_FIELDS.index("speed_command")],
                         INTERVAL / COMMAND_PARTS * np.arange(command_size(n)))
    best = float("inf")
    for _ in range(_RUNS):
        state, temperature = np.zeros(len(HYDRAULIC_STATES)), np.full(N, _WARMTH)
        settle(rig.parameters, state, float(result.measured["rod_position"][0]), _PRESSURE, 0.0)
        points, temperatures = np.zeros(n, OPERATING_DTYPE), np.empty((n, N))
        started = time.perf_counter()
        free_run(rig.parameters, state, temperature, command, np.full(n, _WARMTH), INTERVAL, HYDRAULIC_STEP, np.full(n, np.nan), points,
                 temperatures)
        best = min(best, time.perf_counter() - started)
    return [Figure("free run on recorded commands", n * INTERVAL / best, "x real time", 10000.0, "aim", smaller=False),
            Figure("temperature filter, a tick", result.seconds["temperature_fusion"] / n * 1e6, "µs", 6.5, "numba filter")]
