"""What is doubtful about recordings themselves, said beside whatever a diagnosis finds."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ddh_twin_py.telemetry.recording import Finding, Recording

_MOST = 6  # notes on one recording
_SLIGHT = 1.0e-3  # share of a topic's samples that a sensor may miss without harm


def damage(recordings: Sequence[Recording]) -> list[str]:
    """What reading and screening found wrong so far that data are lost by it, such as a wrong unit."""
    return [finding.message for recording in recordings for finding in recording.findings if finding.severity == "error"]


def doubts(recordings: Sequence[Recording]) -> list[str]:
    """What they warn of, what concerns a value first, at most `_MOST` for each recording, then how many more there are.

    Sensors that miss a sample here and there are counted in one note.
    """
    notes = []
    for recording in recordings:
        samples = {f"{recording.namespace}/{topic}": len(stream) for topic, stream in recording.streams()}
        found = sorted((f for f in recording.findings if f.severity == "warning"), key=lambda f: not f.field)
        slight = [f for f in found if _missed(f) and f.count <= _SLIGHT * samples.get(f.topic, 0)]
        loud = [f for f in found if f not in slight]
        notes += [finding.message for finding in loud[:_MOST]]
        if len(loud) > _MOST:
            notes.append(f"{recording.path}: {len(loud) - _MOST} further warnings; ddh-twin info lists them")
        if slight:
            most = max(slight, key=lambda f: f.count)
            notes.append(f"{recording.path}: single samples are NaN, at most {most.count} of {samples[most.topic]} of a signal, and left "
                         "out; ddh-twin info lists them")
    return notes


def _missed(finding: Finding) -> bool:
    """Whether samples are missing and nothing else."""
    return isinstance(finding.value, float) and math.isnan(finding.value)
