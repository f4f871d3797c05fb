"""Which samples of a recording are of another clock, as the recorder's own clock tells: those that live nodes leave out, see `clock_vote`.

The recorder's clock tells when a message came. A topic's clock is by how much its stamps lie ahead of that, where they are delayed least.
It steps where stamps go back, or ahead by seconds that did not go by; a lag is no step: after a silence stamps go on where they were.
Between two steps of any topic every one has one voice for its clock. It is left out where more tell another than tell the same, and where
they are as many, if it is the one that stepped. What a topic is off from its begin by 10 s or less is its lag, or that of the others.
Where drive or hydraulics and another topic go by the recorder's clock for longer than a lag, they are right, however many tell another one:
all sensors of one logger have one clock, and that of the machine and of the recorder have nothing else in common than being right.

Where the recorder's clock is a copy of the stamps, or jumps, or runs otherwise than they do, it tells nothing, and nothing is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ddh_twin_py.telemetry.clocks.stream_line import APART_NS, LONGEST_LAG_NS
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC

_FEWEST = 5  # samples in a row that tell a clock
_LATEST = 5_000_000_000  # ns by which fewer may be late
_TOGETHER = 500_000_000  # ns within which topics step at once
_MOST_STEPS = 200  # of a topic's clock, beyond which it tells nothing


@dataclass
class _Piece:
    """Samples ``first`` to ``stop`` of a topic, between two steps of its clock, the ``number``-th.

    ``begin``, ``end``: when the first and the last came. ``ahead``: of the recorder's clock, least delayed. All ns. ``votes``: whether they
    are enough, and go by as the recorder's clock does. ``verdicts``: by interval, its begin, 1 believed, -1 outvoted, 0 undecided, and how
    far it is off.
    """

    topic: str
    number: int
    first: int
    stop: int
    begin: int
    end: int
    ahead: int
    votes: bool
    verdicts: list[tuple[int, int, int]] = field(default_factory=list)


def other_clocks(stamps: Mapping[str, np.ndarray], came: Mapping[str, np.ndarray]) -> dict[str, tuple[np.ndarray, int]]:
    """Topics that have samples of another clock: which of them, bool (n,), and by how many ns the first is ahead of the others.

    Args:
        stamps: ns, int64 (n,), in order of arrival. came: when they came by the recorder's clock, ns, int64 (n,).
    """
    begun = {topic: _pieces(topic, stamps[topic], came[topic]) for topic in stamps}
    lags = _lags({topic: next(piece.ahead for piece in pieces if piece.votes) for topic, pieces in begun.items() if pieces})
    came = {topic: came[topic] - lag for topic, lag in lags.items()}
    told = {topic: pieces for topic in lags if (pieces := _pieces(topic, stamps[topic], came[topic]))}
    every = [piece for pieces in told.values() for piece in pieces]
    edges = sorted({piece.begin for piece in every})
    for at, until in pairwise([*edges, max((piece.end for piece in every), default=0)]):
        here = [piece for piece in every if piece.begin <= at <= piece.end]
        voters = [piece for piece in here if piece.votes and piece.end - at >= _TOGETHER]
        right = right_by_recorder({piece.topic: piece.ahead for piece in voters if piece.end - at > LONGEST_LAG_NS})
        for piece in here:
            if min(piece.end, until) - at >= _TOGETHER or piece.end - piece.begin < _TOGETHER:
                piece.verdicts.append((at, *_verdict(piece, [other for other in voters if other.topic != piece.topic], right)))
    return {topic: found for topic, pieces in told.items() if (found := _outvoted(pieces, came[topic]))}


def outvoted(ahead: Mapping[str, int]) -> dict[str, int]:
    """Topics of which the clock is another than more of them tell, and by how many ns it is ahead of theirs.

    Args:
        ahead: of one clock that all are held against, by topic, ns.
    """
    lags = _lags(ahead)
    pieces = [_Piece(topic, 0, 0, _FEWEST, 0, 0, clock + lags[topic], votes=True) for topic, clock in ahead.items()]
    right = right_by_recorder({piece.topic: piece.ahead for piece in pieces})
    verdicts = {piece.topic: _verdict(piece, [other for other in pieces if other is not piece], right) for piece in pieces}
    return {topic: off for topic, (verdict, off) in verdicts.items() if verdict < 0}


def right_by_recorder(ahead: Mapping[str, int]) -> frozenset[str]:
    """Topics that go by the recorder's clock, if drive or hydraulics and one more do; none otherwise.

    Args:
        ahead: of the recorder's clock, by topic, ns.
    """
    right = frozenset(topic for topic, clock in ahead.items() if abs(clock) <= APART_NS)
    return right if len(right) > 1 and not right.isdisjoint((DRIVE_TOPIC, HYDRAULIC_TOPIC)) else frozenset()


def _lags(ahead: Mapping[str, int]) -> dict[str, int]:
    """How much later than most the topics come from their begin on, ns, 0 where that is no lag."""
    usual = int(np.median(list(ahead.values()))) if ahead else 0
    return {topic: usual - clock if abs(usual - clock) <= LONGEST_LAG_NS else 0 for topic, clock in ahead.items()}


def _pieces(topic: str, stamp: np.ndarray, came: np.ndarray) -> list[_Piece]:
    """What lies between the steps of a topic's clock, none where the recorder's says nothing of it."""
    ahead = stamp - came
    if stamp.size < _FEWEST or np.any(np.diff(came) < -APART_NS):
        return []
    copies = np.count_nonzero(ahead == np.sort(ahead)[ahead.size // 2])
    if 2 * copies > stamp.size:
        return []
    back = np.diff(stamp) < -APART_NS
    leaps = np.flatnonzero(back | (np.diff(ahead) > APART_NS)) + 1
    cuts, tops = [0], [int(ahead[: leaps[0] if leaps.size else None].max())]
    for leap, following in pairwise([*leaps, ahead.size]):
        top = int(ahead[leap:following].max())
        if back[leap - 1] or ahead[leap] > tops[-1] + APART_NS:
            cuts.append(int(leap))
            tops.append(top)
        else:
            tops[-1] = max(tops[-1], top)
    if len(cuts) > _MOST_STEPS:
        return []
    pieces = []
    for number, ((first, stop), top) in enumerate(zip(pairwise([*cuts, ahead.size]), tops, strict=True)):
        slower = int(came[stop - 1] - came[first]) - int(stamp[stop - 1] - stamp[first])
        votes = stop - first >= _FEWEST and abs(slower) <= APART_NS
        pieces.append(_Piece(topic, number, first, stop, int(came[first]), int(came[stop - 1]), top, votes))
    voting = sum(piece.stop - piece.first for piece in pieces if piece.votes)
    return pieces if 2 * voting > stamp.size else []


def _verdict(piece: _Piece, others: list[_Piece], right: frozenset[str]) -> tuple[int, int]:
    """Whether a piece is believed (1), outvoted (-1) or neither (0) by others, and by how many ns it is ahead of most against it.

    ``right``: topics that are right anyway.
    """
    if right and abs(piece.ahead) <= APART_NS:
        return 1, 0
    others = [other for other in others if other.topic in right] if right else others
    off = np.array([piece.ahead - other.ahead for other in others], np.int64)
    agree = 1 + int(np.count_nonzero(np.abs(off) <= APART_NS))
    alike = np.abs(off[:, None] - off) <= APART_NS
    alike[np.abs(off) <= APART_NS] = False
    against = alike[np.argmax(alike.sum(axis=1))] if off.size else alike.any(axis=0)
    count = int(np.count_nonzero(against))
    if count < agree and not right:
        return int(agree > 1), 0
    ahead, few = int(np.median(off[against])), piece.stop - piece.first < _FEWEST
    if not piece.votes and not few or few and -_LATEST <= ahead < 0:
        return 0, 0
    stepped = piece.number and any(other.begin < piece.begin for other, here in zip(others, against, strict=True) if here)
    return (-1, ahead) if right or count > agree or stepped else (0, 0)


def _outvoted(pieces: list[_Piece], came: np.ndarray) -> tuple[np.ndarray, int] | None:
    """Which samples of a topic are left out, and by how many ns the first is ahead; None where none is."""
    out, first = np.zeros(came.size, bool), 0
    for piece in pieces:
        decided = [verdict for verdict in piece.verdicts if verdict[1]]
        if not any(verdict < 0 for _, verdict, _ in decided):
            continue
        edges = piece.first + np.searchsorted(came[piece.first : piece.stop], [at for at, _, _ in decided[1:]])
        for (_, verdict, ahead), begin, end in zip(decided, [piece.first, *edges], [*edges, piece.stop], strict=True):
            if verdict < 0:
                first = first if out.any() else ahead
                out[begin:end] = True
    return (out, first) if out.any() else None
