"""Samples of a sensor, at whatever rate, to the means of the rows that they fall into."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.web.history import row_index


class RowMeans:
    """Means of the samples of each row; a row is given out once a sample of a later one came.

    A value that is not a number counts as none; a row that holds nothing else stays NaN.
    """

    def __init__(self, width: int) -> None:
        self._index: int | None = None
        self._total, self._count = np.zeros(width), np.zeros(width)

    def add(self, stamps_ns: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows that are complete: index int64 (k,), means (k, m), of samples int64 (n,) in ns and (n, m)."""
        index = row_index(stamps_ns)
        there = np.isfinite(values)
        starts = np.flatnonzero(np.diff(index, prepend=index[0] - 1)) if index.size else np.empty(0, int)
        if not starts.size:
            return np.empty(0, np.int64), np.empty((0, self._total.size))
        total = np.add.reduceat(np.where(there, values, 0.0), starts, axis=0)
        count = np.add.reduceat(there, starts, axis=0, dtype=float)
        rows = index[starts]
        if self._index is not None:
            if rows[0] == self._index:
                total[0] += self._total
                count[0] += self._count
            else:
                rows = np.concatenate(([self._index], rows))
                total, count = np.vstack((self._total, total)), np.vstack((self._count, count))
        self._index, self._total, self._count = int(rows[-1]), total[-1], count[-1]
        return rows[:-1], np.divide(total[:-1], count[:-1], out=np.full_like(total[:-1], np.nan), where=count[:-1] > 0)

    def flush(self) -> tuple[np.ndarray, np.ndarray]:
        """The row in hand, where nothing more came for a while; none where there is none."""
        if self._index is None:
            return np.empty(0, np.int64), np.empty((0, self._total.size))
        mean = np.divide(self._total, self._count, out=np.full_like(self._total, np.nan), where=self._count > 0)
        index, self._index = self._index, None
        return np.array([index], np.int64), mean[None]
