"""Cut what waits in live streams into ticks: which is the next, whether anything of it can still come, and what is skipped."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ddh_twin_py.telemetry.clocks.stream_line import LONGEST_LAG_NS, Line
from ddh_twin_py.telemetry.ticks import Samples, Tick, tick_index


class TickCutter:
    """Ticks of the streams `lines`, by name; all times are ns.

    A tick is released once the newest stamp of every awaited stream lies more than `window` beyond its end, so that nothing of it can
    still come. A stream that has stopped (or never began) holds a tick up by `timeout` once and is not waited for until it is back. One
    that goes on, though behind the others or with seconds at once, is waited for as long as it lags by no more than `LONGEST_LAG` and
    `timeout` together; once it lagged by more, no sooner than it lags by less than `LONGEST_LAG`. Where no sample comes for longer than
    `longest_gap` ticks that time is skipped, all of it and at once.
    """

    def __init__(self, lines: Mapping[str, Line], interval: int, window: int, timeout: int, longest_gap: int) -> None:
        self._lines = lines
        self._interval, self._window, self._timeout, self._longest_gap = interval, window, timeout, longest_gap
        self._last: int | None = None  # index of the tick released last, None where the next begins anew
        self._last_end: int | None = None  # its end, ns, which no jump forgets
        self._empty = 0  # empty ticks released since the last one with samples
        self._restart = False

    @property
    def begins(self) -> bool:
        """Whether the next tick is the first, of all or after a jump back."""
        return self._last is None

    def begin_anew(self) -> None:
        """The clock jumped back: the next tick does not follow the one before."""
        self._restart = self._restart or self._last is not None
        self._last, self._empty = None, 0

    def is_released(self, stamp: int) -> bool:
        """Whether the tick of a stamp was released already."""
        return self._last is not None and stamp <= self._last * self._interval

    def next(self, newest: int) -> Tick | None:
        """The next tick, None while something of it can still come; `newest` is the newest stamp of all."""
        following = self._following(self._longest_gap)
        if following is None:
            return None
        edge = following * self._interval + self._window
        waiting = [line for line in self._lines.values() if line.alive and not _beyond(line, edge)]
        if any(self._may_come(line, edge, newest) for line in waiting):
            return None
        for line in waiting:
            line.alive = False
        return self._release(following) if waiting or newest > edge else None

    def drain(self, longest_gap: int | None = None) -> Iterator[Tick]:
        """All ticks up to the newest that waits, without times of more empty ticks than ``longest_gap``."""
        while any(line.stamps for line in self._lines.values()):
            yield self._release(self._following(self._longest_gap if longest_gap is None else longest_gap))

    def _may_come(self, line: Line, edge: int, newest: int) -> bool:
        """Whether a stream that has not told what lies before an edge is still waited for: it goes on, or stopped a short time ago, or
        lags no more than it did, as one of which seconds come at once."""
        last = edge if line.heard is None else min(max(edge + line.lag, line.heard), edge + LONGEST_LAG_NS)
        return newest <= last + self._timeout

    def _following(self, longest_gap: int) -> int | None:
        """Index of the next tick to be released, None while that cannot be known; more empty ticks than ``longest_gap`` are skipped."""
        oldest = min((line.stamps[0] for line in self._lines.values() if line.stamps), default=None)
        filled = None if oldest is None else tick_index(oldest, self._interval)
        if self._last is None:
            return filled
        if filled is None:
            return self._last + 1 if self._empty < longest_gap else None
        return self._last + 1 if self._empty + filled - self._last - 1 <= longest_gap else filled

    def _release(self, index: int) -> Tick:
        end = index * self._interval
        restart = self._restart or (self._last is not None and index != self._last + 1)
        samples = {name: _samples(line, end) for name, line in self._lines.items()}
        self._empty = self._empty + 1 if not any(map(len, samples.values())) else 0
        gap = 0.0 if self._last_end is None else (end - self._interval - self._last_end) * 1e-9
        self._last, self._last_end = index, end
        self._restart = False
        return Tick(end - self._interval, end, restart, samples, gap)


def _beyond(line: Line, edge: int) -> bool:
    return line.newest is not None and not line.stale and line.newest > edge


def _samples(line: Line, end: int) -> Samples:
    """What waits in a stream up to the end of a tick; it waits no more."""
    if not line.stamps or line.stamps[0] > end:
        return Samples(np.empty(0, np.int64), np.empty((0, line.width)))
    stamps, rows = line.take(end)
    return Samples(np.array(stamps, np.int64), np.array(rows, float).reshape(len(rows), line.width))
