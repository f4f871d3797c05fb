"""Sensors that leave the filter's band together: then it is the state that is wrong, and not they.

One sensor that steps is refused, as it may have come loose. Where most leave in the same seconds the unit is not what the filter takes it
for, as a simulation that was started anew, or a machine that was swapped or warmed while nobody looked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fusion.outvoted import HEARD
from ddh_twin_py.estimation.fusion.temperature_filter import AGREEING, GATE, NEVER_READ
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

TOGETHER = 5.0
"""s within which sensors leave together."""
_CONFIRMED = 2  # readings in a row that are refused, and say the same: one of all at once may be a disturbance
_FEWEST = 3  # sensors that are most of those that speak
_FEWEST_OF_ALL = 2  # that are all
_FARTHEST = 50.0  # K from what is expected, beyond which readings are of no unit that stands there, whoever tells them


@dataclass(frozen=True)
class LeftTogether:
    """Sensors that left the band together, by name: with which interval it was told, counted from the start of a call, and the reason."""

    index: int
    sensors: tuple[str, ...]
    why: str


class Departures:
    """When each sensor left the filter's band: times of its last reading that was used, and of the first refused after it, s."""

    def __init__(self) -> None:
        size = len(SENSORS)
        self._now = 0.0
        self._used, self._left = np.full(size, -np.inf), np.full(size, -np.inf)
        self._measured, self._expected, self._spread = (np.full(size, np.nan) for _ in range(3))  # K, of the newest reading

    def pass_by(self, seconds: float) -> None:
        """So much time went by, s."""
        self._now += seconds

    def take(self, sensor: np.ndarray, measured: np.ndarray, expected: np.ndarray, spread: np.ndarray, accepted: np.ndarray) -> None:
        """Take in readings of now in the order in which they were applied, as of `Innovation`, (r,) each."""
        for k, used in zip(sensor.tolist(), accepted.tolist(), strict=True):
            if used:
                self._used[k] = self._now
            elif self._left[k] <= self._used[k]:
                self._left[k] = self._now
        self._measured[sensor], self._expected[sensor], self._spread[sensor] = measured, expected, spread

    def together(self, index: int, refused: np.ndarray, last: np.ndarray, judged: np.ndarray, silent: np.ndarray) -> LeftTogether | None:
        """Sensors that left together, where most of those that spoke since did; None where too few did, or they were exchanged.

        Args:
            index: of the interval. refused: readings refused in a row, (m,), see `temperature_filter.update`. last: K, last two readings
                of each sensor, (m, 2). judged: whether its readings are put to the gate, bool (m,). silent: s since its newest one, (m,).
        """
        away = judged & (self._left > self._used)
        possible = np.abs(self._measured - self._expected) <= _FARTHEST
        off = away & (refused >= _CONFIRMED) & (np.abs(last[:, 0] - last[:, 1]) <= AGREEING) & possible
        if np.count_nonzero(off) < _FEWEST_OF_ALL:
            return None
        latest = int(np.argmax(np.where(off, self._left, -np.inf)))
        off &= self._left >= self._used[latest] - TOGETHER
        told = np.abs(self._measured - self._expected)[off].min()  # K; one that would have been believed as far off says nothing
        fused = judged & (refused != NEVER_READ) & (silent <= HEARD) & (off | ~away & (told > GATE * self._spread))
        spoke = fused & (silent <= self._now - self._left[off].min())
        count, most = np.count_nonzero(off), np.count_nonzero(spoke)
        enough = count >= _FEWEST and 2 * count > most or count >= _FEWEST_OF_ALL and count == np.count_nonzero(fused)
        if not enough or self._exchanged(off):
            return None
        return LeftTogether(index, tuple(SENSORS[k] for k in np.flatnonzero(off)), self._why(off, most))

    def _exchanged(self, off: np.ndarray) -> bool:
        """Whether they read what was expected of each other."""
        apart = np.abs(np.sort(self._measured[off]) - np.sort(self._expected[off]))
        return bool(np.all(apart <= GATE * self._spread[off].max()))

    def _why(self, off: np.ndarray, most: int) -> str:
        k = int(np.argmax(np.where(off, np.abs(self._measured - self._expected) / self._spread, -np.inf)))
        return (f"{np.count_nonzero(off)} of {most} temperature sensors tell together that the unit is not as warm as it was held to be: "
                f"{TEMPERATURE_PREFIX}{SENSORS[k]} reads {self._measured[k] - ZERO_CELSIUS:.2f} degC, expected were "
                f"{self._expected[k] - ZERO_CELSIUS:.2f} +- {self._spread[k]:.2f} degC; the estimate begins anew from what they read")
