"""Where a transducer ends although nobody told its full scale: it repeats its largest reading, which noise never does."""

from __future__ import annotations

import numpy as np

_OFTEN = 20  # times that the largest reading is there
_FINE = 0.25  # of the noise: steps up to which noise spreads readings, and within which others lie below the largest
_MORE = 2  # times as often as those


def sensor_end(values: np.ndarray, noise: float) -> float:
    """The largest of readings, (n,), at which their sensor ends, inf where it does not or this cannot be told; ``noise``: one deviation."""
    levels, counts = np.unique(values[np.isfinite(values)], return_counts=True)
    if noise <= 0.0 or levels.size < _OFTEN or counts[-1] < _OFTEN or np.diff(levels).min() > _FINE * noise:
        return np.inf
    below = counts[:-1][levels[:-1] > levels[-1] - _FINE * noise].sum()
    return float(levels[-1]) if counts[-1] > _MORE * below else np.inf
