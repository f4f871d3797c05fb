"""Ticks: intervals of time that all streams share, with what each of them told within.

A tick k covers t_{k-1} < t <= t_k with t_k = k * interval in absolute stamp time, in integer nanoseconds.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

INTERVAL = 0.05  # s
REORDER_WINDOW = 0.5
"""s by which a sample may come later than newer ones of its stream."""
LONGEST_GAP = 600.0
"""s without any sample that are filled with empty ticks; longer ones are skipped."""


@dataclass(frozen=True)
class Samples:
    """Samples of one stream within a tick: `stamp` int64[n] ns, ascending, `values` float64[n, m]."""

    stamp: np.ndarray
    values: np.ndarray

    def __len__(self) -> int:
        return self.stamp.size


@dataclass(frozen=True)
class Tick:
    """One interval, start_ns < t <= end_ns, with the samples of every stream (possibly none).

    `restart` is True where this tick does not follow the one before: the clock jumped back, or
    nothing came for so long that the time between was skipped. The first tick of all is no restart.
    `gap` is by how many s it begins after the end of the one before, below 0 after a jump back.
    """

    start_ns: int
    end_ns: int
    restart: bool
    samples: dict[str, Samples]
    gap: float = 0.0


@dataclass(frozen=True)
class Ticks:
    """All ticks of a recording.

    `end_ns` int64[n] and `restart` bool[n] as in Tick; `samples` holds all samples of each
    stream, those of tick i being first[name][i] <= j < last[name][i] (int64[n] each).
    """

    interval_ns: int
    end_ns: np.ndarray
    restart: np.ndarray
    samples: dict[str, Samples]
    first: dict[str, np.ndarray]
    last: dict[str, np.ndarray]

    def __len__(self) -> int:
        return self.end_ns.size

    @property
    def edges(self) -> np.ndarray:
        """Edges int64[n+1] in ns: tick i spans edges[i]..edges[i+1] unless restart[i]."""
        if not len(self):
            return np.empty(0, np.int64)
        return np.concatenate(([self.end_ns[0] - self.interval_ns], self.end_ns))

    def tick(self, i: int) -> Tick:
        """Tick i, as the live aligner would have given it."""
        end = int(self.end_ns[i])
        samples = {}
        for name, all_samples in self.samples.items():
            part = slice(self.first[name][i], self.last[name][i])
            samples[name] = Samples(all_samples.stamp[part], all_samples.values[part])
        return Tick(end - self.interval_ns, end, bool(self.restart[i]), samples, self.gap(i))

    def gap(self, i: int) -> float:
        """By how many s tick i begins after the end of the one before, 0 of the first."""
        return (int(self.end_ns[i]) - self.interval_ns - int(self.end_ns[i - 1])) * 1e-9 if i > 0 else 0.0

    def __iter__(self) -> Iterator[Tick]:
        return (self.tick(i) for i in range(len(self)))


def tick_index(stamp_ns, interval_ns: int):
    """Index k of the tick that holds a stamp: (k-1) * interval < stamp <= k * interval."""
    return -(-stamp_ns // interval_ns)


def to_ns(seconds: float) -> int:
    """Seconds as integer nanoseconds. Raises ValueError unless positive."""
    ns = round(seconds * 1e9)
    if ns <= 0:
        raise ValueError(f"an interval of {seconds} s was given, allowed is 1e-9 s or more")
    return ns
