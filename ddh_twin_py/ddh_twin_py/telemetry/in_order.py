"""Samples by time: streams hold messages as they were logged, which a late one puts out of order."""

from __future__ import annotations

import numpy as np


def in_order(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Places of the finite values, earliest first, those of one time as they came, int (k,).

    Args:
        time: s, (n,). values: (n,).
    """
    known = np.flatnonzero(np.isfinite(values))
    return known[np.argsort(time[known], kind="stable")]
