"""Order of stamps: which are late, and where a clock jumped back."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

import numpy as np

from ddh_twin_py.physics.compiled import inlined, kernel

PUT_BACK = 10.0
"""s by which a clock may be put back, and the twin goes on as warm as it is; by more it begins anew."""
NEWEST, BEGAN, ENDED, LEFT, RETURNED = range(5)
"""Entries of a stream's `clock` int64[CLOCK_ENTRIES], ns: its newest stamp, the first one since it was put back last, the newest before
that, and the newest before what may be late of the time before that, `NEVER` where there is none; and how often what was late RETURNS,
0 to begin with."""
CLOCK_ENTRIES = 5
NEVER = -(2**63)
_MOST_RETURNS = 100  # of a stream; two machines that publish alternately on one topic go on to and fro for ever
RISES, BEHIND, JUMPS, LEAPS, RETURNS = range(5)
"""What a stamp does, see `clock_step`."""
_SEEN_AS = 0.25
"""s by which nodes differ in how far a clock was put back: each knows the last and the first sample of its own streams alone."""


def same_unit(gap: float) -> bool:
    """Whether a unit goes on as warm as it was where stamps do not go on but are off by ``gap`` seconds: a clock was put back a little.

    `PUT_BACK` and `_SEEN_AS` more, so that nodes whose streams saw the same clock put back by just as much decide alike.
    """
    return -PUT_BACK - _SEEN_AS <= gap < 0.0


class Break(Enum):
    """What stamps that do not go on say of the unit."""

    PUT_BACK = "a clock was put back a little: it is as warm as it was"
    PAUSE = "a long time was skipped: it rested, or ran unseen"
    OTHER_TIME = "the stamps are of an earlier time: nothing of before is true of it"

    @classmethod
    def of(cls, gap: float) -> Break:
        """The break at which stamps go on ``gap`` seconds after, below 0 before, the last ones."""
        return cls.PUT_BACK if same_unit(gap) else cls.OTHER_TIME if gap < 0.0 else cls.PAUSE

    def words(self, gap: float) -> str:
        """What happened, in words that are the same in all nodes."""
        happened = {Break.PUT_BACK: "the clock was put back by {:.1f} s", Break.PAUSE: "the stamps go on {:.1f} s later",
                    Break.OTHER_TIME: "the stamps jump back by {:.1f} s"}
        return happened[self].format(abs(gap))


def clock_segments(stamps: Mapping[str, np.ndarray], window_ns: int) -> dict[str, np.ndarray]:
    """For every sample, how often the clock had jumped back before it (int64[n] per stream).

    Stamps are int64[n] ns in order of arrival. A stamp more than `window_ns` older than the
    newest before it is a jump; what comes up to `window_ns` late from before a jump is of the time before (`clock_step`). A stream too
    slow to show a jump that others show is cut where its stamps pass the last ones from before that jump.
    """
    segments = {name: _jumps_before(np.ascontiguousarray(stamp), window_ns) for name, stamp in stamps.items()}
    counts = {name: int(s[-1]) if s.size else 0 for name, s in segments.items()}
    most = max(counts.values(), default=0)
    slow = [name for name, count in counts.items() if count < most and segments[name].size]
    for name in slow:
        ends = np.full(most, np.iinfo(np.int64).min)
        for other, segment in segments.items():
            if counts[other] == most:
                before = segment < most
                np.maximum.at(ends, segment[before], stamps[other][before])
        segments[name] = _cut(np.ascontiguousarray(stamps[name]), segments[name], ends + window_ns)
    return segments


def sorted_order(stamp: np.ndarray, segment: np.ndarray) -> np.ndarray | slice:
    """Indices int64[k] that sort by segment, then stamp, without the repeated stamps.

    Of samples with the same stamp in the same segment the first to arrive stays. Where all are
    sorted already it is the slice of all, which makes no copy.
    """
    if stamp.size < 2 or (np.all(stamp[1:] > stamp[:-1]) and segment[0] == segment[-1]):
        return slice(None)
    order = np.lexsort((stamp, segment))
    repeated = np.zeros(stamp.size, bool)
    repeated[1:] = (np.diff(stamp[order]) == 0) & (np.diff(segment[order]) == 0)
    return order[~repeated]


@inlined
def clock_begin(stamp, clock):  # pragma: no cover - compiled
    """The first stamp of a stream, or the first one since it was put back."""
    clock[NEWEST] = clock[BEGAN] = stamp
    clock[ENDED] = clock[LEFT] = NEVER


@inlined
def clock_step(stamp, clock, window):  # pragma: no cover - compiled
    """What the next stamp of a stream does, all in ns: it RISES, or stays BEHIND the newest; beyond `window` it JUMPS back.

    Within `window` of the time after a jump it LEAPS to within `window` of the end of the time before: it may be late. It was, with all
    since, if the next stamp that does not go on there RETURNS, which is no further jump, `_MOST_RETURNS` times at most.
    """
    newest = clock[NEWEST]
    if stamp < newest - window:
        if clock[LEFT] != NEVER and stamp >= clock[LEFT] - window and clock[RETURNED] < _MOST_RETURNS:
            clock[NEWEST] = max(clock[LEFT], stamp)
            clock[LEFT] = NEVER
            clock[RETURNED] += 1
            return RETURNS
        clock_begin(stamp, clock)
        clock[ENDED] = newest
        return JUMPS
    if stamp <= newest:
        return BEHIND
    clock[NEWEST] = stamp
    if clock[ENDED] == NEVER or stamp > clock[ENDED] + window:
        clock[LEFT] = NEVER
    elif clock[LEFT] == NEVER and newest + window < stamp and clock[ENDED] - window < stamp and newest <= clock[BEGAN] + window:
        clock[LEFT] = newest
        return LEAPS
    return RISES


@kernel
def _jumps_before(stamp, window):  # pragma: no cover - compiled
    segment = np.zeros(stamp.size, np.int64)
    clock = np.zeros(CLOCK_ENTRIES, np.int64)
    number = leapt = 0
    for i in range(stamp.size):
        if i == 0:
            clock_begin(stamp[i], clock)
            continue
        step = clock_step(stamp[i], clock, window)
        if step == JUMPS:
            number += 1
        elif step == LEAPS:
            leapt = i
        elif step == RETURNS:
            segment[leapt:i] -= 1
        segment[i] = number
    return segment


@kernel
def _cut(stamp, own, ends):  # pragma: no cover - compiled
    """Segments of a slow stream: its own jumps, and those that its stamps have passed."""
    segment = np.empty_like(own)
    number = jumps = 0
    for i in range(stamp.size):
        if own[i] > jumps:
            number += 1
        elif own[i] == jumps and number < ends.size and stamp[i] > ends[number]:
            number += 1
        jumps = max(jumps, own[i])
        segment[i] = min(number, ends.size) - (jumps - own[i])
    return segment
