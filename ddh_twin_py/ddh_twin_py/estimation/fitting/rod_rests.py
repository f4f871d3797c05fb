"""Where a rod rested, by positions that a sensor read: at standstills, and of its end stops."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ddh_twin_py.rig import Rig

_LEANING = 8  # times as far as a position its slope is told
_FEW = 4  # positions that tell no slope
_CLEAR = 2.0e-3  # m from an end stop that a rod must keep to have never met it
_PAST = 1.0  # m that a run may go past such a stop


def smoothed(position: np.ndarray, reach: int) -> np.ndarray:
    """Each standstill's positions by those of ``reach`` intervals to either side, NaN where it moves.

    A heavy rod sinks at rest by millimetres a second. Where a standstill begins or ends its neighbours lie to one side, and their mean
    would be that much off: it is moved along the slope of a line through `_LEANING` times as many, which adds little noise.
    """
    known = np.isfinite(position)
    index = np.arange(position.size)
    begun = np.maximum.accumulate(np.where(known, 0, index + 1))
    ended = np.minimum.accumulate(np.where(known, position.size, index)[::-1])[::-1]
    since, value = np.where(known, index - begun, 0.0), np.where(known, position, 0.0)

    def means(reach: int, *values: np.ndarray) -> Iterator[np.ndarray]:
        first, last = np.maximum(begun, index - reach), np.minimum(ended, index + reach + 1)
        for each in values:
            total = np.concatenate([[0.0], np.cumsum(each)])
            yield (total[last] - total[first]) / np.maximum(last - first, 1)

    level, middle, product, square = means(_LEANING * reach, value, since, since * value, since**2)
    steep = np.where(ended - begun > _FEW, (product - middle * level) / np.maximum(square - middle**2, 1e-12), 0.0)
    level, middle = means(reach, value, since)
    return np.where(known, level + steep * (since - middle), np.nan)


def never_met(position: np.ndarray, rig: Rig) -> dict[str, float]:
    """How far (m) a run may go past either end, by the mean positions (m) that were measured."""
    known = position[np.isfinite(position)]
    if not known.size:
        return {"retracted": 0.0, "extended": 0.0}
    return {"retracted": _PAST * (known.min() > _CLEAR), "extended": _PAST * (known.max() < rig["cylinder.stroke"] - _CLEAR)}
