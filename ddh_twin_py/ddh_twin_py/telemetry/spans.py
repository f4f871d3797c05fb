"""How the streams of a recording lie in time: strangers to each other, late beginnings, early ends."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.recording import Finding, Recording

_APART = 1.0  # s between two streams that have nothing in common
_LEAST_SPAN = 10.0  # s of a stream that must share
_LEAST_SHARE = 0.5  # of its time with the others
_SILENT, _SILENT_STEPS = 5.0, 10.0  # s, and usual steps of its own, from which a stream is missing at an end


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
        seconds = common[topic][against]
        if seconds is None:
            continue
        name, other = (f"{recording.namespace}/{t}" for t in (topic, against))
        overlap = "no time" if seconds <= 0.0 else f"only {seconds:.1f} s"
        message = (
            f"{recording.path}: {name} spans {span[0]:.1f} to {span[1]:.1f} s, {other} {spans[against][0]:.1f} to "
            f"{spans[against][1]:.1f} s: they have {overlap} in common; do their clocks differ?"
        )
        findings.append(Finding("warning", recording.path, name, "", span[0], 1, message, span[0]))
    return findings


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
