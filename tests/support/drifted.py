"""Short recordings of one rig of the independent plant, as built and with one effect since then."""

import functools
from dataclasses import replace

import numpy as np
from ddh_twin_py.gap_bench.duties import drawn
from ddh_twin_py.gap_bench.recordings import recording_of
from ddh_twin_py.plant.listed_faults import LISTED
from ddh_twin_py.plant.machine import build
from ddh_twin_py.plant.sensors import SENSORS, Instruments, measure
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Recording

PAYLOAD = 150.0  # kg


@functools.cache
def recorded(seconds: float, effect: str = "", departure: float = 0.0, sensors: tuple[str, ...] = SENSORS, seed: int = 4) -> Recording:
    """A recording of `seconds` s of the one rig of this seed; `departure` in the effect's own unit, '' is none."""
    sheet, rng = load_rig(), np.random.default_rng(seed)
    machine = build(sheet, rng)
    tools = Instruments.drawn(sheet, machine.rig["sensors.temperature.time_constant"], rng)
    rng = np.random.default_rng((seed, int(seconds)))
    duty = drawn(rng, seconds, PAYLOAD, 20.0, False)
    course = machine.run(duty.exercise, [(LISTED[effect], departure)] if effect else [], duty.drive_time, duty.hydraulic_time)
    readings = measure(course, tools, duty.exercise.ambient, sensors, 0.5, rng)
    return replace(recording_of(readings, "drifted", PAYLOAD, 10**18), path=f"{effect or 'new'}_{seconds:.0f}")
