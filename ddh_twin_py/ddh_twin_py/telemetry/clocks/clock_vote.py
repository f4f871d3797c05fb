"""Whose clock is believed where streams part: the vote of all streams on what one of them tells by another clock.

**Doubt.** A stream is doubted

- whose stamps lie more than the reorder window behind its newest;
- whose stamps lie further ahead of all than streams that lag are waited for: 10 s, or twice the usual step of the fastest;
- that leaves out seconds (`APART`), while it speaks, which no other has told nor lags by.
  One that lags was silent and goes on where it was.

What it tells is put aside until it has gone on so for longer than the reorder window or half of the step. Then all streams vote.

**Votes.** For it are those that tell the same clock, itself among them. Against it are those that have meanwhile told, by the clock of
before, more than a reorder window beyond all that had come. Silent is a stream that had no time to speak: for twice its usual step, its lag
and the reorder window, 10 s at most. Where two streams leave out seconds, as in a pause of all, that time is `APART`. What was put aside is
believed once more are for it than against it and silent together.

**Left out.** A stream that is outvoted is left out. It is doubted anew with what it tells next, until its stamps go on as before or others
tell its clock, too. The same holds for one that tells a third clock where a jump back is believed. A stamp after which its stream goes on
as before is of another clock, as of a second machine on the topic, and left out.

**The begin.** Where a stream that spoke first is by another clock from its begin on, all others lie behind it. They are believed once more
of them tell one clock, for as long and as fast as it goes on, than speak by that of the first.

**The computer's clock.** An awaited stream and another one that both come as they are stamped, by the computer's clock, are right, however
many tell another one: all sensors of one logger have one clock.

**Late messages.** A step back of 5 s or less may be messages that are late. While other streams go on, it is left out as late. While none
does, it must be told by several samples that are as close as the stream's are. Where as many and as close ones were left out as late, the
stream's clock was put back alone: what it tells is doubted until it is as far as the others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from ddh_twin_py.telemetry.clocks.stream_line import APART_NS, LONGEST_LAG_NS, Doubt, Line

_MOST_DOUBTED = 20_000  # samples of another clock that are put aside
_OUTVOTED = 3_000_000_000  # ns of them after which they are left out where more streams go on
_LATEST = 5_000_000_000  # ns by which messages may be late without being taken for those of a clock that jumped
_FEWEST = 5  # samples in a row that show a clock that jumped back by less


@dataclass(frozen=True, slots=True)
class ClockVote:
    """The votes of streams, by name, that may come `window` late; those that follow others tell within `timeout` what these told, ns."""

    lines: Mapping[str, Line]
    window: int
    timeout: int

    @property
    def near(self) -> int:
        """ns within which streams tell the same clock."""
        return self.window + self.timeout

    def leaps(self, line: Line, stamp: int, newest: int | None) -> bool:
        """Whether a stamp lies behind its stream, or far ahead of all, the newest of which is given, or seconds off by its own step."""
        if line.newest is not None and stamp < line.newest - self.window:
            return True
        newest = max(line.newest or 0, newest or 0)
        if line.parted and stamp < newest - APART_NS - line.lag:
            return True
        if stamp <= newest + APART_NS or not newest or line.stale:
            return False
        return stamp > newest + max(LONGEST_LAG_NS, self.longest_silence) or self._steps_ahead(line, stamp, newest)

    def _steps_ahead(self, line: Line, stamp: int, newest: int) -> bool:
        """Whether a stream that speaks leaves out seconds, its usual step apart, which no other has told nor lags by."""
        if line.newest is None or line.follows or newest - line.spoke > max(LONGEST_LAG_NS, 2 * line.step):
            return False
        lags = [other.lag for other in self.lines.values()
                if other is not line and not other.stale and other.newest is not None and other.newest > newest - LONGEST_LAG_NS]
        return bool(lags) and stamp - line.newest - line.step > APART_NS and stamp > newest + APART_NS + max(lags)

    @property
    def longest_silence(self) -> int:
        """ns without a sample that are no pause: twice the usual step of the fastest stream."""
        return 2 * min(line.step for line in self.lines.values())

    def is_due(self, line: Line, stamp: int, newest: int) -> bool:
        """Whether what a stream told by another clock, this stamp last, went on for so long that it is voted on."""
        return stamp - line.doubt.first > min(self.window, abs(newest - line.doubt.first) // 2)

    def verdict(self, line: Line, last: bool = False) -> bool | None:
        """Whether more streams tell the clock of what one told last, itself among them, than go on as before; None while that is open.

        It is while messages may be late, and unless this is the last that it tells while there are streams that had no time to tell: twice
        their usual step, the reorder window and their lag.
        """
        if self.may_be_late(line):
            return None
        if self._right(other for other in self.lines.values() if other.doubt is not None and other.doubt.timely):
            return True if line.doubt.timely else None
        right = [other for other in self.lines.values() if other.doubt is None and other.timely and not other.stale]
        if self._right(right) and not line.doubt.timely:
            if any(self.goes_on(other, line.doubt) for other in right):
                return False
            if not last and any(self.may_speak(other, line.doubt) for other in right):
                return None
        doubt, agree, against, silent = line.doubt, 0, 0, 0
        for other in self.lines.values():
            if other.doubt is not None:
                agree += other.doubt.near(doubt, self.near)
            elif self.goes_on(other, doubt):
                against += 1
            elif not last:
                silent += self.may_speak(other, doubt)
        if agree > 1 and not against and line.seconds_off and doubt.top - doubt.first > APART_NS:
            silent = 0  # as after a pause of all, which slow ones need not hold up
        return True if agree > against + silent else None if silent else False

    def _right(self, lines: Iterable[Line]) -> bool:
        """Whether streams that go by the computer's clock are right: one that is awaited, and one more."""
        awaited = [line.awaited for line in lines]
        return len(awaited) > 1 and any(awaited)

    def at_the_end(self, line: Line, newest: int) -> bool | None:
        """The verdict where nothing more comes for now; what others have reached since was a pause, and one sample else is no clock."""
        if line.seconds_off:
            return not self.leaps(line, line.doubt.top, newest) or self.verdict(line, last=True)
        return self.verdict(line) if len(line.doubt) > 1 else None

    def may_be_late(self, line: Line) -> bool:
        """Whether what came by an earlier clock may be late instead: by seconds at most, and not as much of it as goes on by a clock.

        Of a clock that jumped come `_FEWEST` samples or more, half as close as the stream's at least, and no stream goes on meanwhile;
        where it is awaited, no other that is: the next sample of a slow one is newer than its last by the new clock, too.
        """
        doubt = line.doubt
        if not line.went_back or line.newest - doubt.first > _LATEST:
            return False
        return not self.was_put_back(line) or any(
            other.rose > doubt.since and not other.stale and not other.follows and (other.awaited or not line.awaited)
            for other in self.lines.values())

    def was_put_back(self, line: Line) -> bool:
        """Whether what came by an earlier clock is as much and as close as a stream tells that goes on by it."""
        if not line.went_back:
            return False
        doubt = line.doubt
        count, span, before = len(doubt), doubt.top - doubt.first, line.newest - (line.first or line.newest)
        return count >= _FEWEST and 2 * count * before >= line.told * span

    def catches_up(self, line: Line, stamp: int) -> bool:
        """Whether a stream reaches the others without a leap from what it told seconds off them: it was right."""
        doubt = line.doubt
        return not line.went_back and abs(stamp - doubt.top) <= max(self.window, 2 * line.step)

    def outvotes(self, line: Line, stamp: int, newest: int) -> bool:
        """Whether a stream that lies behind all since it began, and keeps that distance, tells with more streams than are ahead of it."""
        if line.behind is None or stamp - line.first <= APART_NS or abs(newest - stamp - line.behind) > self.window:
            return False
        agree, ahead = [], []
        for other in self.lines.values():
            if other.newest is None or other.stale or other.doubt is not None:
                continue
            if other.behind is None:
                if newest - other.newest <= max(LONGEST_LAG_NS, 2 * other.step):
                    ahead.append(other)
            elif abs(other.newest - stamp) <= LONGEST_LAG_NS:
                agree.append(other)
        for lines, right in ((ahead, False), (agree, True)):
            if self._right(other for other in lines if other.timely):
                return right
        return len(agree) > len(ahead)

    def goes_on(self, line: Line, doubt: Doubt) -> bool:
        """Whether a stream has told, by the clock of all, what lies beyond all that came before another one was doubted."""
        return line.doubt is None and not line.stale and line.rose > doubt.since and line.newest > doubt.left + self.window

    def may_speak(self, line: Line, doubt: Doubt) -> bool:
        """Whether a stream that told neither clock had no time to, and spoke shortly before another one was doubted."""
        if line.newest is None or line.stale or line.newest <= doubt.left - LONGEST_LAG_NS:
            return False
        return doubt.top - doubt.first <= min(2 * line.step + self.window + line.lag, LONGEST_LAG_NS)

    def follower_at(self, stamp: int) -> bool:
        """Whether a stream that follows others went back by itself and is near a stamp."""
        return any(line.owed < 0 and line.held and abs(line.held[-1][0] - stamp) <= self.near for line in self.lines.values())

    def led(self, follower: Line) -> bool:
        """Whether a stream that this one could be computed from speaks."""
        oldest = follower.newest - self.near
        return any(newest >= oldest for newest in self._newest_of_leaders())

    def leads_behind(self, stamp: int, longest_gap: int) -> bool:
        """Whether a stream that others follow speaks so far behind a stamp that the time between, ns, would be skipped."""
        return any(stamp > newest + longest_gap for newest in self._newest_of_leaders())

    def _newest_of_leaders(self) -> Iterator[int]:
        """Newest stamps of the streams that follow none and go by the clock of all."""
        return (line.newest for line in self.lines.values() if not line.follows and not line.stale and line.newest is not None)


def timely(stamp: int, came: int | None) -> bool:
    """Whether a sample came as it is stamped, ns, by the computer's clock where that is known."""
    return came is not None and abs(stamp - came) <= APART_NS


def is_lost(doubt: Doubt, stamp: int, verdict: bool | None) -> bool:
    """Whether what was told by another clock up to a stamp is left out: it is outvoted, or undecided for too long."""
    return len(doubt) > _MOST_DOUBTED or stamp - doubt.first > (_OUTVOTED if verdict is False else LONGEST_LAG_NS)


def cause(behind: int) -> str:
    """What samples are counted as of which the first lies so many ns behind and that are left out."""
    return "late" if 0 < behind <= _LATEST else "other_clock"


def take_strays(lines: Mapping[str, Line], longest_gap: int) -> Iterator[tuple[str, list[int]]]:
    """Where ticks begin: take out, by stream, what fewer of them tell than tell a time after a long silence; it is of another clock."""
    while waiting := {name: line for name, line in lines.items() if line.stamps}:
        end = min(line.stamps[0] for line in waiting.values()) + longest_gap
        early = [name for name, line in waiting.items() if line.stamps[0] <= end]
        if len(early) >= sum(line.stamps[-1] > end for line in waiting.values()):
            return
        for name in early:
            yield name, waiting[name].take(end)[0]
