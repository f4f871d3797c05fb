"""How every signal answers to every parameter of a rig: differences of free runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Comparison
from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.model import Model


def slopes_of(model: Model, pool: ThreadPoolExecutor, theta: np.ndarray, comparisons: Sequence[Comparison], numbers: Sequence[int],
              progress: Callable[[float], None] | None = None, acting: Acting = (), roughly: bool = False) -> list[np.ndarray]:
    """Differences of features by every deviation, of the recordings ``numbers``, (rows, k) each.

    Args:
        theta: parameters, in deviations, (k,). comparisons: of every recording. progress: told the share done. acting: effects.
        roughly: see `Model.run_one`.
    """
    steps = np.where(theta > 0.0, -model.difference, model.difference)

    def features(at: np.ndarray) -> list[np.ndarray]:
        return [comparisons[number].features(model.run_one(number, at, acting, roughly=roughly)) for number in numbers]

    def column(i: int) -> list[np.ndarray]:
        moved = theta.copy()
        moved[i] += steps[i]
        return features(moved)

    base, out = pool.submit(features, theta), [np.empty((comparisons[number].size, model.size)) for number in numbers]
    for i, moved in enumerate(pool.map(column, range(model.size))):
        for rows, m, b in zip(out, moved, base.result(), strict=True):
            rows[:, i] = (m - b) / steps[i]
        if progress is not None:
            progress((i + 1) / model.size)
    return out
