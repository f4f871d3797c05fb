"""What sensors with a lag read of temperatures that are known over time, such as those of a free run."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

_JUMP = 0.5  # K from one interval to the next, which no part that a sensor reads warms by


def lagged(temperature: np.ndarray, start: np.ndarray, interval: float, lag: np.ndarray) -> np.ndarray:
    """What sensors with first-order lags (m,), s, read of temperatures (n, m), which were at ``start`` (m,); both jump by `jumps`."""
    jumped = np.cumsum(jumps(np.diff(temperature, axis=0, prepend=temperature[:1])), axis=0)
    out = np.empty_like(temperature)
    for i, keep in enumerate(np.exp(-interval / lag)):
        out[:, i], _ = lfilter([1.0 - keep], [1.0, -keep], temperature[:, i] - jumped[:, i], zi=[keep * start[i]])
    return out + jumped


def jumps(change: np.ndarray) -> np.ndarray:
    """Of changes of a free run's temperatures from one interval to the next, K, those by which it was put to a reading; 0 elsewhere."""
    return np.where(np.abs(change) > _JUMP, change, 0.0)


class LaggedReadings:
    """What sensors with first-order lags (m,), s, read of temperatures that come piece by piece; at a begin they read what they are at."""

    def __init__(self, lag: np.ndarray) -> None:
        self._lag = lag
        self.begin_anew()

    def begin_anew(self) -> None:
        """What comes next does not follow what came last."""
        self._last: tuple[np.ndarray, np.ndarray] | None = None  # temperatures and what sensors read of them, (m,) each

    def follow(self, temperature: np.ndarray, interval: float) -> np.ndarray:
        """What they read, (n, m), of the temperatures that come next, (n, m), so many s apart."""
        was, read = self._last or (temperature[0], temperature[0])
        seen = lagged(temperature, read + jumps(temperature[0] - was), interval, self._lag) if interval > 0.0 else temperature
        self._last = temperature[-1], seen[-1]
        return seen
