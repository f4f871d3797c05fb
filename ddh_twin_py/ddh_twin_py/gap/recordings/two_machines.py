"""Two machines that publish on the same topics: a rod that is now here, now there."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.signals import HYDRAULIC_TOPIC

_LEAST = 100  # samples that tell something
_SOON = 1.0  # s within which a rod cannot be elsewhere
_FASTER, _ELSEWHERE = 2.0, 0.01  # times as far as either velocity says, and m beyond that, which no rod goes
_OFTEN = 0.1  # share of steps, from which these are no glitches


def two_machines(recording: Recording) -> str:
    """That a rod is at two places in turn, in one line; '' where it goes as fast as it says, or nothing tells.

    One that goes steadily faster than it says is in another unit; of that the direction, step by step, is the same. Samples are taken as
    they came: a clock that was set back lays one part of a recording over another.
    """
    stream = recording.hydraulic
    if stream is None or len(stream) < _LEAST:
        return ""
    position, velocity = stream.column("rod_position"), np.abs(stream.column("rod_velocity"))
    known = np.isfinite(position + velocity)
    if known.sum() < _LEAST:
        return ""
    time, position, velocity = stream.time[known], position[known], velocity[known]
    lasts, step = np.diff(time), np.diff(position)
    beyond = (lasts > 0.0) & (lasts < _SOON) & (np.abs(step) > _ELSEWHERE + _FASTER * np.maximum(velocity[1:], velocity[:-1]) * lasts)
    back = beyond[1:] & beyond[:-1] & (step[1:] * step[:-1] < 0.0)
    if np.mean(back) < _OFTEN:
        return ""
    at = int(np.argmax(back))
    return (f"{recording.path}: {recording.namespace}/{HYDRAULIC_TOPIC}: rod_position is {position[at]:.3f} m at {time[at]:.3f} s, "
            f"{position[at + 1]:.3f} m {lasts[at]:.3f} s later and {position[at + 2]:.3f} m next, and so in {np.mean(back):.0%} of "
            "all steps: two machines publish there, or two recordings are mixed; a case is of one rig")
