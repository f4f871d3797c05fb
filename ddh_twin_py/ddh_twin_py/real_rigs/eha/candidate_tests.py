"""Tests of the actuator that can be made: the strokes of a record at another speed, or without its load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ddh_twin_py.real_rigs.eha.model import Stroke
from ddh_twin_py.real_rigs.eha.recordings import STEP, Actuation
from ddh_twin_py.real_rigs.next_test import DescribedTest

_SLOWER = 3  # times


def candidate_tests(record: Actuation) -> list[DescribedTest]:
    """Tests with the motions of a record; its loads, which are a brake's, are taken to stay where they are not taken off."""
    slow = _slower(record)
    slow_stroke = Stroke(slow)
    slow_stroke.asked = Stroke(record).asked
    free = Stroke(record)
    free.asked = np.zeros_like(free.asked)
    return [
        DescribedTest(f"Repeat {record.name} with the pump {_SLOWER} times slower and as much longer.", slow_stroke),
        DescribedTest(f"Take the load off and repeat {record.name}.", free),
    ]


def _slower(record: Actuation) -> Actuation:
    """The same way, `_SLOWER` times slower."""
    long = {name: np.repeat(getattr(record, name), _SLOWER) for name in ("position", "pressure_a", "pressure_b", "valve")}
    return replace(record, time=STEP * np.arange(long["valve"].size), speed=np.repeat(record.speed, _SLOWER) / _SLOWER, **long)
