"""Root mean squares with what is known of their uncertainty."""

from __future__ import annotations

import numpy as np

_DRAWS = 400


def rms(values: np.ndarray) -> float:
    """Root mean square, (n,) to a number."""
    return float(np.sqrt(np.mean(np.square(values))))


def interval(values: np.ndarray, blocks: int = 20) -> tuple[float, float]:
    """95 % interval of the root mean square by a bootstrap of blocks that follow each other.

    Künsch, The jackknife and the bootstrap for general stationary observations, Ann. Stat. 17 (1989).

    Args:
        values: (n,), in their order. blocks: how many the record is cut into.
    """
    parts = np.array_split(np.square(values), blocks)
    square, count = np.array([p.sum() for p in parts]), np.array([p.size for p in parts])
    drawn = np.random.default_rng(0).integers(0, blocks, (_DRAWS, blocks))
    found = np.sqrt(square[drawn].sum(axis=1) / count[drawn].sum(axis=1))
    low, high = np.percentile(found, [2.5, 97.5])
    return float(low), float(high)
