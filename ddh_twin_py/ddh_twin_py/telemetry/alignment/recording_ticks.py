"""Cut a whole recording into ticks, as the live aligner cuts its samples."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.clocks.clock import clock_segments, sorted_order
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.ticks import INTERVAL, LONGEST_GAP, REORDER_WINDOW, Samples, Ticks, tick_index, to_ns

MOST_JUMPS = 1000


class AlignmentError(ValueError):
    """A recording whose stamps cannot be put in order; the message names file, topic and number."""


def align(
    recording: Recording,
    interval: float = INTERVAL,
    reorder_window: float = REORDER_WINDOW,
    longest_gap: float = LONGEST_GAP,
) -> Ticks:
    """Cut a recording into ticks; the streams may be in order of arrival or sorted.

    Names of the streams are relative topics. Repeated stamps are dropped (the first arrival
    stays), a backward jump of more than the reorder window begins anew.
    Raises AlignmentError when the clock jumped back more than MOST_JUMPS times.
    """
    interval_ns, window = to_ns(interval), to_ns(reorder_window)
    longest = to_ns(longest_gap) // interval_ns
    stamps = {name: stream.stamps(recording.epoch_ns) for name, stream in recording.streams()}
    segments = clock_segments(stamps, window)
    count = 1 + max((int(s[-1]) for s in segments.values() if s.size), default=-1)
    if count > MOST_JUMPS + 1:
        worst = max(stamps, key=lambda name: np.count_nonzero(np.diff(stamps[name]) < -window))
        raise AlignmentError(
            f"{recording.path}: {recording.namespace}/{worst}: the stamps jump back {count - 1} times, allowed are {MOST_JUMPS}; "
            "do two machines publish on the same topic?"
        )
    samples, starts = {}, {}
    for name, stream in recording.streams():
        order = sorted_order(stamps[name], segments[name])
        samples[name] = Samples(stamps[name][order], stream.values[order])
        starts[name] = np.searchsorted(segments[name][order], np.arange(count + 1))
    ends: list[np.ndarray] = []
    restarts: list[np.ndarray] = []
    first: dict[str, list[np.ndarray]] = {name: [] for name in samples}
    last: dict[str, list[np.ndarray]] = {name: [] for name in samples}
    for segment in range(count):
        parts = {name: s.stamp[starts[name][segment] : starts[name][segment + 1]] for name, s in samples.items()}
        index, restart = _tick_indices(list(parts.values()), interval_ns, longest)
        if not index.size:
            continue
        restart[0] = bool(ends)
        ends.append(index * interval_ns)
        restarts.append(restart)
        for name, stamp in parts.items():
            offset = starts[name][segment]
            first[name].append(offset + np.searchsorted(stamp, ends[-1] - interval_ns, side="right"))
            last[name].append(offset + np.searchsorted(stamp, ends[-1], side="right"))
    return Ticks(
        interval_ns,
        _joined(ends, np.int64),
        _joined(restarts, bool),
        samples,
        {name: _joined(parts, np.int64) for name, parts in first.items()},
        {name: _joined(parts, np.int64) for name, parts in last.items()},
    )


def _joined(arrays: list[np.ndarray], dtype) -> np.ndarray:
    return np.concatenate([np.empty(0, dtype), *arrays]).astype(dtype, copy=False)


def _tick_indices(stamps: list[np.ndarray], interval_ns: int, longest: int) -> tuple[np.ndarray, np.ndarray]:
    """Indices of all ticks of one segment, and where one does not follow the one before."""
    filled = [_distinct(tick_index(s, interval_ns)) for s in stamps if s.size]
    if not filled:
        return np.empty(0, np.int64), np.empty(0, bool)
    filled = _distinct(np.sort(np.concatenate(filled)))
    runs = np.split(filled, np.flatnonzero(np.diff(filled) > longest + 1) + 1)
    index = np.concatenate([np.arange(run[0], run[-1] + 1) for run in runs])
    restart = np.zeros(index.size, bool)
    restart[1:] = np.diff(index) != 1
    return index, restart


def _distinct(ascending: np.ndarray) -> np.ndarray:
    return ascending[np.concatenate(([True], ascending[1:] != ascending[:-1]))]
