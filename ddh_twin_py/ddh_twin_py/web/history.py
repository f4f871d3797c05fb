"""What the page can look back on: all columns on a grid of data time, finer for the last minutes and coarser for hours.

A row's index counts steps of `GRID` since the epoch of the stamps. The finest level keeps rows as they came; a coarser
one keeps for each bin of rows the lowest and the highest value, so that no peak is lost. Each level is a ring.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

GRID_NS = 50_000_000
"""ns of data time between two rows."""
GRID = GRID_NS * 1e-9
"""The same in s."""


@dataclass(frozen=True)
class Level:
    """Rows in a bin (1: rows as they came) and bins that are kept."""

    rows: int
    kept: int

    @property
    def halves(self) -> int:
        """Values for each bin: one, or lowest and highest."""
        return 1 if self.rows == 1 else 2

    @property
    def step(self) -> float:
        """s of data between two values of a column."""
        return GRID * self.rows / self.halves


LEVELS = (Level(1, 2600), Level(20, 960), Level(160, 960))
"""130 s as they came, 16 min by seconds, 2 h 8 min by bins of 8 s."""


def row_index(stamps_ns: np.ndarray) -> np.ndarray:
    """Index of the row that a stamp belongs to: intervals end at their row's time. int64 (n,)."""
    return -(-np.asarray(stamps_ns, np.int64) // GRID_NS)


class History:
    """Rings of all levels for a number of columns."""

    def __init__(self, columns: int, levels: Sequence[Level] = LEVELS) -> None:
        self.levels = tuple(levels)
        self._tag = [np.full(level.kept, -1, np.int64) for level in levels]  # bin that each slot holds
        self._value = [np.full((level.halves, level.kept, columns), np.nan, np.float32) for level in levels]

    @property
    def reach(self) -> int:
        """Rows that the finest level keeps."""
        return self.levels[0].kept

    def write(self, first: int, index: np.ndarray, values: np.ndarray) -> None:
        """Put rows into the columns from `first` on: index int64 (n,) ascending, values (n, m)."""
        columns = slice(first, first + values.shape[1])
        for level, tag, value in zip(self.levels, self._tag, self._value, strict=True):
            if level.rows == 1:
                slot = self._claim(tag, value, index, level.kept)
                value[0, slot, columns] = values
                continue
            starts = np.flatnonzero(np.diff(index // level.rows, prepend=-1))
            slot = self._claim(tag, value, index[starts] // level.rows, level.kept)
            for half, of, over in ((0, np.fmin, np.fmin.reduceat), (1, np.fmax, np.fmax.reduceat)):
                value[half, slot, columns] = of(value[half, slot, columns], over(values, starts, axis=0))

    @staticmethod
    def _claim(tag: np.ndarray, value: np.ndarray, bins: np.ndarray, kept: int) -> np.ndarray:
        """Slots of the bins; one that held another bin is emptied."""
        slot = bins % kept
        other = tag[slot] != bins
        if other.any():
            value[:, slot[other]] = np.nan
            tag[slot[other]] = bins[other]
        return slot

    def forget_from(self, first: int, count: int, index: int) -> None:
        """The clock of these columns jumped back to `index`: what they hold of later times is of another run."""
        for level, tag, value in zip(self.levels, self._tag, self._value, strict=True):
            later = tag >= index // level.rows
            value[:, later, first : first + count] = np.nan

    def read(self, number: int, columns: Sequence[int], newest: int, seconds: float) -> tuple[int, np.ndarray]:
        """The last `seconds` up to the row `newest`, of one level.

        Returns the number of the first value, counted in steps of that level, and float32 (n, len(columns)), NaN where nothing came.
        """
        level, tag, value = self.levels[number], self._tag[number], self._value[number]
        last = newest // level.rows
        count = min(level.kept, max(1, round(seconds / (GRID * level.rows))))
        bins = np.arange(last - count + 1, last + 1)
        slot = bins % level.kept
        found = value[:, slot][:, :, list(columns)]
        found[:, tag[slot] != bins] = np.nan
        return int(bins[0]) * level.halves, np.ascontiguousarray(found.transpose(1, 0, 2)).reshape(count * level.halves, -1)
