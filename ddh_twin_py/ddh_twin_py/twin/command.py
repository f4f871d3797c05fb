"""The speed command between its samples.

Drives are asked for ramps and plateaus. Sampled at 20 Hz, the corner of a ramp lies somewhere
between two samples; a straight line across it is off by up to a quarter of what the ramp does in
an interval, which oil springs answer with bars. Where the lines on both sides are each confirmed
by a further sample, the corner is where they meet.
"""

from __future__ import annotations

import numpy as np

LONGEST_BRIDGED = 0.5
"""s between samples beyond which nothing is said of the command between them."""
SLOWEST = 0.25
"""s between drive samples, from which a free run cannot follow the command: a step would come as a ramp."""
_SAME = 0.03  # of the steepest slope: two slopes that close are one line


def corners(time: np.ndarray, command: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Samples of a command with its corners put in.

    Args:
        time (s, increasing) and command (rad/s), (n,), all finite.

    Returns:
        time and command with the corners among them.
    """
    if time.size < 6:
        return time, command
    width = np.diff(time)
    slope = np.diff(command) / width
    same = _SAME * max(float(np.max(np.abs(slope))), 1e-9)
    i = np.arange(2, slope.size - 2)
    before, after = slope[i - 1], slope[i + 1]
    confirmed = (np.abs(before - slope[i - 2]) < same) & (np.abs(after - slope[i + 2]) < same) & (np.abs(before - after) > 3.0 * same)
    between = (np.abs(slope[i] - before) > same) & (np.abs(slope[i] - after) > same)
    with np.errstate(divide="ignore", invalid="ignore"):
        into = (command[i + 1] - command[i] - after * width[i]) / (before - after)
    found = confirmed & between & (into > 0.0) & (into < width[i]) & (width[i] < LONGEST_BRIDGED)
    place = i[found]
    return (np.insert(time, place + 1, time[place] + into[found]),
            np.insert(command, place + 1, command[place] + before[found] * into[found]))


def command_at(time: np.ndarray, command: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Command at ``edges`` (s, (m,)), rad/s, by samples in any order; 0 where none is within `LONGEST_BRIDGED`."""
    good = np.isfinite(command)
    time, command = time[good], command[good]
    if time.size == 0:
        return np.zeros(edges.size)
    time, first = np.unique(time, return_index=True)
    time, command = corners(time, command[first])
    value = np.interp(edges, time, command)
    following = np.clip(np.searchsorted(time, edges), 1, max(time.size - 1, 1))
    gap = np.minimum(np.abs(edges - time[following - 1]), np.abs(edges - time[np.minimum(following, time.size - 1)]))
    return np.where(gap <= LONGEST_BRIDGED, value, 0.0)
