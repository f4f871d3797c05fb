"""Tests of the axis that can be made: other courses of the reference, a known load on the carriage."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ddh_twin_py.real_rigs.emps.model import Axis
from ddh_twin_py.real_rigs.emps.recordings import STEP, EmpsRecord
from ddh_twin_py.real_rigs.next_test import DescribedTest

_LOAD = 20.0  # kg
_CREEP, _CREEPING = 0.002, 10.0  # m/s, s each way
_SHAKE, _SHAKING, _FASTEST = 2.0e-4, 20.0, 15.0  # m, s, Hz at the end
_RAMP = 0.5  # s in which a motion begins


class LoadedAxis(Axis):
    """A test with a known mass, kg, on the carriage."""

    def __init__(self, record: EmpsRecord, noise: float, mass: float) -> None:
        super().__init__(record, noise)
        self._mass = mass

    def simulate(self, record: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        loaded = record.copy()
        loaded["payload"] += self._mass
        return super().simulate(loaded)


def candidate_tests(record: EmpsRecord, noise: float) -> list[DescribedTest]:
    """Tests under the same controller.

    Args:
        record: whose gains, reference and middle are taken. noise: N, of one sample.
    """
    middle = float(np.mean(record.reference))
    time = STEP * np.arange(round(2.0 * _CREEPING / STEP))
    there = np.minimum(time, 2.0 * _CREEPING - time)
    creep = middle + _CREEP * (there - 0.5 * _CREEPING)
    time = STEP * np.arange(round(_SHAKING / STEP))
    shake = middle + _SHAKE * np.minimum(time / _RAMP, 1.0) * np.sin(np.pi * _FASTEST * time**2 / _SHAKING)
    return [
        DescribedTest(f"Let the carriage creep at {1e3 * _CREEP:g} mm/s for {_CREEPING:g} s each way.", Axis(_blank(record, creep), noise)),
        DescribedTest(f"Shake the carriage by {1e3 * _SHAKE:g} mm, from 0 to {_FASTEST:g} Hz in {_SHAKING:g} s.",
                      Axis(_blank(record, shake), noise)),
        DescribedTest(f"Put {_LOAD:g} kg on the carriage and repeat the identification record.",
                      LoadedAxis(_blank(record, record.reference), noise, _LOAD)),
    ]


def _blank(record: EmpsRecord, reference: np.ndarray) -> EmpsRecord:
    """A record of a reference, m, (n,), that nothing was measured in."""
    nothing = np.zeros(reference.size)
    return EmpsRecord(Path("candidate test"), STEP * np.arange(reference.size), reference, reference.copy(), nothing, nothing,
                      record.force_gain, record.position_gain, record.velocity_gain)
