"""Times of a recording as charts need them."""

from __future__ import annotations

import numpy as np


def going_on(time: np.ndarray) -> np.ndarray:
    """Times that always rise, s: where the clock jumped back they go on from where they were."""
    step = np.diff(time)
    if (step > 0.0).all():
        return time
    usual = float(np.median(step[step > 0.0])) if (step > 0.0).any() else 1.0
    return np.concatenate([time[:1], time[:1] + np.cumsum(np.where(step > 0.0, step, usual))])


def starts(time: np.ndarray) -> np.ndarray:
    """Indices at which times begin: the first, and each where the clock jumped back."""
    return np.concatenate([np.zeros(min(1, time.size), np.int64), np.flatnonzero(np.diff(time) <= 0.0) + 1])
