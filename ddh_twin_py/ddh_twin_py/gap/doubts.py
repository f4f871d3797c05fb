"""What is doubtful about recordings themselves, said beside whatever a diagnosis finds."""

from __future__ import annotations

from collections.abc import Sequence

from ddh_twin_py.telemetry.recording import Finding, Recording

_MOST = 6  # notes on one recording


def doubts(recordings: Sequence[Recording]) -> list[str]:
    """What reading and screening found wrong, errors first, at most `_MOST` for each recording, then how many more there are."""
    notes = []
    for recording in recordings:
        found = sorted((f for f in recording.findings if f.severity != "info"), key=_rank)
        notes += [finding.message for finding in found[:_MOST]]
        if len(found) > _MOST:
            notes.append(f"{recording.path}: {len(found) - _MOST} further warnings; ddh-twin info lists them")
    return notes


def _rank(finding: Finding) -> tuple[bool, bool]:
    """Errors, then what concerns a value, then the rest."""
    return finding.severity != "error", not finding.field
