"""Recordings of simulated rigs for tests of the estimation."""

import functools
from pathlib import Path

import numpy as np
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Recording, Stream
from ddh_twin_py.twin.duty import load_duty, parse_duty
from ddh_twin_py.twin.simulated_rig import SimulatedRig

DUTY = Path(__file__).parents[2] / "ddh_twin_py" / "config" / "duty"


def joined(chunks):
    """One recording of the chunks of a simulated rig."""
    def cat(pick):
        parts = [pick(chunk) for chunk in chunks]
        return Stream(np.concatenate([p.time for p in parts]), np.concatenate([p.values for p in parts]), parts[0].fields)

    return Recording(
        "simulated", 0, chunks[0].rig, cat(lambda c: c.drive), cat(lambda c: c.hydraulic),
        {name: cat(lambda c, name=name: c.temperatures[name]) for name in chunks[0].temperatures},
    )


def of_the_sheet(duty: str, seconds: float, seed: int = 1) -> Recording:
    """A recording of the reference rig itself on a duty, given as the text of its file."""
    return joined(list(SimulatedRig(load_rig(), parse_duty(duty), seed, exactly=True).run(seconds)))


@functools.cache
def simulated(seed, duty="mixed", seconds=240.0):
    """A recording and the true temperatures at its end, K."""
    rig = SimulatedRig(load_rig(), load_duty(DUTY / f"{duty}.yaml"), seed)
    recording = joined(list(rig.run(seconds)))
    return recording, rig.truth()
