"""How the streams of a recording lie in time: strangers to each other, late beginnings, early ends."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.recording import Finding, Recording

_APART = 1.0  # s between two streams that have nothing in common
_LEAST_SPAN = 10.0  # s of a stream that must share
_LEAST_SHARE = 0.5  # of its time with the others
_SILENT, _SILENT_STEPS = 5.0, 10.0  # s, and usual steps of its own, from which a stream is missing at an end
UNSTAMPED = "all stamps are 0: nobody set header.stamp"
_ALIKE = 1.0  # s by which begin and end may be off one another where a clock is set off


def too_short(recording: Recording, topic: str, least: float) -> str:
    """How long a topic of a recording lasts where that is less than so many s, in one line, with why where it tells; else ''."""
    stream = dict(recording.streams()).get(topic)
    lasts = float(np.ptp(stream.time)) if stream is not None and len(stream) else 0.0
    if lasts >= least:
        return ""
    why = f", as {UNSTAMPED}" if recording.epoch_ns == 0 and recording.duration == 0.0 else ""
    return f"{recording.path}: {recording.namespace}/{topic} lasts {lasts:.2g} s{why}; at least {least:g} s are needed"


def apart(recording: Recording) -> list[Finding]:
    """Streams that have no time, or little of theirs, in common with the one that most others go with."""
    spans = {topic: (float(s.time.min()), float(s.time.max())) for topic, s in recording.streams() if len(s)}
    common = {topic: {other: _shared(span, spans[other]) for other in spans} for topic, span in spans.items()}
    if all(share is None for shares in common.values() for share in shares.values()):
        return []
    # the first of those with the fewest strangers: the drive, where opinions are equal
    against = min(spans, key=lambda topic: sum(share is not None for share in common[topic].values()))
    findings = []
    for topic, span in spans.items():
        if common[topic][against] is not None:
            message = _strangers(recording, topic, span, against, spans[against])
            findings.append(Finding("warning", recording.path, f"{recording.namespace}/{topic}", "", span[0], 1, message, span[0]))
    return findings


def strangers(recording: Recording, one: str, other: str) -> str:
    """That two topics have no time, or little of theirs, in common, in one line; '' where they do or one of them is empty."""
    times = [stream.time for topic, stream in recording.streams() if topic in (one, other) and len(stream)]
    if len(times) < 2:
        return ""
    spans = [(float(time.min()), float(time.max())) for time in times]
    return "" if _shared(*spans) is None else _strangers(recording, one, spans[0], other, spans[1])


def _strangers(recording: Recording, one: str, span: tuple[float, float], other: str, against: tuple[float, float]) -> str:
    seconds = _shared(span, against)
    overlap = "no time" if seconds <= 0.0 else f"only {seconds:.1f} s"
    return (f"{recording.path}: {recording.namespace}/{one} spans {span[0]:.1f} to {span[1]:.1f} s, {recording.namespace}/{other} "
            f"{against[0]:.1f} to {against[1]:.1f} s: they have {overlap} in common; do their clocks differ?")


def set_off(one: np.ndarray, other: np.ndarray) -> float | None:
    """By how many s the times of one stream, s, lie after those of another, where begin and end say so alike; None where they do not."""
    begin, end = float(one.min() - other.min()), float(one.max() - other.max())
    return 0.5 * (begin + end) if abs(begin) > _SILENT and abs(begin - end) < _ALIKE else None


def _shared(a: tuple[float, float], b: tuple[float, float]) -> float | None:
    """Seconds that two spans have in common where that is oddly little, else None."""
    seconds = min(a[1], b[1]) - max(a[0], b[0])
    shorter = min(a[1] - a[0], b[1] - b[0])
    odd = seconds < -_APART or (shorter >= _LEAST_SPAN and seconds < _LEAST_SHARE * shorter)
    return seconds if odd else None


def missing_ends(recording: Recording) -> list[Finding]:
    """Streams that begin well after the recording or end well before it, as where a sensor's cable broke or a node died."""
    first, last = recording.span
    findings = []
    for topic, stream in recording.streams():
        if not len(stream):
            continue
        time = np.sort(stream.time)
        least = max(_SILENT, _SILENT_STEPS * float(np.median(np.diff(time)))) if time.size > 1 else _SILENT
        name = f"{recording.namespace}/{topic}"
        for silent, said, at, edge in ((time[0] - first, "begins", time[0], "after its begin"),
                                       (last - time[-1], "ends", time[-1], "before its end")):
            if silent > least:
                message = (f"{recording.path}: {name} {said} at {at:.1f} s of the recording, {silent:.1f} s {edge}: nothing is known of it "
                           "there")
                findings.append(Finding("warning", recording.path, name, "", float(at), 1, message, float(at)))
    return findings
