"""Cut streams that are not synchronous into common ticks, live or whole.

A tick k covers t_{k-1} < t <= t_k with t_k = k * interval in absolute stamp time, in integer
nanoseconds. Live and array version give the same cuts; samples of one stream may arrive up to
the reorder window late.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections import Counter, deque
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.telemetry.clock import clock_segments, sorted_order
from ddh_twin_py.telemetry.recording import Recording

INTERVAL = 0.05  # s
REORDER_WINDOW = 0.5  # s
TIMEOUT = 1.0  # s
LONGEST_LAG = 10.0
"""s by which an awaited stream that goes on may lag and is waited for: ticks come so late, and what comes meanwhile is kept in memory."""
LONGEST_GAP = 600.0  # s
MOST_JUMPS = 1000
_LONGEST_LAG = round(LONGEST_LAG * 1e9)  # ns
_MOST_DOUBTED = 20_000  # samples of another clock that are put aside
_AHEAD = 20_000_000_000  # ns beyond all from which a stamp is doubted
_OUTVOTED = 3_000_000_000  # ns of them after which they are left out where more streams go on
_LATEST = 5_000_000_000  # ns by which messages may be late without being taken for those of a clock that jumped
_FEWEST = 5  # samples in a row that show a clock that jumped back by less


class AlignmentError(ValueError):
    """A recording whose stamps cannot be put in order; the message names file, topic and number."""


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


class _Doubt:
    """What a stream told by another clock, until it is believed: `rows` by stamp in the order in which they came, never none.

    `first` is the stamp of the first, `top` the newest of them, `since` the number of the push of the first, and `left` the newest stamp
    of all streams before it.
    """

    __slots__ = ("first", "left", "rows", "since", "top")

    def __init__(self, stamp: int, row: Sequence[float], since: int, left: int) -> None:
        self.rows = {stamp: row}
        self.first = self.top = stamp
        self.since, self.left = since, left

    def __len__(self) -> int:
        return len(self.rows)

    def add(self, stamp: int, row: Sequence[float]) -> None:
        self.rows[stamp] = row
        self.top = max(self.top, stamp)

    def near(self, other: _Doubt, apart: int) -> bool:
        """Whether another stream's samples may be of the same clock."""
        return self.first <= other.top + apart and other.first <= self.top + apart


class _Line:
    """One stream within the live aligner: what is waiting, sorted by stamp.

    `owed` counts the clock jumps that others have shown and this stream has not; below 0 it went
    back by itself. `since` is its first stamp since it owes one, `top` its newest before it went back,
    `held` what came since then. `doubt` is what came by another clock, None where nothing did. `rose` is the number of the push that
    brought the newest stamp, and `heard` what the newest stamp of all was then; `lag` is the longest, ns, by which a stamp that was its
    newest lay behind that of all, up to `LONGEST_LAG`. `first` is the first stamp since the ticks began and `told` counts the samples
    since then.
    """

    __slots__ = ("alive", "awaited", "doubt", "first", "follows", "heard", "held", "lag", "newest", "owed", "rose", "rows", "since",
                 "stamps", "told", "top", "width")

    def __init__(self, width: int, awaited: bool, follows: bool) -> None:
        self.width = width
        self.awaited = awaited
        self.follows = follows
        self.stamps: list[int] = []
        self.rows: dict[int, Sequence[float]] = {}
        self.rose = self.lag = 0
        self.restart()

    def restart(self, owed: int = 0, newest: int | None = None) -> None:
        self.newest, self.owed = newest, owed
        self.first: int | None = None
        self.heard: int | None = None
        self.told = 0
        self.alive = self.awaited
        self.since: int | None = None
        self.top: int | None = None
        self.held: list[tuple[int, Sequence[float]]] = []
        self.doubt: _Doubt | None = None

    def step_back(self, stamp: int) -> None:
        """A stream that follows others went back to this stamp; what waits beyond it will come again."""
        top = self.newest
        self.restart(self.owed - 1)
        self.top = top
        self.forget(stamp)

    def forget(self, stamp: int) -> None:
        """Leave out what waits from this stamp on."""
        keep = bisect_right(self.stamps, stamp - 1)
        for again in self.stamps[keep:]:
            del self.rows[again]
        del self.stamps[keep:]

    @property
    def stale(self) -> bool:
        """Whether its samples are still those from before a jump of the clock."""
        return self.owed > 0

    @property
    def went_back(self) -> bool:
        """Whether what came by another clock is of an earlier time."""
        return self.doubt is not None and self.newest is not None and self.doubt.first < self.newest

    def goes_on_doubted(self, stamp: int) -> bool:
        """Whether a stamp follows what came by an earlier clock rather than what came before it."""
        return self.went_back and stamp <= self.newest and stamp - self.doubt.top < self.newest - stamp

    @property
    def step(self) -> int:
        """Usual time between its samples, ns; that of the slowest streams that are waited for where it told one."""
        return (self.newest - self.first) // (self.told - 1) if self.told > 1 and self.first is not None else _LONGEST_LAG


class TickAligner:
    """Cut live streams into ticks.

    A tick is released once the newest stamp of every awaited stream lies more than
    `reorder_window` beyond its end, so that nothing of it can still come. A stream that has
    stopped (or never began) holds a tick up by `timeout` once and is not waited for until it
    is back. One that goes on, though behind the others or with seconds at once, is waited for as long as it lags by no more than
    `LONGEST_LAG` and `timeout` together; once it lagged by more, no sooner than it lags by less than `LONGEST_LAG`.
    Streams not named in `awaited` never hold a tick up.
    Where no sample comes for longer than `longest_gap` that time is skipped, all of it and at once.

    A stream of which the stamps lie more than the reorder window behind its newest, or more than 20 s ahead of all, is doubted: what it
    tells is put aside until it has gone on so for longer than that window or half of the step, and then is put to the vote of all streams.
    For it are those that tell the same clock, itself among them; against it those that have meanwhile told, by the clock of before, more
    than a reorder window beyond all that had come. It is believed once more are for it than against it and silent together, a stream being
    silent for as long as it had no time to speak: twice its usual step, its lag and the reorder window, 10 s at most. After a jump back all
    that waits is released, without the time in which there was nothing for longer than messages can be under way, and the ticks begin anew;
    after one ahead of more than `longest_gap` that time is skipped. A stream that is outvoted is left out, and doubted anew
    with what it tells next, until its stamps go on as before or others tell its clock, too. A stamp after which its stream goes on as
    before is of another clock, as of a second machine on the topic, and left out. A step back of 5 s or less may be messages that are
    late: there it must be told by several samples as close as the stream's are, while no stream goes on.

    Samples of the streams that have not jumped yet are left out until they have gone back too, fit the new time, or have gone on for longer
    than messages can be under way, unless that is far ahead. `followers` are computed from the other streams and lag behind them:
    by up to `timeout` they tell the old time after a jump, so that they only restart themselves
    when they go back; they decide for all only where none of the others speaks, or says otherwise
    for `timeout` of data. What they said in the meantime is not lost. Samples must be pushed in the order in
    which they came, whatever their stream: streams pushed one after the other would each tell every jump anew.

    Samples of the streams `keep_late` whose tick was released already are put into `late` (stream,
    stamp in ns, row) for a listener that can use them; it empties the list.

    `streams` maps name to number of fields. `counts` has, by (stream, cause): duplicate, late
    (its tick was released already) and clock_jump; `old_clock` samples still had the time from
    before another stream's jump, `other_clock` samples that of no other sample beside them. `strayed`
    is, for late and other_clock, how far the first such sample lay from where all were, in ns.
    """

    def __init__(
        self,
        streams: Mapping[str, int],
        interval: float = INTERVAL,
        reorder_window: float = REORDER_WINDOW,
        timeout: float = TIMEOUT,
        awaited: Sequence[str] | None = None,
        longest_gap: float = LONGEST_GAP,
        followers: Collection[str] = (),
        keep_late: Collection[str] = (),
    ) -> None:
        self.interval_ns = to_ns(interval)
        self._window = to_ns(reorder_window)
        self._timeout = to_ns(timeout)
        self._longest_gap = to_ns(longest_gap) // self.interval_ns
        waited = set(streams if awaited is None else awaited)
        unknown = sorted(waited - set(streams))
        if unknown:
            raise ValueError(f"awaited stream {unknown[0]!r} is none of {', '.join(streams)}")
        self._lines = {name: _Line(width, name in waited, name in followers) for name, width in streams.items()}
        self.counts: Counter[tuple[str, str]] = Counter()
        self.late: list[tuple[str, int, Sequence[float]]] = []
        self.strayed: dict[tuple[str, str], int] = {}
        self._pushed = 0
        self._keep_late = frozenset(keep_late)
        self._done: deque[Tick] = deque()
        self._newest: int | None = None  # over all streams
        self._last: int | None = None  # index of the tick released last, None where the next begins anew
        self._last_end: int | None = None  # its end, ns, which no jump forgets
        self._empty = 0  # empty ticks released since the last one with samples
        self._restart = False

    def push(self, stream: str, stamp_ns: int, row: Sequence[float]) -> None:
        """Take in one sample; `row` has the stream's fields. The row is kept, not copied."""
        line = self._lines[stream]
        stamp = int(stamp_ns)
        self._pushed += 1
        line.told += 1
        if line.goes_on_doubted(stamp) or self._leaps(line, stamp):
            if not self._went_back(line, stamp):
                self._doubt(stream, line, stamp, row)
                return
        elif line.doubt is not None:
            if line.went_back and stamp - line.doubt.top <= self._window and self._verdict(line, last=True):
                self._believe(stream, line)  # it went all the way to where it was
            else:
                self._leave_out(stream, line)
        self._accept(stream, line, stamp, row)

    def _accept(self, stream: str, line: _Line, stamp: int, row: Sequence[float]) -> None:
        """Take in a sample whose clock is believed."""
        if line.stale and not self._joins(line, stamp):
            self.counts[stream, "old_clock"] += 1
            return
        if line.owed < 0:
            line.held.append((stamp, row))
            if stamp > line.held[0][0] + self._window + self._timeout:
                self._jump(stream)  # none of the streams that lead has said anything else
                return
        if stamp == line.newest or stamp in line.rows:
            self.counts[stream, "duplicate"] += 1
            return
        if line.newest is None or stamp > line.newest:
            line.newest, line.rose = stamp, self._pushed
            line.first = stamp if line.first is None else line.first
            if self._newest is None or stamp > self._newest - _LONGEST_LAG:
                line.alive = line.awaited
                line.lag = line.lag if self._newest is None else max(line.lag, self._newest - stamp)
            if line.top is not None and stamp > line.top:
                line.owed, line.top, line.held = 0, None, []  # it went back alone and is where it was
        if self._newest is None or stamp > self._newest:
            self._newest = stamp
        if line.rose == self._pushed:
            line.heard = self._newest
        if self._last is not None and stamp <= self._last * self.interval_ns:
            if stream in self._keep_late:
                self.late.append((stream, stamp, row))
            else:
                self.counts[stream, "late"] += 1
                self.strayed.setdefault((stream, "late"), stamp - self._newest)
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
                if any(self._may_come(line, edge) for line in waiting):
                    return
                for line in waiting:
                    line.alive = False
            elif self._newest <= edge:
                return
            yield self._release(following)

    def flush(self) -> Iterator[Tick]:
        """All ticks up to the newest sample, at the end of the data."""
        for name, line in self._lines.items():
            if line.doubt is not None and len(line.doubt) > 1 and self._verdict(line):  # one is no clock
                self._believe(name, line)
        yield from self._finished()
        yield from self._drain(self._longest_gap)

    def _finished(self) -> Iterator[Tick]:
        while self._done:
            yield self._done.popleft()

    @staticmethod
    def _beyond(line: _Line, edge: int) -> bool:
        return line.newest is not None and not line.stale and line.newest > edge

    def _may_come(self, line: _Line, edge: int) -> bool:
        """Whether a stream that has not told what lies before an edge is still waited for: it goes on, or stopped a short time ago, or
        lags no more than it did, as one of which seconds come at once."""
        last = edge if line.heard is None else min(max(edge + line.lag, line.heard), edge + _LONGEST_LAG)
        return self._newest <= last + self._timeout

    def _drain(self, longest_gap: int) -> Iterator[Tick]:
        while any(line.stamps for line in self._lines.values()):
            yield self._release(self._following(longest_gap))

    def _following(self, longest_gap: int | None = None) -> int | None:
        """Index of the next tick to be released, None while that cannot be known; more empty ticks than ``longest_gap`` are skipped."""
        longest_gap = self._longest_gap if longest_gap is None else longest_gap
        if self._last is None:
            self._leave_out_strays()
        oldest = min((line.stamps[0] for line in self._lines.values() if line.stamps), default=None)
        filled = None if oldest is None else tick_index(oldest, self.interval_ns)
        if self._last is None:
            return filled
        if filled is None:
            return self._last + 1 if self._empty < longest_gap else None
        return self._last + 1 if self._empty + filled - self._last - 1 <= longest_gap else filled

    def _leave_out_strays(self) -> None:
        """At the beginning: leave out what fewer streams tell than tell a time after a long silence; it is of another clock."""
        while waiting := {name: line for name, line in self._lines.items() if line.stamps}:
            end = min(line.stamps[0] for line in waiting.values()) + self._longest_gap * self.interval_ns
            early = [name for name, line in waiting.items() if line.stamps[0] <= end]
            if len(early) >= sum(line.stamps[-1] > end for line in waiting.values()):
                return
            for name in early:
                line = waiting[name]
                strays = line.stamps[: bisect_right(line.stamps, end)]
                del line.stamps[: len(strays)]
                for stamp in strays:
                    del line.rows[stamp]
                self.counts[name, "other_clock"] += len(strays)
                self.strayed.setdefault((name, "other_clock"), strays[0] - self._newest)

    def _release(self, index: int) -> Tick:
        end = index * self.interval_ns
        restart = self._restart or (self._last is not None and index != self._last + 1)
        samples = {name: self._take(line, end) for name, line in self._lines.items()}
        self._empty = self._empty + 1 if not any(map(len, samples.values())) else 0
        gap = 0.0 if self._last_end is None else (end - self.interval_ns - self._last_end) * 1e-9
        self._last, self._last_end = index, end
        self._restart = False
        return Tick(end - self.interval_ns, end, restart, samples, gap)

    def _take(self, line: _Line, end: int) -> Samples:
        count = bisect_right(line.stamps, end)
        if not count:
            return Samples(np.empty(0, np.int64), np.empty((0, line.width)))
        stamps = line.stamps[:count]
        del line.stamps[:count]
        values = np.array([line.rows.pop(stamp) for stamp in stamps], float).reshape(count, line.width)
        return Samples(np.array(stamps, np.int64), values)

    def _leaps(self, line: _Line, stamp: int) -> bool:
        """Whether a stamp lies behind its stream, or far ahead of all."""
        if line.newest is not None and stamp < line.newest - self._window:
            return True
        newest = max(line.newest or 0, self._newest or 0)
        return newest > 0 and not line.stale and stamp > newest + _AHEAD

    def _went_back(self, line: _Line, stamp: int) -> bool:
        """Whether a stamp behind its stream is of a jump that is known, so that the stream takes part in it."""
        if line.newest is None or stamp > line.newest:
            return False
        if line.follows and (line.stale or self._led(line)):
            line.step_back(stamp)
        elif line.stale and (self._newest is None or stamp >= self._newest - self._window - self._timeout):
            line.restart()
        else:
            return False
        return True

    def _doubt(self, stream: str, line: _Line, stamp: int, row: Sequence[float]) -> None:
        """Put a sample of another clock aside, until its stream has gone on by that clock and is not outvoted."""
        newest, doubt = self._newest_of(line), line.doubt
        if doubt is not None and (stamp < doubt.first - self._window or (stamp > newest) != (doubt.first > newest)):
            self._leave_out(stream, line)
        if line.doubt is None:
            line.doubt = _Doubt(stamp, row, self._pushed, self._newest)
        elif stamp in line.doubt.rows:
            self.counts[stream, "duplicate"] += 1
            return
        line.doubt.add(stamp, row)
        span = stamp - line.doubt.first
        verdict = self._verdict(line) if span > min(self._window, abs(newest - line.doubt.first) // 2) else None
        if verdict or self._follower_at(stamp):
            self._believe(stream, line)
        elif len(line.doubt) > _MOST_DOUBTED or span > (_OUTVOTED if verdict is False else _LONGEST_LAG):
            self._leave_out(stream, line)

    def _may_be_late(self, line: _Line) -> bool:
        """Whether what came by an earlier clock may be late instead: by seconds at most, and not as much of it as goes on by a clock.

        Of a clock that jumped come `_FEWEST` samples or more, half as close as the stream's at least, and no stream goes on meanwhile;
        where it is awaited, no other that is: the next sample of a slow one is newer than its last by the new clock, too.
        """
        doubt = line.doubt
        if not line.went_back or line.newest - doubt.first > _LATEST:
            return False
        count, span, before = len(doubt), doubt.top - doubt.first, line.newest - (line.first or line.newest)
        goes_on = any(other.rose > doubt.since and not other.stale and not other.follows and (other.awaited or not line.awaited)
                      for other in self._lines.values())
        return goes_on or count < _FEWEST or 2 * count * before < line.told * span

    def _verdict(self, line: _Line, last: bool = False) -> bool | None:
        """Whether more streams tell the clock of what one told last, itself among them, than go on as before; None while that is open.

        It is while messages may be late, and unless this is the last that it tells while there are streams that had no time to tell: twice
        their usual step, the reorder window and their lag.
        """
        if self._may_be_late(line):
            return None
        doubt, near = line.doubt, self._window + self._timeout
        agree = against = silent = 0
        for other in self._lines.values():
            if other.doubt is not None:
                agree += other.doubt.near(doubt, near)
            elif self._goes_on(other, doubt):
                against += 1
            elif other.newest is not None and not other.stale and other.newest > doubt.left - _LONGEST_LAG:
                silent += doubt.top - doubt.first <= min(2 * other.step + self._window + other.lag, _LONGEST_LAG)
        silent = 0 if last else silent
        return True if agree > against + silent else None if silent else False

    def _goes_on(self, line: _Line, doubt: _Doubt) -> bool:
        """Whether a stream has told, by the clock of all, what lies beyond all that came before another one was doubted."""
        return line.doubt is None and not line.stale and line.rose > doubt.since and line.newest > doubt.left + self._window

    def _follower_at(self, stamp: int) -> bool:
        """Whether a stream that follows others went back by itself and is near a stamp."""
        near = self._window + self._timeout
        return any(line.owed < 0 and line.held and abs(line.held[-1][0] - stamp) <= near for line in self._lines.values())

    def _believe(self, stream: str, line: _Line) -> None:
        """Go by the clock of what was put aside; what other streams told by a clock that went ahead is of it, too."""
        if line.went_back:
            self._jump(stream)
            return
        self._take_in(stream, line)
        for name, other in self._lines.items():
            if other.doubt is not None and not self._leaps(other, other.doubt.first):
                self._take_in(name, other)

    def _take_in(self, stream: str, line: _Line) -> None:
        """Take in what was put aside."""
        doubt, line.doubt = line.doubt, None
        for stamp, row in doubt.rows.items():
            self._accept(stream, line, stamp, row)

    def _leave_out(self, stream: str, line: _Line) -> None:
        """Forget what was put aside; the stream goes on as before."""
        behind = self._newest_of(line) - line.doubt.first
        cause = "late" if 0 < behind <= _LATEST else "other_clock"
        self.counts[stream, cause] += len(line.doubt)
        self.strayed.setdefault((stream, cause), -behind)
        line.doubt = None

    def _newest_of(self, line: _Line) -> int:
        """Newest stamp of a stream, of all while it has none."""
        return self._newest if line.newest is None else line.newest

    def _led(self, follower: _Line) -> bool:
        """Whether a stream that this one could be computed from speaks."""
        oldest = follower.newest - self._window - self._timeout
        leaders = (line for line in self._lines.values() if not line.follows and not line.stale)
        return any(line.newest is not None and line.newest >= oldest for line in leaders)

    def _joins(self, line: _Line, stamp: int) -> bool:
        """Whether a stale stream is of the new clock with this stamp; it is stale no more then."""
        line.newest = stamp if line.newest is None else max(line.newest, stamp)
        if line.follows and any(self._far_ahead(leader, stamp) for leader in self._lines.values() if not leader.follows):
            return False  # it tells what the others told before the jump, their way there included
        if line.since is None:
            line.since = stamp
        fits = not line.follows and (self._newest is None or stamp <= self._newest + self._window)
        longest = self._window + line.lag + (self._timeout if line.follows else 0)
        if fits or stamp > line.since + longest:
            line.restart()
            return not self._leaps(line, stamp)  # else it is another clock's
        return False

    def _far_ahead(self, line: _Line, stamp: int) -> bool:
        """Whether a stamp lies so far ahead of a stream that speaks that the time between would be skipped."""
        return line.newest is not None and not line.stale and stamp > line.newest + self._longest_gap * self.interval_ns

    def _jump(self, stream: str) -> None:
        """The clock jumped back: everything that waits belongs to the old time."""
        self.counts[stream, "clock_jump"] += 1
        followed = {name: line.held for name, line in self._lines.items() if line.owed < 0 and line.held}
        for name, held in followed.items():
            self._lines[name].forget(held[0][0])
        before = followed | {name: list(line.doubt.rows.items()) for name, line in self._lines.items() if line.went_back}
        self._done += self._drain(min(self._longest_gap, (self._window + self._timeout) // self.interval_ns))
        self._restart = self._restart or self._last is not None
        self.late.clear()
        self._newest = self._last = None
        self._empty = 0
        for name, line in self._lines.items():
            ahead = name in before or name == stream or line.newest is None or line.owed < 0
            owed = 0 if ahead else line.owed + 1 if line.follows else 1
            line.restart(owed, line.newest if owed else None)
        for name, held in before.items():  # these had gone back before this stream
            for stamp, row in held:
                self.push(name, stamp, row)


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
