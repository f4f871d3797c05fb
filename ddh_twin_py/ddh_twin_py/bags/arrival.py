"""In which order the messages of a bag came, however they stand in its files, and at which times."""

from __future__ import annotations

import numpy as np

_STEP_BACK = 10**9  # ns by which a recorder's clock was set back, or a part of a file stands before another
_SHORTEST = 10  # messages between two steps back, on average, below which no clock was set back so often: the file is in no order


def order_of_arrival(log_time: np.ndarray, topic: np.ndarray) -> np.ndarray:
    """Indices of messages in order of arrival, int64[n], from the recorder's clock, ns, in the order of the file.

    Parts of a file may stand in any order, each as a whole in a gap of another. Where they tell the same time instead, the recorder's
    clock was set back between them, and they came as they stand. Topics (``topic`` int64[n] numbers them) that lag behind others, as where
    messages are recorded at their stamps, make no parts: their own times go on.
    """
    order = np.argsort(log_time, kind="stable")
    first = np.concatenate([[0], _steps_back(log_time, topic)])
    if log_time.size < _SHORTEST * first.size:
        return order
    parts = np.split(np.arange(log_time.size), first[1:])
    spans = sorted((int(log_time[part].min()), int(log_time[part].max())) for part in parts)
    overlap = any(after[0] < before[1] - _STEP_BACK for before, after in zip(spans, spans[1:], strict=False))
    changes = np.count_nonzero(np.diff(np.searchsorted(first, order, side="right")))  # from one part to another, as time goes on
    if overlap and changes > 2 * (len(parts) - 1):
        return np.concatenate([part[np.argsort(log_time[part], kind="stable")] for part in parts])
    return order


def _steps_back(log_time: np.ndarray, topic: np.ndarray) -> np.ndarray:
    """First message after each step back of the recorder's clock, int64[k]: where most is lost before a topic's own time is back.

    Most topics step back there; one alone has several publishers that lag unlike.
    """
    of_topic = np.argsort(topic, kind="stable")
    change = np.diff(log_time)
    fell = np.flatnonzero((np.diff(log_time[of_topic]) < -_STEP_BACK) & (np.diff(topic[of_topic]) == 0))
    spans = zip(of_topic[fell].tolist(), of_topic[fell + 1].tolist(), strict=True)
    first = np.unique(np.array([before + int(np.argmin(change[before:after])) + 1 for before, after in spans], np.int64))
    votes = np.zeros(first.size)
    for own in np.split(of_topic, np.flatnonzero(np.diff(topic[of_topic])) + 1):
        after = np.searchsorted(own, first)
        across = np.flatnonzero((after > 0) & (after < own.size))
        votes[across] += np.where(log_time[own[after[across]]] < log_time[own[after[across] - 1]], 1.0, -1.0)
    return first[votes > 0.0]


def time_gone_by(log_time: np.ndarray) -> np.ndarray:
    """Log times, ns, of messages in order of arrival, int64[n], that go on where the recorder's clock was set back."""
    if not log_time.size:
        return log_time
    return log_time + np.concatenate([[0], np.cumsum(np.maximum(log_time[:-1] - log_time[1:], 0))])
