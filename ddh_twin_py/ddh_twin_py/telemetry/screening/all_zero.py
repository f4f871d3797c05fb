"""Topics that tell nothing but zeros: a node that is up while what it reads is not.

A drive that is switched off reads exactly zero, so zeros alone are no fault of it; a rod that moves meanwhile says that it is not.
Pressures and a rod's position have noise and are never exactly zero.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.recording import Finding, Recording, Stream
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC

_LEAST = 100  # samples that tell something
_MOVING = 0.01  # m, of a rod that moved
_TURNING = 1.0  # rad/s, of a shaft that turned


def all_zero(recording: Recording) -> dict[str, Finding]:
    """What is said of each of drive and hydraulics, relative topics, that is zero throughout; an error where the other one moves."""
    drive, hydraulic = recording.drive, recording.hydraulic
    found = {}
    if _zero(drive) and (moved := _range(hydraulic, "rod_position")) > _MOVING:
        found[DRIVE_TOPIC] = _finding(recording, DRIVE_TOPIC, drive, f"the rod moves by {moved:.3g} m meanwhile")
    if _zero(hydraulic):
        turned = _range(drive, "speed")
        found[HYDRAULIC_TOPIC] = _finding(
            recording, HYDRAULIC_TOPIC, hydraulic, f"the shaft's speed goes over {turned:.3g} rad/s meanwhile" if turned > _TURNING else "")
    return found


def _zero(stream: Stream | None) -> bool:
    return stream is not None and len(stream) >= _LEAST and not stream.values.any()


def _range(stream: Stream | None, name: str) -> float:
    """How far a field goes, 0 where nothing tells."""
    values = stream.column(name) if stream is not None else np.zeros(0)
    values = values[np.isfinite(values)]
    return float(np.ptp(values)) if values.size else 0.0


def _finding(recording: Recording, topic: str, stream: Stream, against: str) -> Finding:
    """``against``: what says that they are wrong, '' where nothing does and they are used."""
    where = f"{recording.namespace}/{topic}"
    then = f"{against}; not used" if against else "no sensor is so quiet, is it connected? They are used as they are"
    message = f"{recording.path}: {where}: all fields are exactly 0 in all {len(stream)} samples, and {then}"
    severity = "error" if against else "warning"
    return Finding(severity, recording.path, where, stream.fields[0], 0.0, len(stream), message, float(stream.time.min()))
