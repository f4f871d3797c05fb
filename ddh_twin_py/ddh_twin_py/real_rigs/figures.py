"""Root mean squares with what is known of their uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ddh_twin_py.gap.shrink.size import redrawn

_DRAWS = 400
_BLOCKS = 20


def rms(values: np.ndarray) -> float:
    """Root mean square, (n,) to a number."""
    return float(np.sqrt(np.mean(np.square(values))))


def interval(values: np.ndarray, blocks: int = _BLOCKS) -> tuple[float, float]:
    """95 % interval of the root mean square by a bootstrap of blocks that follow each other, see `size.redrawn`.

    Args:
        values: (n,), in their order. blocks: how many the record is cut into.
    """
    parts = np.array_split(np.square(values), blocks)
    square, count = np.array([p.sum() for p in parts]), np.array([p.size for p in parts])
    low, high = np.percentile(np.sqrt(redrawn(square, count, _DRAWS, np.random.default_rng(0))), [2.5, 97.5])
    return float(low), float(high)


def surely_smaller(before: Sequence[Mapping[str, np.ndarray]], after: Sequence[Mapping[str, np.ndarray]]) -> bool:
    """Whether residuals shrank beyond chance: the 2.5 % quantile of the shrink of their mean square is above 0.

    Each recording is cut into 20 blocks, and blocks are drawn with both residuals together (a paired block bootstrap).

    Args:
        before, after: by recording, signal to residuals in multiples of its noise, (n,), in their order.
    """
    shrink = []
    for one, other in zip(before, after, strict=True):
        parts = [np.array_split(np.square(one[name]) - np.square(other[name]), _BLOCKS) for name in one]
        shrink += [float(np.mean([np.mean(part) for part in several if part.size])) for several in zip(*parts, strict=True)
                   if any(part.size for part in several)]
    values = np.array(shrink)
    drawn = np.random.default_rng(0).integers(0, values.size, (_DRAWS, values.size))
    return bool(np.percentile(values[drawn].mean(axis=1), 2.5) > 0.0)
