"""In which order the messages of a bag came, however they stand in its files, and at which times."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.ticks import LONGEST_GAP, to_ns

_STEP_BACK = 10**9  # ns by which a recorder's clock was set back, or a part of a file stands before another
_MANY = 0.25  # share of the topics that step back where the recorder's clock does
_SHORTEST = 10  # messages between two steps back, on average, below which no clock was set back so often: the file is in no order


def steps_of_arrival(log_time: np.ndarray, topic: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times, ns, int64[n], of messages in the order of the file, and the first of them after each step back of the recorder's clock.

    Times are the recorder's (``topic`` int64[n] numbers the topics), but for messages of a topic whose own times step back where those of
    most others go on, as of several publishers that lag unlike, or that begin with another clock: these have the time of what they came
    after, or before where they are first.
    """
    of_topic = np.argsort(topic, kind="stable")
    change = np.diff(log_time)
    fell = np.flatnonzero((np.diff(log_time[of_topic]) < -_STEP_BACK) & (np.diff(topic[of_topic]) == 0))
    spans = zip(of_topic[fell].tolist(), of_topic[fell + 1].tolist(), strict=True)
    lost = np.array([before + int(np.argmin(change[before:after])) + 1 for before, after in spans], np.int64)  # where most is
    first, place = np.unique(lost, return_inverse=True)
    votes, falls, topics = np.zeros(first.size), np.zeros(first.size), 0
    for own in np.split(of_topic, np.flatnonzero(np.diff(topic[of_topic])) + 1):
        after = np.searchsorted(own, first)
        across = np.flatnonzero((after > 0) & (after < own.size))
        falling = log_time[own[after[across]]] < log_time[own[after[across] - 1]]
        votes[across] += np.where(falling, 1.0, -1.0)
        falls[across] += falling
        topics += own.size > 1
    all_fall = (votes > 0.0) & (falls >= _MANY * topics)
    back = first[all_fall]
    steady = np.flatnonzero(~np.isin(topic, topic[of_topic[fell[~all_fall[place]]]]))
    if 2 * steady.size < topic.size:
        return log_time, back
    number = np.arange(topic.size)
    after = np.searchsorted(steady, number, side="right")  # number of steady messages up to each
    begin = np.searchsorted(steady, np.concatenate([[0], back]))[np.searchsorted(back, number, side="right")]  # and before its part
    return log_time[steady[np.minimum(np.maximum(after - 1, begin), steady.size - 1)]], back


def order_of_arrival(log_time: np.ndarray, back: np.ndarray | None = None) -> np.ndarray:
    """Indices of messages in order of arrival, int64[n], from the recorder's clock, ns, in the order of the file.

    Parts of a file may stand in any order, each as a whole in a gap of another. Where they tell the same time instead, the recorder's
    clock was set back between them, and they came as they stand. ``back``: first message of each part but the first, as `steps_of_arrival`
    finds it; None: of one topic, where its times step back.
    """
    order = np.argsort(log_time, kind="stable")
    first = np.concatenate([[0], np.flatnonzero(np.diff(log_time) < -_STEP_BACK) + 1 if back is None else back])
    if log_time.size < _SHORTEST * first.size:
        return order
    parts = np.split(np.arange(log_time.size), first[1:])
    spans = sorted((int(log_time[part].min()), int(log_time[part].max())) for part in parts)
    overlap = any(after[0] < before[1] - _STEP_BACK for before, after in zip(spans, spans[1:], strict=False))
    changes = np.count_nonzero(np.diff(np.searchsorted(first, order, side="right")))  # from one part to another, as time goes on
    if overlap and changes > 2 * (len(parts) - 1):
        return np.concatenate([part[np.argsort(log_time[part], kind="stable")] for part in parts])
    return order


def goes_on(log_time: np.ndarray, before: int) -> bool:
    """Whether log times, ns, int64[n], the first of them after ``before``, never step back nor go on more than `LONGEST_GAP` later."""
    return not _lost(np.concatenate([[before], log_time])).any()


def time_gone_by(log_time: np.ndarray) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Log times, ns, of messages in order of arrival, int64[n], that go on where the recorder's clock was set back, or left out so much
    time that it was set ahead, or nobody waits for what was recorded after it; where in these times that was, and how much, ns."""
    lost = _lost(log_time)
    gone_by = log_time - np.concatenate([np.zeros(min(log_time.size, 1), np.int64), np.cumsum(lost)])
    ahead = np.flatnonzero(lost > 0)
    return gone_by, list(zip(gone_by[ahead].tolist(), lost[ahead].tolist(), strict=True))


def _lost(log_time: np.ndarray) -> np.ndarray:
    """Steps between log times, ns, int64[n - 1], that are no time that is waited for; 0 for all others."""
    step = np.diff(log_time)
    return np.where((step < 0) | (step > to_ns(LONGEST_GAP)), step, 0)
