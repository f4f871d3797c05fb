"""What is said of a recording in which the free run lost its command."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fusion.catch_up import MISSED
from ddh_twin_py.telemetry.recording import Finding, Recording
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC
from ddh_twin_py.twin.intervals import HOLD


def moved_on(off: np.ndarray, taken_up: np.ndarray) -> np.ndarray:
    """Where a run was off and had to be taken up, or never was, bool (n,): the rod that it did not know of did not rest.

    Args:
        off, taken_up: of `HydraulicResult`, (n,) each.
    """
    first, stop = _stretches(off)
    moved = np.zeros(off.size, bool)
    for begin, end in zip(first, stop, strict=True):
        moved[begin:end] = end == off.size or taken_up[end]
    return moved


def off_course(recording: Recording, time: np.ndarray, off: np.ndarray, interval: float) -> list[Finding]:
    """A warning of the times at which no command was known and the machine moved on; none where no command is told at all.

    Args:
        time: s, ends of the intervals, (n,). off: see `moved_on`, (n,). interval: s.
    """
    if not off.any() or recording.drive is None or not np.isfinite(recording.drive.column("speed_command")).any():
        return []
    first, stop = _stretches(off)
    told = np.sort(recording.drive.time[np.isfinite(recording.drive.column("speed_command"))])
    last = told[np.maximum(np.searchsorted(told, time[first]) - 1, 0)]  # the clock may have jumped
    begin, end = np.clip(last, time[first] - interval - HOLD, time[first] - HOLD), time[stop - 1]
    seconds, topic = float((end - begin).sum()), f"{recording.namespace}/{DRIVE_TOPIC}"
    when = f"from {begin[0]:.1f} to {end[0]:.1f} s"
    much = when if first.size == 1 else f"{first.size} times, for {seconds:.1f} s in all, first {when}"
    back = "" if stop[-1] == off.size else " and is taken up again from what was measured"
    message = (f"{recording.path}: {topic}: no speed_command is known {much}, and the machine moved on: the free run was off{back}; the "
               "temperatures that it predicts lack the heat of that time for minutes")
    if np.any(end - begin > MISSED + HOLD):
        message += f", or until they are brought back to what is fused or read, after {MISSED:g} s of it or more"
    return [Finding("warning", recording.path, topic, "speed_command", seconds, int(first.size), message, float(begin[0]))]


def _stretches(off: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First of each stretch of true values, and the one behind it, int (m,) each."""
    edge = np.diff(off.astype(np.int8), prepend=0, append=0)
    return np.flatnonzero(edge > 0), np.flatnonzero(edge < 0)
