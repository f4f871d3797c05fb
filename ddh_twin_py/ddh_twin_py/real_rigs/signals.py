"""Signals of a recording prepared for free runs: noise as the recording itself shows it, bins, what is held out."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fitting.binning import Binning, one_by_one
from ddh_twin_py.estimation.fitting.experiment import Signal


def noise_of_repeats(values: np.ndarray, period: int) -> float:
    """Standard deviation of one sample among repeats of the same motion, from a record of at least two periods.

    Args:
        values: (n,). period: samples after which the input repeats itself.
    """
    count = values.size // period
    return float(np.sqrt(np.mean(values[: count * period].reshape(count, period).var(axis=0, ddof=1))))


def binned(time: np.ndarray, width: float, kind: np.ndarray | None = None, used: np.ndarray | None = None) -> Binning:
    """Bins of equal ``width`` (s) that belong to no phase; a bin holds samples of one kind.

    Args:
        time: s, (n,), increasing. kind: class of each sample, (n,): what a flaw of the model would shift together; None is one class.
        used: samples that count, (n,); None is all.
    """
    kind = np.zeros(time.size, dtype=np.int64) if kind is None else np.asarray(kind, dtype=np.int64)
    used = np.ones(time.size, dtype=bool) if used is None else used
    place = np.floor((time - time[0]) / width).astype(np.int64)
    change = np.concatenate([[0], np.cumsum((np.diff(place) != 0) | (np.diff(kind) != 0))])
    index = np.full(time.size, -1)
    _, first, index[used], count = np.unique(change[used], return_index=True, return_inverse=True, return_counts=True)
    which = np.flatnonzero(used)[first]
    mean = np.bincount(index[used], time[used], count.size) / np.maximum(count, 1)
    return Binning(index, count, kind[which], np.full(count.size, -1), mean)


def signal(time: np.ndarray, measured: np.ndarray, noise: float, unit: str, width: float | None = None, kind: np.ndarray | None = None,
           used_until: float = np.inf, held_from: float = np.inf) -> Signal:
    """A signal of which samples up to ``used_until`` (s) are used and those after ``held_from`` (s) are held out.

    Args:
        time: s, (n,). measured: (n,), NaN where missing. noise: of one sample, in ``unit``.
        width: of the bins, s; None makes every sample its own. kind: see `binned`.
    """
    used = np.isfinite(measured) & (time <= used_until)
    binning = one_by_one(time, used, kind) if width is None else binned(time, width, kind, used)
    return Signal(time, measured, noise, unit, binning, held_from=held_from)
