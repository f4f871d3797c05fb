"""Samples gathered into bins that keep what a fit can learn: transients finely, steady stretches coarsely.

A cycle repeats itself, so that most samples say the same again. The mean over a bin carries
nearly all their information at a hundredth of their number, and its noise is known. Bins of one
class (the same place in the cycle, at a like speed) are those that a flaw of the model's laws
would shift together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.physics.compiled import kernel

PHASES = ("lifting", "lowering", "holding", "transient")
STEADY = PHASES[:3]
LIFTING, LOWERING, HOLDING, TRANSIENT = range(4)
TRANSIENT_TIME = 0.3
"""s after a step of the speed command that count as transient."""

_TRANSIENT_BIN = 0.05  # s
_STEADY_BIN = 0.8  # s
_STANDING_BIN = 2.5  # s
_QUIET = 1e-3  # of the largest command: a smaller change is none
_LEVELS = 3  # classes of speed
_PLACES = 3  # classes along a steady stretch


@dataclass(frozen=True)
class Binning:
    """Which bin each sample belongs to.

    Attributes:
        bin: index of the bin of each sample, -1 where it counts nowhere, (n,).
        count: samples in each bin, (b,).
        kind: class of each bin, (b,).
        phase: index into `PHASES` of each bin, -1 where phases do not apply, (b,).
        time: s, mean time of each bin, (b,).
    """

    bin: np.ndarray
    count: np.ndarray
    kind: np.ndarray
    phase: np.ndarray
    time: np.ndarray

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Means of samples (n,) over each bin, (b,)."""
        total = np.zeros(self.count.size)
        _sum_by_bin(self.bin, values, total)
        return total / self.count


@kernel
def _sum_by_bin(bins, values, total):
    """Add values (n,) to the sums of their bins, (b,); one of bin -1 counts nowhere."""
    for i in range(bins.shape[0]):
        if bins[i] >= 0:
            total[bins[i]] += values[i]


@dataclass(frozen=True)
class Cycle:
    """Where in the cycle each edge of a fine time grid lies, from the speed command alone.

    Attributes:
        time: s, (m,). label: number of the stretch (transient pieces, steady pieces), (m,).
        kind: class, (m,). phase: index into `PHASES`, (m,).
    """

    time: np.ndarray
    label: np.ndarray
    kind: np.ndarray
    phase: np.ndarray


def cycle_of(command: np.ndarray, step: float) -> Cycle:
    """Divide a run by its speed command.

    Args:
        command: rad/s, at consecutive edges of a grid, (m,). step: s, between them.
    """
    m = command.size
    time = step * np.arange(m)
    largest = float(np.max(np.abs(command), initial=0.0)) or 1.0
    changing = np.abs(np.diff(command, append=command[-1])) > _QUIET * largest
    begun = np.where(changing, time, -np.inf)
    last_change = np.maximum.accumulate(begun)  # last time at which the command changed
    transient = time - last_change <= TRANSIENT_TIME
    edge = np.diff(transient.astype(np.int8), prepend=0) == 1
    # within a long transient a new one begins where the command, after a pause, changes again
    paused = changing & (np.concatenate([[True], ~changing[:-1]])) & transient
    start = np.maximum.accumulate(np.where(edge | paused, np.arange(m), 0))
    since = (np.arange(m) - start) * step
    level = np.sign(command) * np.ceil(_LEVELS * np.abs(command) / largest - _QUIET)
    level[np.abs(command) < _QUIET * largest] = 0.0

    target = _target_level(level, changing)
    before = level[np.maximum(start - 1, 0)]
    piece = np.minimum((since / _TRANSIENT_BIN).astype(np.int64), 31)

    stretch = np.maximum.accumulate(np.where(np.diff(transient.astype(np.int8), prepend=1) == -1, np.arange(m), 0))
    into = (np.arange(m) - stretch) * step
    width = np.where(level == 0.0, _STANDING_BIN, _STEADY_BIN)
    place = (into / width).astype(np.int64)

    kind = np.where(transient, 100000 + ((before + _LEVELS) * 10 + target + _LEVELS) * 100 + piece,
                    (level + _LEVELS) * 10 + np.minimum(place, _PLACES - 1)).astype(np.int64)
    own = np.where(transient, piece, place)
    begun_at = np.where(transient, start, stretch)
    change = np.ones(m, dtype=bool)
    change[1:] = (kind[1:] != kind[:-1]) | (own[1:] != own[:-1]) | (begun_at[1:] != begun_at[:-1])
    phase = np.where(transient, TRANSIENT, np.where(level > 0.0, LIFTING, np.where(level < 0.0, LOWERING, HOLDING)))
    return Cycle(time, np.cumsum(change) - 1, kind, phase)


def _target_level(level: np.ndarray, changing: np.ndarray) -> np.ndarray:
    """Level at which the command comes to rest after each edge, (m,)."""
    m = level.size
    following = np.where(~changing, np.arange(m), m - 1)
    return level[np.minimum.accumulate(following[::-1])[::-1]]


def by_cycle(cycle: Cycle, time: np.ndarray, usable: np.ndarray, begin: float = 0.0) -> Binning:
    """Bins of fast samples at ``time`` (s, (n,)); those before ``begin`` or not ``usable`` are left out."""
    step = cycle.time[1] - cycle.time[0] if cycle.time.size > 1 else 1.0
    at = np.clip((time / step).astype(np.int64), 0, cycle.time.size - 1)
    used = usable & (time >= begin) & (time <= cycle.time[-1] + step)
    return _gather(np.where(used, cycle.label[at], -1), cycle.kind[at], cycle.phase[at], time)


def by_time(time: np.ndarray, usable: np.ndarray, width: float, begin: float = 0.0) -> Binning:
    """Bins of equal ``width`` (s) for slow samples."""
    used = usable & (time >= begin)
    label = np.where(used, (time / width).astype(np.int64), -1)
    return _gather(label, np.zeros(time.size, dtype=np.int64), np.full(time.size, -1), time)


def one_by_one(time: np.ndarray, usable: np.ndarray, kind: np.ndarray | None = None) -> Binning:
    """Every usable sample is its own bin."""
    label = np.where(usable, np.arange(time.size), -1)
    return _gather(label, np.zeros(time.size, dtype=np.int64) if kind is None else kind, np.full(time.size, -1), time)


def _gather(label: np.ndarray, kind: np.ndarray, phase: np.ndarray, time: np.ndarray) -> Binning:
    used = np.flatnonzero(label >= 0)
    names, first, bins, count = np.unique(label[used], return_index=True, return_inverse=True, return_counts=True)
    index = np.full(label.size, -1)
    index[used] = bins
    mean_time = np.bincount(bins, time[used], names.size) / np.maximum(count, 1)
    return Binning(index, count, kind[used[first]], phase[used[first]], mean_time)
