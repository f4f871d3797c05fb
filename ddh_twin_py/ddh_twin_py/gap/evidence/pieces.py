"""Columns side by side, kept in pieces: what is added to them copies nothing of what is there.

All columns of half an hour's recording are some 140 MB, and several searches at once each add a few of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

Rows = Sequence[np.ndarray]
"""By recording: values (rows,) or columns (rows, m)."""


class Pieces:
    """Columns of several recordings.

    Args:
        pieces: columns that follow each other, each by recording, (rows, m).

    Attributes:
        size: of columns in all.
    """

    def __init__(self, pieces: Sequence[Rows]) -> None:
        self._pieces = list(pieces)
        self._ends = np.cumsum([0, *(piece[0].shape[1] for piece in self._pieces)])
        self.size = int(self._ends[-1])

    def with_more(self, piece: Rows) -> Pieces:
        """The same with further columns behind, by recording, (rows, m)."""
        return Pieces([*self._pieces, piece])

    def scaled(self, factor: float) -> Pieces:
        """The same, each so many times as large."""
        return self if factor == 1.0 else Pieces([[factor * rows for rows in piece] for piece in self._pieces])

    def against(self, values: Rows) -> np.ndarray:
        """Sums over all rows of the products with values (rows,) or columns (rows, m), by recording: (size,) or (size, m)."""
        parts = [sum(rows.T @ v for rows, v in zip(piece, values, strict=True)) for piece in self._pieces]
        return np.concatenate([np.empty((0, *values[0].shape[1:])), *parts])

    def times(self, x: np.ndarray) -> list[np.ndarray]:
        """What they make where each is taken x times, (size,) or (size, m): by recording, (rows,) or (rows, m)."""
        taken = [x[a:b] for a, b in pairwise(self._ends)]
        return [sum(rows @ part for rows, part in zip(own, taken, strict=True)) for own in zip(*self._pieces, strict=True)]
