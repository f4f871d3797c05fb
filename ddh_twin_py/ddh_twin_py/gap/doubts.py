"""What is doubtful about recordings themselves, said beside whatever a diagnosis finds."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording

_MOST = 6  # notes on one recording


def damage(recordings: Sequence[Recording]) -> list[str]:
    """What reading and screening found wrong so far that data are lost by it, such as a wrong unit."""
    return [finding.message for recording in recordings for finding in recording.findings if finding.severity == "error"]


def undeclared(recordings: Sequence[Recording], payload: float, matters: bool) -> list[str]:
    """That no usable payload was declared and what was assumed, kg; empty where all declare one.

    Args:
        matters: whether the load may be to blame. Where some declare one it matters anyway: what is assumed of the others is another's.
    """
    silent = [recording.path for recording in recordings if recording.rig is None or not isfinite(recording.rig.payload_mass)]
    if not matters and len(silent) == len(recordings):
        return []
    return [f"{', '.join(silent)}: no usable payload is declared, so that the rig file's {payload:g} kg was assumed"] if silent else []


def of_reference(recordings: Sequence[Recording], rig: Rig) -> list[str]:
    """A question where recordings that name their rig were held against the reference rig's sheet; none where a rig file was given."""
    named = next((r.rig.rig_id for r in recordings if r.rig is not None and r.rig.rig_id), "")
    return [] if rig.named or not named else [
        f"the recordings name {named} and were held against the reference rig's sheet; if {named} is another machine, give its rig file "
        "(--rig)"]


def doubts(recordings: Sequence[Recording]) -> list[str]:
    """What they warn of, what concerns a value first, at most `_MOST` for each recording, then how many more there are.

    What strikes few samples of a topic is counted in one note.
    """
    notes = []
    for recording in recordings:
        slight = recording.slight_findings()
        loud = sorted((f for f in recording.findings if f.severity == "warning" and f not in slight), key=lambda f: not f.field)
        notes += [finding.message for finding in loud[:_MOST]]
        if len(loud) > _MOST:
            notes.append(f"{recording.path}: {len(loud) - _MOST} further warnings; ddh-twin info lists them")
        if slight:
            most = max(slight, key=lambda f: (f.count, bool(f.field)))
            notes.append(f"{recording.path}: {len(slight)} slight warnings, of samples that are missing, late or repeated, at most "
                         f"{most.count} of {recording.samples()[most.topic]} of a topic; ddh-twin info lists them")
    return notes
