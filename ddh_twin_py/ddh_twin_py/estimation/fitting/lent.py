"""Arrays that free runs fill, lent to each thread again and again: fresh ones of half an hour would cost ten thousand page faults."""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.free_run import SAMPLED
from ddh_twin_py.physics.thermal_network import N

_own = threading.local()


class Lent(NamedTuple):
    """Where a free run writes: operating points, `OPERATING_DTYPE` (n,), temperatures, K, (n, N), and samples, (m, `SAMPLED`)."""

    points: np.ndarray
    temperatures: np.ndarray
    samples: np.ndarray


def made(intervals: int, instants: int) -> Lent:
    """New ones, for whoever keeps them."""
    return Lent(np.zeros(intervals, OPERATING_DTYPE), np.empty((intervals, N)), np.empty((instants, len(SAMPLED))))


def lend(intervals: int, instants: int) -> Lent:
    """Those of this thread, filled with what was written last; whoever needs them beyond the next call copies."""
    known = getattr(_own, "lent", None)
    if known is None or known.points.size < intervals or known.samples.shape[0] < instants:
        least = (0, 0) if known is None else (known.points.size, known.samples.shape[0])
        known = _own.lent = made(max(intervals, least[0]), max(instants, least[1]))
    return Lent(known.points[:intervals], known.temperatures[:intervals], known.samples[:instants])
