"""What the temperature filter answers: estimates of intervals, and how the readings in them agreed with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fusion.left_together import LeftTogether


@dataclass(frozen=True, slots=True)
class Innovation:
    """One reading against what was expected: interval, sensor, both in K, expected deviation, whether it was used.

    The index counts from the start of the call that applied it; a reading of an earlier call has one below 0.
    """

    index: int
    sensor: str
    measured: float
    expected: float
    standard_deviation: float
    accepted: bool


@dataclass(frozen=True)
class FusionResult:
    """Estimates of n intervals.

    Attributes:
        temperature, standard_deviation: K, (n, N). ambient: K, (n,).
        reading: K, what each sensor of `SENSORS` should have read, offset left out, (n, m).
        reading_standard_deviation: K, (m,), at the end. innovations: of the readings applied.
        begun_anew: where sensors left the filter's band together, and it began anew from what they read.
    """

    temperature: np.ndarray
    standard_deviation: np.ndarray
    ambient: np.ndarray
    reading: np.ndarray
    reading_standard_deviation: np.ndarray
    innovations: list[Innovation]
    begun_anew: list[LeftTogether]
