"""Stamps that are wrong: a few of a topic, far from all others of it and from those of all other topics.

A pause is none: what comes after it is many, or other topics went on meanwhile.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

FAR, SHARE = 60.0, 1e-3
"""s from all others of its topic, and share of these, at which a stamp is wrong and not a pause."""
_STEPS = 10.0  # usual steps of a topic, which a stamp must be off as well


def strays(stamps: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Whether each stamp is wrong, by topic, bool (n,), in any order; ``stamps`` in ns, int64 (n,)."""
    core = {topic: _core(stamp) for topic, stamp in stamps.items() if stamp.size}
    if not core:
        return {topic: np.zeros(stamp.size, bool) for topic, stamp in stamps.items()}
    far = round(FAR * 1e9)
    first, last = min(low for low, _ in core.values()) - far, max(high for _, high in core.values()) + far
    return {topic: ((stamp < core[topic][0]) & (stamp < first)) | ((stamp > core[topic][1]) & (stamp > last)) if stamp.size
            else np.zeros(0, bool) for topic, stamp in stamps.items()}


def _core(stamp: np.ndarray) -> tuple[int, int]:
    """First and last stamp, ns, of what is left without a few that lie far before or after all others."""
    time = np.sort(stamp)
    few, step = math.ceil(SHARE * time.size), np.diff(time)
    if time.size < 3:
        return int(time[0]), int(time[-1])
    leaps = np.flatnonzero(step > max(FAR * 1e9, _STEPS * float(np.median(step))))
    before = int(max((i + 1 for i in leaps if i < few), default=0))
    after = int(max((time.size - 1 - i for i in leaps if time.size - 1 - i <= few), default=0))
    return (int(time[before]), int(time[-1 - after])) if before + after < time.size else (int(time[0]), int(time[-1]))
