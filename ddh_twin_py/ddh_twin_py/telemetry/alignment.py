"""Cut streams that are not synchronous into common ticks, live or whole.

A tick k covers t_{k-1} < t <= t_k with t_k = k * interval in absolute stamp time, in integer
nanoseconds. Live and array version give the same cuts; samples of one stream may arrive up to
the reorder window late.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.telemetry.clock import clock_segments, sorted_order
from ddh_twin_py.telemetry.recording import Recording

INTERVAL = 0.05  # s
REORDER_WINDOW = 0.5  # s
TIMEOUT = 1.0  # s
LONGEST_GAP = 600.0  # s
MOST_JUMPS = 1000


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
    """

    start_ns: int
    end_ns: int
    restart: bool
    samples: dict[str, Samples]


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
        return Tick(end - self.interval_ns, end, bool(self.restart[i]), samples)

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


class _Line:
    """One stream within the live aligner: what is waiting, sorted by stamp."""

    __slots__ = ("alive", "awaited", "newest", "rows", "stale", "stamps", "width")

    def __init__(self, width: int, awaited: bool) -> None:
        self.width = width
        self.awaited = awaited
        self.stamps: list[int] = []
        self.rows: dict[int, Sequence[float]] = {}
        self.restart()

    def restart(self, stale: bool = False) -> None:
        self.newest: int | None = None
        self.alive = self.awaited
        self.stale = stale  # the clock jumped back on another stream, here not yet seen


class TickAligner:
    """Cut live streams into ticks.

    A tick is released once the newest stamp of every awaited stream lies more than
    `reorder_window` beyond its end, so that nothing of it can still come. A stream that has
    stopped (or never began) holds a tick up by `timeout` once and is not waited for until it
    is back. Streams not named in `awaited` never hold a tick up.
    After `longest_gap` without any sample the time up to the next one is skipped.

    `streams` maps name to number of fields. `counts` has, by (stream, cause): duplicate, late
    (its tick was released already) and clock_jump; `old_clock` samples still had the time from
    before another stream's jump.
    """

    def __init__(
        self,
        streams: Mapping[str, int],
        interval: float = INTERVAL,
        reorder_window: float = REORDER_WINDOW,
        timeout: float = TIMEOUT,
        awaited: Sequence[str] | None = None,
        longest_gap: float = LONGEST_GAP,
    ) -> None:
        self.interval_ns = to_ns(interval)
        self._window = to_ns(reorder_window)
        self._timeout = to_ns(timeout)
        self._longest_gap = to_ns(longest_gap) // self.interval_ns
        waited = set(streams if awaited is None else awaited)
        unknown = sorted(waited - set(streams))
        if unknown:
            raise ValueError(f"awaited stream {unknown[0]!r} is none of {', '.join(streams)}")
        self._lines = {name: _Line(width, name in waited) for name, width in streams.items()}
        self.counts: Counter[tuple[str, str]] = Counter()
        self._done: list[Tick] = []
        self._newest: int | None = None  # over all streams
        self._last: int | None = None  # index of the tick released last
        self._empty = 0  # empty ticks released since the last one with samples
        self._restart = False

    def push(self, stream: str, stamp_ns: int, row: Sequence[float]) -> None:
        """Take in one sample; `row` has the stream's fields. The row is kept, not copied."""
        line = self._lines[stream]
        stamp = int(stamp_ns)
        if line.newest is not None and stamp < line.newest - self._window:
            # a stale line joins the new clock, unless that has long gone on and it jumps back by itself
            joins = self._newest is None or stamp >= self._newest - self._window - self._timeout
            if line.stale and joins:
                line.restart()
            else:
                self._jump(stream)
        elif line.stale:
            if self._newest is not None and stamp > self._newest + self._window:
                line.newest = stamp if line.newest is None else max(line.newest, stamp)
                self.counts[stream, "old_clock"] += 1
                return
            line.restart()
        if stamp == line.newest or stamp in line.rows:
            self.counts[stream, "duplicate"] += 1
            return
        if line.newest is None or stamp > line.newest:
            line.newest = stamp
            line.alive = line.awaited
        if self._newest is None or stamp > self._newest:
            self._newest = stamp
        if self._last is not None and stamp <= self._last * self.interval_ns:
            self.counts[stream, "late"] += 1
            return
        line.rows[stamp] = row
        if line.stamps and stamp < line.stamps[-1]:
            insort(line.stamps, stamp)
        else:
            line.stamps.append(stamp)

    def ready(self) -> Iterator[Tick]:
        """Ticks that are complete, in order; empty ones between them included."""
        yield from self._finished()
        while self._newest is not None:
            following = self._following()
            if following is None:
                return
            edge = following * self.interval_ns + self._window
            waiting = [line for line in self._lines.values() if line.alive and not self._beyond(line, edge)]
            if waiting:
                if self._newest <= edge + self._timeout:
                    return
                for line in waiting:
                    line.alive = False
            elif self._newest <= edge:
                return
            yield self._release(following)

    def flush(self) -> Iterator[Tick]:
        """All ticks up to the newest sample, at the end of the data."""
        yield from self._finished()
        yield from self._drain()

    def _finished(self) -> Iterator[Tick]:
        while self._done:
            yield self._done.pop(0)

    @staticmethod
    def _beyond(line: _Line, edge: int) -> bool:
        return line.newest is not None and not line.stale and line.newest > edge

    def _drain(self) -> Iterator[Tick]:
        while any(line.stamps for line in self._lines.values()):
            yield self._release(self._following())

    def _following(self) -> int | None:
        """Index of the next tick to be released, None while that cannot be known."""
        if self._last is not None and self._empty < self._longest_gap:
            return self._last + 1
        oldest = min((line.stamps[0] for line in self._lines.values() if line.stamps), default=None)
        return None if oldest is None else tick_index(oldest, self.interval_ns)

    def _release(self, index: int) -> Tick:
        end = index * self.interval_ns
        restart = self._restart or (self._last is not None and index != self._last + 1)
        samples = {name: self._take(line, end) for name, line in self._lines.items()}
        self._empty = self._empty + 1 if not any(map(len, samples.values())) else 0
        self._last = index
        self._restart = False
        return Tick(end - self.interval_ns, end, restart, samples)

    def _take(self, line: _Line, end: int) -> Samples:
        count = bisect_right(line.stamps, end)
        if not count:
            return Samples(np.empty(0, np.int64), np.empty((0, line.width)))
        stamps = line.stamps[:count]
        del line.stamps[:count]
        values = np.array([line.rows.pop(stamp) for stamp in stamps], float).reshape(count, line.width)
        return Samples(np.array(stamps, np.int64), values)

    def _jump(self, stream: str) -> None:
        """The clock jumped back: everything that waits belongs to the old time."""
        self.counts[stream, "clock_jump"] += 1
        self._done += self._drain()
        self._restart = self._restart or self._last is not None
        self._newest = self._last = None
        self._empty = 0
        for name, line in self._lines.items():
            newest = line.newest
            line.restart(stale=name != stream and newest is not None)
            if line.stale:
                line.newest = newest


def align(
    recording: Recording,
    interval: float = INTERVAL,
    reorder_window: float = REORDER_WINDOW,
    longest_gap: float = LONGEST_GAP,
) -> Ticks:
    """Cut a recording into ticks; the streams may be in order of arrival or sorted.

    Names of the streams are relative topics. Repeated stamps are dropped (the first arrival
    stays), a backward jump of more than the reorder window begins anew.
    Raises ValueError when the clock jumped back more than MOST_JUMPS times.
    """
    interval_ns, window = to_ns(interval), to_ns(reorder_window)
    longest = to_ns(longest_gap) // interval_ns
    stamps = {name: stream.stamps(recording.epoch_ns) for name, stream in recording.streams()}
    segments = clock_segments(stamps, window)
    count = 1 + max((int(s[-1]) for s in segments.values() if s.size), default=-1)
    if count > MOST_JUMPS + 1:
        raise ValueError(
            f"{recording.path}: the stamps jump back {count - 1} times, allowed are {MOST_JUMPS}; "
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
        parts = {n: s.stamp[starts[n][segment] : starts[n][segment + 1]] for n, s in samples.items()}
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
    parts = [np.arange(run[0], run[-1] + 1 + longest) for run in runs]
    parts[-1] = np.arange(runs[-1][0], runs[-1][-1] + 1)
    index = np.concatenate(parts)
    restart = np.zeros(index.size, bool)
    restart[1:] = np.diff(index) != 1
    return index, restart


def _distinct(ascending: np.ndarray) -> np.ndarray:
    return ascending[np.concatenate(([True], ascending[1:] != ascending[:-1]))]
