"""In which steps a channel is given, read from its values: many a logger keeps whole degrees."""

from __future__ import annotations

import math

import numpy as np

_EXACT = 1e-3  # of a step by which values may lie beside it: numbers of single precision
_FINEST = 1e-4  # steps below this count as none, and what values are rounded to
_BINARY = 5e-3  # steps above this may be no multiples of that, as 1/64 is none
_REPEATED = 5  # samples of each value on average, fewer are chance


def resolution(values: np.ndarray) -> float:
    """The step that values, (n,) with NaN where there is none, are multiples of apart; 0 where they are not given in steps."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0
    given = np.unique(np.round(known / _FINEST)) * _FINEST
    if given.size < 2 or known.size < _REPEATED * given.size:
        return 0.0
    steps = np.diff(given)
    step = float(steps.min())
    counted = steps / step
    exact = max(_EXACT, _FINEST / step) if step > _BINARY else _EXACT
    return step if np.all(np.abs(counted - np.round(counted)) <= exact * np.maximum(1.0, counted)) else 0.0


def rounding_error(values: np.ndarray) -> float:
    """Standard deviation of what rounding to the step of `resolution` takes, step/sqrt(12)."""
    return resolution(values) / math.sqrt(12.0)
