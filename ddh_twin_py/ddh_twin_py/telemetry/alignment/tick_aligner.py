"""Cut live streams that are not synchronous into common ticks, as `recording_ticks.align` cuts a whole recording.

Samples of one stream may arrive up to the reorder window late.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Collection, Iterator, Mapping, Sequence
from operator import itemgetter

from ddh_twin_py.telemetry.alignment.tick_cutter import TickCutter
from ddh_twin_py.telemetry.clocks.clock_vote import ClockVote, cause, is_lost, take_strays, timely
from ddh_twin_py.telemetry.clocks.stream_line import APART_NS, LONGEST_LAG_NS, Doubt, Line
from ddh_twin_py.telemetry.ticks import INTERVAL, LONGEST_GAP, REORDER_WINDOW, Tick, to_ns

TIMEOUT = 1.0  # s


class TickAligner:
    """Cut live streams into ticks.

    A tick is released once nothing of it can still come, see `TickCutter`; streams not named in `awaited` never hold one up. Samples must
    be pushed in the order in which they came, whatever their stream: streams pushed one after the other would each tell every jump anew.

    **Jumps.** What a stream tells by another clock is put aside until all streams have voted on it, see `clock_vote`. After a jump back the
    ticks begin anew: all that waits is released, without the time in which there was nothing for longer than messages can be under way.
    After a jump ahead by more than `longest_gap` the time between is skipped.

    **Streams that have not jumped yet.** Their samples are left out until one of these holds: they have gone back, too; they fit the new
    time; they have gone on for longer than messages can be under way, unless that is far ahead.

    **Followers.** `followers` are computed from the other streams and lag behind them. After a jump they tell the old time for up to
    `timeout`; so where they go back they restart themselves alone. They decide for all only where none of the others speaks, or says
    otherwise for `timeout` of data. What they said in the meantime is not lost.

    **Late samples.** Those of the streams `keep_late` whose tick was released already are put into `late` (stream, stamp in ns, row) for a
    listener that can use them; it empties the list.

    `streams` maps name to number of fields. `counts` has, by (stream, cause):

    - duplicate;
    - late: its tick was released already;
    - clock_jump;
    - old_clock: it still had the time from before another stream's jump;
    - other_clock: it had that of no other sample beside it.

    `strayed` is, for late and other_clock, how far such samples lay from where all were when the last of them came, in ns.
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
        waited = set(streams if awaited is None else awaited)
        unknown = sorted(waited - set(streams))
        if unknown:
            raise ValueError(f"awaited stream {unknown[0]!r} is none of {', '.join(streams)}")
        self.interval_ns = to_ns(interval)
        self._window, self._timeout = to_ns(reorder_window), to_ns(timeout)
        longest = to_ns(longest_gap) // self.interval_ns
        self._longest_gap = longest * self.interval_ns
        self._lines = {name: Line(width, name in waited, name in followers) for name, width in streams.items()}
        self._vote = ClockVote(self._lines, self._window, self._timeout)
        self._cutter = TickCutter(self._lines, self.interval_ns, self._window, self._timeout, longest)
        self.counts: Counter[tuple[str, str]] = Counter()
        self.late: list[tuple[str, int, Sequence[float]]] = []
        self.strayed: dict[tuple[str, str], int] = {}
        self._pushed = 0
        self._keep_late = frozenset(keep_late)
        self._done: deque[Tick] = deque()
        self._newest: int | None = None  # over all streams

    def push(self, stream: str, stamp_ns: int, row: Sequence[float], came_ns: int | None = None) -> None:
        """Take in one sample; `row` has the stream's fields and is kept, not copied. `came_ns`: when it came by the computer's clock."""
        line = self._lines[stream]
        stamp = int(stamp_ns)
        self._pushed += 1
        line.told += 1
        if line.goes_on_doubted(stamp) or self._vote.leaps(line, stamp, self._newest):
            if not self._takes_part(line, stamp):
                self._doubt(stream, line, stamp, row, came_ns)
                return
        elif line.doubt is not None:
            if line.went_back and stamp - line.doubt.top <= self._window and self._vote.verdict(line, last=True):
                self._believe(stream, line)  # it went all the way to where it was
            elif self._vote.catches_up(line, stamp):
                self._believe(stream, line)
            else:
                self._leave_out(stream, line)
                if line.parted and self._vote.leaps(line, stamp, self._newest):  # and goes on behind all
                    self._doubt(stream, line, stamp, row, came_ns)
                    return
        if timely(stamp, came_ns):
            line.came = stamp
        self._accept(stream, line, stamp, row)

    def ready(self) -> Iterator[Tick]:
        """Ticks that are complete, in order; empty ones between them included."""
        yield from self._finished()
        while self._newest is not None:
            self._leave_out_strays()
            tick = self._cutter.next(self._newest)
            if tick is None:
                return
            yield tick

    def flush(self) -> Iterator[Tick]:
        """All ticks up to the newest sample, at the end of the data."""
        for name, line in self._lines.items():
            if line.doubt is not None and self._vote.at_the_end(line, self._newest):
                self._believe(name, line)
        yield from self._finished()
        self._leave_out_strays()
        yield from self._cutter.drain()

    def _finished(self) -> Iterator[Tick]:
        while self._done:
            yield self._done.popleft()

    def _accept(self, stream: str, line: Line, stamp: int, row: Sequence[float]) -> None:
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
            line.rise(stamp, self._newest, self._pushed)
            if line.behind is not None and self._vote.outvotes(line, stamp, self._newest):
                line.held.append((stamp, row))
                self._jump(stream)
                return
        before, self._newest = self._newest, stamp if self._newest is None else max(self._newest, stamp)
        if before is not None and stamp > before + APART_NS:
            self._take_in(self._within(stamp))
        if not self._cutter.is_released(stamp):
            line.wait(stamp, row)
        elif stream in self._keep_late:
            self.late.append((stream, stamp, row))
        else:
            self.counts[stream, "late"] += 1
            self.strayed[stream, "late"] = stamp - self._newest

    def _takes_part(self, line: Line, stamp: int) -> bool:
        """Whether a stamp behind its stream is of a jump that is known, so that the stream takes part in it."""
        if line.newest is None or stamp > line.newest:
            return False
        if line.follows and (line.stale or self._vote.led(line)):
            line.step_back(stamp)
        elif line.stale and (self._newest is None or -self._vote.near <= stamp - self._newest <= LONGEST_LAG_NS):
            line.restart()
        else:
            return False
        return True

    def _joins(self, line: Line, stamp: int) -> bool:
        """Whether a stale stream is of the new clock with this stamp; it is stale no more then."""
        line.newest = stamp if line.newest is None else max(line.newest, stamp)
        if line.follows and self._vote.leads_behind(stamp, self._longest_gap):
            return False  # it tells what the others told before the jump, their way there included
        if line.since is None:
            line.since = stamp
        fits = not line.follows and (self._newest is None or stamp <= self._newest + self._window)
        longest = self._window + line.lag + (self._timeout if line.follows else 0)
        if fits or stamp > line.since + longest:
            line.restart()
            return not self._vote.leaps(line, stamp, self._newest)  # else it is another clock's
        return False

    def _doubt(self, stream: str, line: Line, stamp: int, row: Sequence[float], came: int | None) -> None:
        """Put a sample of another clock aside, until its stream has gone on by that clock and is not outvoted."""
        newest, doubt = self._newest_of(line), line.doubt
        if doubt is not None and (stamp < doubt.first - self._window or (stamp > newest) != (doubt.first > newest)):
            self._leave_out(stream, line)
        if line.doubt is None:
            line.doubt = Doubt(stamp, row, self._pushed, self._newest)
        elif stamp in line.doubt.rows:
            self.counts[stream, "duplicate"] += 1
            return
        line.doubt.add(stamp, row)
        line.doubt.timely |= timely(stamp, came)
        line.spoke = self._newest
        verdict = self._vote.verdict(line) if self._vote.is_due(line, stamp, newest) else None
        if verdict or self._vote.follower_at(stamp):
            self._believe(stream, line)
        elif is_lost(line.doubt, stamp, verdict):
            self._leave_out(stream, line)

    def _believe(self, stream: str, line: Line) -> None:
        """Go by the clock of what was put aside; what other streams told by a clock that went ahead is of it, too."""
        if line.went_back:
            self._jump(stream)
            return
        reached = max(line.doubt.top, self._newest)
        self._take_in({stream: line} | self._within(reached))

    def _within(self, newest: int) -> dict[str, Line]:
        """Streams of which what was put aside leaps no more where all have come to a stamp."""
        return {name: line for name, line in self._lines.items()
                if line.doubt is not None and not self._vote.leaps(line, line.doubt.first, newest)}

    def _take_in(self, lines: Mapping[str, Line]) -> None:
        """Take in what was put aside, in the order of stamps, so that no stream seems to lag."""
        told = sorted(((stamp, name, row) for name, line in lines.items() for stamp, row in line.doubt.rows.items()), key=itemgetter(0))
        for line in lines.values():
            line.doubt = None
        for stamp, name, row in told:
            self._accept(name, lines[name], stamp, row)

    def _leave_out(self, stream: str, line: Line) -> None:
        """Forget what was put aside; the stream goes on as before."""
        line.parted = line.parted or self._vote.was_put_back(line)
        behind = self._newest_of(line) - line.doubt.first
        self._count_strays(stream, cause(behind), len(line.doubt), line.doubt.first - line.doubt.left)
        line.doubt = None

    def _leave_out_strays(self) -> None:
        """At the beginning: leave out what is of another clock than all that comes after a long silence."""
        if self._cutter.begins:
            for name, strays in take_strays(self._lines, self._longest_gap):
                self._count_strays(name, "other_clock", len(strays), strays[0] - self._newest)

    def _count_strays(self, stream: str, why: str, number: int, off: int) -> None:
        self.counts[stream, why] += number
        self.strayed[stream, why] = off

    def _newest_of(self, line: Line) -> int:
        """Newest stamp of a stream, of all while it has none."""
        return self._newest if line.newest is None else line.newest

    def _told_too(self, doubt: Doubt | None) -> dict[str, list[tuple[int, Sequence[float]]]]:
        """What streams told by the earlier clock that is believed, by any where it is a follower's; that of a third one is left out."""
        told = {}
        for name, line in self._lines.items():
            if line.went_back and (doubt is None or line.doubt.near(doubt, self._vote.near)):
                told[name] = list(line.doubt.rows.items())
            elif line.went_back:
                self._leave_out(name, line)
        return told

    def _jump(self, stream: str) -> None:
        """The clock jumped back: everything that waits belongs to the old time."""
        self.counts[stream, "clock_jump"] += 1
        followed = {name: line.held for name, line in self._lines.items() if line.held}
        for name, held in followed.items():
            self._lines[name].forget(held[0][0])
        before = followed | self._told_too(self._lines[stream].doubt)
        self._leave_out_strays()
        self._done += self._cutter.drain(min(self._longest_gap, self._window + self._timeout) // self.interval_ns)
        self._cutter.begin_anew()
        self.late.clear()
        self._newest = None
        for name, line in self._lines.items():
            ahead = name in before or name == stream or line.newest is None or line.owed < 0 or line.behind is not None
            owed = 0 if ahead else line.owed + 1 if line.follows else 1
            line.restart(owed, line.newest if owed else None)
        for name, held in before.items():  # these had gone back before this stream
            for stamp, row in held:
                self.push(name, stamp, row)
