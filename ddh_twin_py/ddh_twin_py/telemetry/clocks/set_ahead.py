"""Where a clock was set ahead while the rod moved: stamps go on seconds later, and the rod where it was.

Messages that are lost leave the same hole, but the rod goes on meanwhile. Where it rests nothing tells one from the other, and little
depends on it.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.in_order import in_order
from ddh_twin_py.telemetry.recording import Finding, Recording, Stream
from ddh_twin_py.telemetry.signals import HYDRAULIC_TOPIC

_HOLE, _LONGEST = 0.25, 10.0  # s between two samples, from which a clock may have been set; up to which no rod is back where it was
_LONGER = 2.0  # times the usual time between two samples, which a hole is longer than, too
_ALIKE = 0.5  # share by which the rod's velocities before and after may differ
_SHORTEST = 0.02  # m that the rod would have gone meanwhile
_THERE = 0.005  # m from where it was that are next to nothing


def set_ahead(stream: Stream) -> np.ndarray:
    """Last stamp before the clock was set ahead, first one after, and by how much, s, (k, 3).

    Args:
        stream: of the hydraulics, sorted by time.
    """
    position, velocity = stream.column("rod_position"), stream.column("rod_velocity")
    known = in_order(stream.time, position + velocity)
    if known.size < 2:
        return np.empty((0, 3))
    begin, end = stream.time[known[:-1]], stream.time[known[1:]]
    one, other, went = velocity[known[:-1]], velocity[known[1:]], np.diff(position[known])
    usual, mean = float(np.median(end - begin)), 0.5 * (one + other)
    hole = (end - begin > max(_HOLE, _LONGER * usual)) & (end - begin < _LONGEST) & (np.abs(one - other) < _ALIKE * np.abs(mean))
    there = (np.abs(mean) * (end - begin) > _SHORTEST) & (np.abs(went - mean * usual) < _THERE)
    return np.column_stack([begin, end, end - begin - usual])[hole & there]


def clock_set_ahead(recording: Recording) -> list[Finding]:
    """A warning where that happened to the drive as well; a recording of which the clock was set back, too, is not looked at."""
    drive, stream, topic = recording.drive, recording.hydraulic, f"{recording.namespace}/{HYDRAULIC_TOPIC}"
    if drive is None or stream is None or np.any(np.diff(stream.time) < 0.0):
        return []
    steps = np.array([step for step in set_ahead(stream) if not np.any(np.abs(drive.time - step[:2].mean()) < 0.25 * step[2])])
    if not steps.size:
        return []
    (begin, end, by), times = steps[0], "" if len(steps) == 1 else f" {len(steps)} times, first"
    message = (f"{recording.path}: the clock was set ahead{times} by {by:.1f} s at {begin:.1f} s: {topic} has no stamp up to {end:.1f} s, "
               "and the rod, which moves, is where it was. Stamps are used as they stand; gap compares nothing fast from there until the "
               "rod was placed anew and moves on")
    return [Finding("warning", recording.path, topic, "header.stamp", float(by), len(steps), message, float(begin))]
