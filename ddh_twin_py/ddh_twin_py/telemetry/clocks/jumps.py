"""Why a recording is not one stretch of time, in words: whose stamps jump, how often, when and how far."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.names import first_of
from ddh_twin_py.telemetry.clocks.strays import strays
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.spans import apart
from ddh_twin_py.telemetry.ticks import LONGEST_GAP, REORDER_WINDOW, Ticks

_NAMED = 3  # topics that are named one by one


def why_apart(recording: Recording, ticks: Ticks) -> str:
    """How often the clock jumps, of some topics or of all, first when and how far, and which streams have no time in common.

    Args:
        ticks: of the recording, of which at least one is a restart.
    """
    first, origin = int(np.argmax(ticks.restart)), min(float(ticks.end_ns[0] - recording.epoch_ns) * 1e-9, 0.0)
    before, after = (float(ticks.end_ns[i] - recording.epoch_ns) * 1e-9 for i in (first - 1, first))
    before = max((float(s.time[s.time <= before].max(initial=-np.inf)) for _, s in recording.streams()), default=before)
    times, whose, by = int(ticks.restart.sum()), "the stamps", after - before
    jumps = {topic: jump for topic, stream in recording.streams() if len(stream) > 1 and (jump := _jump(stream.time))}
    if jumps:
        by, before, _ = _first_of(jumps)
    some = _of_some(recording, jumps)
    if some:
        topics, by, before = some
        named = first_of([f"{recording.namespace}/{topic}" for topic in topics], _NAMED)
        their = "its stamps" if len(topics) == 1 else "their stamps"
        whose = f"{named}: {their}, and those of no other topic,"
    said = (f"{recording.path}: {whose} jump {times} time{'s' * (times > 1)}, first by {by:+.1f} s at {before - origin:.1f} s; "
            "a free run needs one stretch of time")
    if wrong := _strays(recording):
        return f"{said} ({wrong}; leave out what has such stamps)"
    if some:
        return f"{said}, and one clock for all topics"
    strangers = apart(recording)
    return f"{said} ({strangers[0].message.removeprefix(f'{recording.path}: ')})" if strangers else f"{said}, cut the recording there"


def _strays(recording: Recording) -> str:
    """Topics of which a few stamps lie far before or after all their others, in words; '' where there are none."""
    said, streams = [], dict(recording.streams())
    for topic, wrong in strays({topic: stream.stamps(recording.epoch_ns) for topic, stream in streams.items()}).items():
        time = streams[topic].time
        for where, here in (("before", wrong & (time < np.median(time))), ("after", wrong & (time > np.median(time)))):
            if count := int(np.count_nonzero(here)):
                at = float(time[here].min() if where == "before" else time[here].max())
                stamps = f"{count} stamp{'s' * (count > 1)}"
                said.append(f"{recording.namespace}/{topic} has {stamps} far {where} all its others, at {at:.1f} s of the recording")
    return "; ".join(said)


def _first_of(jumps: dict[str, tuple[float, float, float]]) -> tuple[float, float, float]:
    """The first of jumps, as the densest topic tells it where several tell the same."""
    return min(jumps.values(), key=lambda jump: jump[1] + jump[2])


def _of_some(recording: Recording, jumps: dict[str, tuple[float, float, float]]) -> tuple[list[str], float, float] | None:
    """The topics whose stamps jump, by how many s and behind which stamp, s, the first does; None unless some do and others do not.

    The others are dense enough to show it, and go on where it is.
    """
    streams = {topic: stream.time for topic, stream in recording.streams() if len(stream) > 1}
    if not jumps or len(jumps) == len(streams):
        return None
    by, at, _ = _first_of(jumps)
    dense = (time for topic, time in streams.items() if topic not in jumps and np.median(np.diff(time)) < abs(by))
    return (list(jumps), by, at) if any(time[0] <= at < time[-1] for time in dense) else None


def _jump(time: np.ndarray) -> tuple[float, float, float] | None:
    """By how many s a topic's stamps jump first, beyond their usual step, behind which stamp, and that step, s; None where they do not."""
    step = np.diff(time)
    behind = np.maximum.accumulate(time)[:-1] - time[1:]
    jumps = (step > LONGEST_GAP) | (behind > REORDER_WINDOW)
    if not jumps.any():
        return None
    at, usual = int(np.argmax(jumps)), 0.0 if jumps.all() else float(np.median(step[~jumps]))
    return float(step[at]) - usual, float(time[at]), usual
