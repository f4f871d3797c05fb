"""Fewer points for a chart, without losing a peak or a gap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

MOST_POINTS = 24000
"""A chart keeps at least every sample up to this many."""


def min_max_indices(series: Sequence[np.ndarray], buckets: int) -> np.ndarray:
    """Samples to keep so that every series shows its extremes in every bucket.

    The n samples are cut into ``buckets`` runs of equal length. From each run the smallest
    and the largest value of each series is kept at its own time, and the first missing value,
    so that a gap stays a gap; the first and last sample are kept as well.

    Args:
        series: arrays of one length n; NaN is missing.
        buckets: number of runs, 1 or more.
    Returns:
        increasing indices, int64, at most ``3 * len(series) * buckets + 2`` of them.
    """
    n = series[0].size
    if n == 0:
        return np.zeros(0, np.int64)
    width = -(-n // buckets)
    rows = -(-n // width)
    kept = [np.array([0, n - 1])]
    start = np.arange(rows) * width
    for values in series:
        missing = np.isnan(values)
        for fill, pick in ((np.inf, np.argmin), (-np.inf, np.argmax)):
            padded = np.full(rows * width, fill)
            padded[:n] = np.where(missing, fill, values)
            padded = padded.reshape(rows, width)
            at = pick(padded, axis=1)
            kept.append((start + at)[padded[np.arange(rows), at] != fill])
        if missing.any():
            padded_missing = np.zeros(rows * width, dtype=bool)
            padded_missing[:n] = missing
            padded_missing = padded_missing.reshape(rows, width)
            kept.append((start + padded_missing.argmax(axis=1))[padded_missing.any(axis=1)])
    return np.unique(np.concatenate(kept))


def decimated(
    time: np.ndarray, series: Sequence[np.ndarray], most: int = MOST_POINTS
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Time and series with at most about ``most`` points, peaks kept; all of them where that is few enough."""
    if time.size <= most:
        return time, list(series)
    chosen = min_max_indices(series, max(1, most // (2 * max(1, len(series)))))
    return time[chosen], [values[chosen] for values in series]


def mean_and_ends(time: np.ndarray, values: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean, lowest and highest of the samples between edges, (k - 1,) each; NaN where there are none.

    For what scatters: extremes drawn as samples would look like lines of their own, every so many samples would lose peaks.

    Args:
        time: (n,). values: (n,); NaN is missing. edges: (k,), increasing; a sample on an edge belongs to what ends there, one outside to
            what is nearest.
    """
    bins = edges.size - 1
    there = np.isfinite(values)
    at, found = np.clip(np.searchsorted(edges, time[there]) - 1, 0, bins - 1), values[there]
    count = np.bincount(at, minlength=bins)
    low, high = np.full(bins, np.inf), np.full(bins, -np.inf)
    np.minimum.at(low, at, found)
    np.maximum.at(high, at, found)
    total = np.bincount(at, found, bins)
    return tuple(np.where(count > 0, of, np.nan) for of in (total / np.maximum(count, 1), low, high))
