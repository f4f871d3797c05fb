"""What the temperature filter is given: what the models say about intervals, and readings of sensors in them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.physics.thermal_network import N, N_FLOWS
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.sensor_errors import take_off_air


@dataclass(frozen=True)
class FusionInputs:
    """What the models say about n intervals.

    Attributes:
        heat: W into each node, copper loss left out, (n, N). mean_square_current: A^2, (n,).
        flow: m3/s, (n, N_FLOWS), see `thermal_network.FLOWS`. rod_position: m, (n,).
        hydraulics_known, motor_known: whether the telemetry behind them was there, (n,) bool.
        ambient: K, (n,), NaN where not read.
    """

    heat: np.ndarray
    mean_square_current: np.ndarray
    flow: np.ndarray
    rod_position: np.ndarray
    hydraulics_known: np.ndarray
    motor_known: np.ndarray
    ambient: np.ndarray

    @classmethod
    def unknown(cls, n: int) -> FusionInputs:
        """Inputs where no model spoke for n intervals."""
        return cls(np.zeros((n, N)), np.zeros(n), np.zeros((n, N_FLOWS)), np.zeros(n), np.zeros(n, dtype=bool),
                   np.zeros(n, dtype=bool), np.full(n, np.nan))

    def __len__(self) -> int:
        return self.heat.shape[0]


@dataclass(frozen=True, slots=True)
class Reading:
    """One reading: index of its interval in the call, below 0 for one that comes late, name of the sensor, K."""

    index: int
    sensor: str
    temperature: float


@dataclass(frozen=True)
class Readings:
    """Many readings as arrays, in order of their intervals: index (r,), sensor as index into `SENSORS` (r,), K (r,)."""

    index: np.ndarray
    sensor: np.ndarray
    temperature: np.ndarray

    @classmethod
    def of(cls, readings: Sequence[Reading]) -> Readings:
        """The readings of network nodes among ``readings``; ``ambient``, unknown sensors and NaN are left out."""
        good = sorted((r for r in readings if r.sensor in NODE_INDEX and np.isfinite(r.temperature)), key=lambda r: r.index)
        return cls(np.array([r.index for r in good], dtype=np.int64), np.array([SENSORS.index(r.sensor) for r in good], dtype=np.int64),
                   np.array([r.temperature for r in good], dtype=float))

    def off_the_air(self, air: np.ndarray, rig: Rig) -> Readings:
        """As sensors would read that touch their surfaces well, where the air had ``air``, K, by interval, (n,), the last before them."""
        return replace(self, temperature=take_off_air(self.temperature, self.sensor, air[np.maximum(self.index, -1)], rig))

    def where(self, kept: np.ndarray) -> Readings:
        """Those that are kept, bool (r,)."""
        return Readings(self.index[kept], self.sensor[kept], self.temperature[kept])

    def without(self, sensors: Collection[str]) -> Readings:
        """Those of the other sensors."""
        return self.where(~np.isin(self.sensor, [SENSORS.index(name) for name in sensors if name in SENSORS]))

    def between(self, start: int, stop: int) -> Readings:
        """Those of the intervals start..stop, counted from start."""
        rows = slice(*np.searchsorted(self.index, (start, stop)))
        return Readings(self.index[rows] - start, self.sensor[rows], self.temperature[rows])


def air_of(readings: Sequence[Reading], n: int) -> np.ndarray:
    """What the air's sensor read in n intervals, K, (n,), NaN where it did not."""
    air = np.full(n, np.nan)
    for reading in readings:
        if reading.sensor == "ambient" and reading.index >= 0 and np.isfinite(reading.temperature):
            air[reading.index] = reading.temperature
    return air
