"""How long a calibration takes: six parameters of a simulated rig that differs from the sheet in just these."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.estimation.fitting.calibration import calibrate
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording, Stream
from ddh_twin_py.twin.duty import Duty
from ddh_twin_py.twin.simulated_rig import SimulatedRig

SIX = ("pump_1.leakage", "pump_2.leakage", "pump_1.friction_pressure", "line_b.pressure_drop_laminar",
       "motor.speed_loop_time_constant", "motor.thermal.end_winding_to_housing")
_LIMIT = 3.0  # s, for 600 s of recording


def time_calibration(sheet: Rig, duty: Duty, seconds: float) -> list[Figure]:
    """Time of a fit (s) and RMS of its errors over its standard deviations; ``seconds`` of recording at 100 Hz."""
    exact = {path: q if path in SIX else replace(q, tolerance=0.0) for path, q in sheet.quantities.items()}
    simulated = SimulatedRig(replace(sheet, quantities=exact), duty, seed=7)
    recording = _joined(list(simulated.run(seconds)))
    calibrate([Experiment(recording.between(0.0, 20.0), sheet)], sheet, SIX[:1])  # kernels are compiled or read here
    started = time.perf_counter()
    fit = calibrate([Experiment(recording, sheet)], sheet, SIX)
    took = time.perf_counter() - started
    found = {p.name: p for p in fit.parameters}
    errors = [(found[path].value - simulated.rig[path]) / found[path].std for path in SIX]
    return [Figure(f"calibration of 6 parameters on {seconds:.0f} s", took, "s", _LIMIT * seconds / 600.0, "limit"),
            Figure("its errors over its standard deviations, RMS", float(np.sqrt(np.mean(np.square(errors)))), "1", None)]


def _joined(chunks: list[Recording]) -> Recording:
    """One recording of the chunks of a simulated rig."""
    parts: dict[str, list[Stream]] = {}
    for chunk in chunks:
        for topic, stream in chunk.streams():
            parts.setdefault(topic, []).append(stream)
    return chunks[0].with_streams({
        topic: Stream(np.concatenate([s.time for s in several]), np.concatenate([s.values for s in several]), several[0].fields)
        for topic, several in parts.items()})
