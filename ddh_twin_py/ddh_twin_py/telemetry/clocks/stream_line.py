"""One stream of live samples: what waits of it to be cut into ticks, what it told of its clock, and what it told by another one."""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Sequence

LONGEST_LAG = 10.0
"""s by which an awaited stream that goes on may lag and is waited for: ticks come so late, and what comes meanwhile is kept in memory."""
LONGEST_LAG_NS = round(LONGEST_LAG * 1e9)
APART = 2.0
"""s from which a stream that stepped off the others alone is no longer taken to lag, nor they: its clock is put to the vote."""
APART_NS = round(APART * 1e9)
_LAGS_FOR = 60_000_000_000  # ns of data without it, after which a lag is forgotten, within as much again


class Doubt:
    """What a stream told by another clock, until it is believed: `rows` by stamp in the order in which they came, never none.

    `first` is the stamp of the first, `top` the newest of them, `since` the number of the push of the first, and `left` the newest stamp
    of all streams before it; `timely` says whether any of them came as it was stamped.
    """

    __slots__ = ("first", "left", "rows", "since", "timely", "top")

    def __init__(self, stamp: int, row: Sequence[float], since: int, left: int) -> None:
        self.rows = {stamp: row}
        self.first = self.top = stamp
        self.since, self.left = since, left
        self.timely = False

    def __len__(self) -> int:
        return len(self.rows)

    def add(self, stamp: int, row: Sequence[float]) -> None:
        self.rows[stamp] = row
        self.top = max(self.top, stamp)

    def near(self, other: Doubt, apart: int) -> bool:
        """Whether another stream's samples may be of the same clock."""
        return self.first <= other.top + apart and other.first <= self.top + apart


class Line:
    """One stream within the live aligner: what is waiting, sorted by stamp.

    `owed` counts the clock jumps that others have shown and this stream has not; below 0 it went
    back by itself. `since` is its first stamp since it owes one, `top` its newest before it went back,
    `held` what came since then. `doubt` is what came by another clock, None where nothing did. `rose` is the number of the push that
    brought the newest stamp, and `heard` what the newest stamp of all was then; `lag` is the longest, ns, by which a stamp that was its
    newest lay behind that of all, up to `LONGEST_LAG`, in this minute or the one before. `first` is the first stamp since the ticks began
    and `told` counts the samples since then; `spoke` is the newest stamp of all when it told anything last, by any clock. `parted` says
    whether its clock was put back by itself. `alive` says whether ticks wait for it. `behind` is by how many ns its first stamp lay behind
    the newest of all, where neither that nor what it told since could be a lag, else None. `came` is the newest of its stamps that came by
    the computer's clock as it says, None where none did.
    """

    __slots__ = ("alive", "awaited", "behind", "came", "doubt", "first", "follows", "heard", "held", "lag", "lagged", "lags_since",
                 "newest", "owed", "parted", "rose", "rows", "since", "spoke", "stamps", "told", "top", "width")

    def __init__(self, width: int, awaited: bool, follows: bool) -> None:
        self.width = width
        self.awaited = awaited
        self.follows = follows
        self.stamps: list[int] = []
        self.rows: dict[int, Sequence[float]] = {}
        self.rose = self.lag = self.lagged = 0
        self.lags_since: int | None = None
        self.restart()

    def restart(self, owed: int = 0, newest: int | None = None) -> None:
        self.newest, self.owed = newest, owed
        self.first: int | None = None
        self.behind: int | None = None
        self.came: int | None = None
        self.heard: int | None = None
        self.told = 0
        self.spoke: int | None = None
        self.parted = False
        self.alive = self.awaited
        self.since: int | None = None
        self.top: int | None = None
        self.held: list[tuple[int, Sequence[float]]] = []
        self.doubt: Doubt | None = None

    def step_back(self, stamp: int) -> None:
        """A stream that follows others went back to this stamp; what waits beyond it will come again."""
        top = self.newest
        self.restart(self.owed - 1)
        self.top = top
        self.forget(stamp)

    def rise(self, stamp: int, newest: int | None, number: int) -> None:
        """Its newest stamp is this one now, by the push of a number; `newest` is the newest of all before it."""
        self.newest, self.rose, self.parted = stamp, number, False
        self.heard = self.spoke = stamp if newest is None else max(newest, stamp)
        if self.first is None:
            self.first, self.behind = stamp, None if newest is None or self.follows and self.came != stamp else newest - stamp
        if newest is None or stamp > newest - LONGEST_LAG_NS:
            self.behind = None
            self.alive = self.awaited
            self._note_lag(stamp, 0 if newest is None else max(0, newest - stamp))
        if self.top is not None and stamp > self.top:
            self.owed, self.top, self.held = 0, None, []  # it went back alone and is where it was

    def _note_lag(self, stamp: int, lag: int) -> None:
        """It lags by so many ns at this stamp; `lagged` is the longest since `lags_since`."""
        if self.lags_since is None or stamp < self.lags_since:
            self.lags_since = stamp
        elif stamp > self.lags_since + _LAGS_FOR:
            self.lag, self.lagged, self.lags_since = self.lagged, 0, stamp
        self.lagged = max(self.lagged, lag)
        self.lag = max(self.lag, lag)

    def wait(self, stamp: int, row: Sequence[float]) -> None:
        """Let a sample wait for its tick."""
        self.rows[stamp] = row
        if self.stamps and stamp < self.stamps[-1]:
            insort(self.stamps, stamp)
        else:
            self.stamps.append(stamp)

    def take(self, end: int) -> tuple[list[int], list[Sequence[float]]]:
        """Stamps and rows of what waits up to a stamp; they wait no more."""
        count = bisect_right(self.stamps, end)
        stamps = self.stamps[:count]
        del self.stamps[:count]
        return stamps, [self.rows.pop(stamp) for stamp in stamps]

    def forget(self, stamp: int) -> None:
        """Leave out what waits from this stamp on."""
        keep = bisect_right(self.stamps, stamp - 1)
        for again in self.stamps[keep:]:
            del self.rows[again]
        del self.stamps[keep:]

    @property
    def timely(self) -> bool:
        """Whether it goes by the computer's clock, as its newest samples or, before a lag, some did."""
        return self.came is not None and self.newest is not None and self.newest <= self.came + LONGEST_LAG_NS

    @property
    def stale(self) -> bool:
        """Whether its samples are still those from before a jump of the clock."""
        return self.owed > 0

    @property
    def went_back(self) -> bool:
        """Whether what came by another clock is of an earlier time."""
        return self.doubt is not None and self.newest is not None and self.doubt.first < self.newest

    @property
    def seconds_off(self) -> bool:
        """Whether what came by another clock went on, and seconds off all streams."""
        return self.doubt is not None and not self.went_back and abs(self.doubt.first - self.doubt.left) <= LONGEST_LAG_NS

    def goes_on_doubted(self, stamp: int) -> bool:
        """Whether a stamp follows what came by an earlier clock rather than what came before it."""
        return self.went_back and stamp <= self.newest and stamp - self.doubt.top < self.newest - stamp

    @property
    def step(self) -> int:
        """Usual time between its samples, ns; that of the slowest streams that are waited for where it told one."""
        return (self.newest - self.first) // (self.told - 1) if self.told > 1 and self.first is not None else LONGEST_LAG_NS
