"""How every signal answers to every parameter: differences of free runs, and which of those taken elsewhere still hold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.comparison import Comparison
from ddh_twin_py.gap.model import Acting, Model

NEARBY = 0.5
"""Deviations of every parameter, within which sensitivities are not taken anew."""
_WEAK = 1.0


@dataclass(frozen=True)
class Taken:
    """Sensitivities to the parameters as they were taken somewhere.

    Attributes:
        theta: parameters there, in deviations, (k,). comparisons, slopes: by recording, (rows, k); there may be further recordings, of
            which nothing was taken. information: what the recordings told there of each parameter, in squared deviations, (k,).
    """

    theta: np.ndarray
    comparisons: Sequence[Comparison]
    slopes: Sequence[np.ndarray]
    information: np.ndarray

    def near(self, theta: np.ndarray) -> bool:
        """Whether they hold for parameters (k,)."""
        return bool(np.abs(theta - self.theta).max() < NEARBY)

    def beside(self, number: int, comparison: Comparison) -> np.ndarray | None:
        """Sensitivities of one recording in the deviations of another comparison, (rows, k); None where none were taken."""
        if number >= len(self.slopes):
            return None
        return self.slopes[number] * (self.comparisons[number].spread / comparison.spread)[:, None]

    def strong(self, model: Model) -> np.ndarray:
        """Parameters of which the recordings tell more than their tolerance does, or may elsewhere, (k,): of others, which move all
        data together by less than one deviation, it makes no difference where their sensitivities were taken."""
        strong = self.information >= _WEAK
        strong[list(model.thresholds)] = True
        return strong


def slopes_of(model: Model, pool: ThreadPoolExecutor, theta: np.ndarray, comparisons: Sequence[Comparison], numbers: Sequence[int],
              progress: Callable[[float], None] | None = None, acting: Acting = (),
              beside: Sequence[np.ndarray | None] = (), wanted: np.ndarray | None = None) -> list[np.ndarray]:
    """Differences of features by every deviation, of some recordings, (rows, k) each.

    Args:
        theta: parameters, in deviations, (k,). comparisons: of every recording. numbers: the recordings. progress: told the share done.
        acting: effects. beside: by recording of ``numbers``, taken elsewhere, (rows, k) or None.
        wanted: parameters that are taken anew, (k,), of recordings of which there are others; None: all.
    """
    steps = np.where(theta > 0.0, -model.difference, model.difference)
    kept = dict(zip(numbers, beside, strict=True)) if len(beside) else {}
    anew = [i for i in range(model.size) if wanted is None or wanted[i]]

    def features(at: np.ndarray, own: Sequence[int]) -> list[np.ndarray]:
        return [comparisons[number].features(model.run_one(number, at, acting)) for number in own]

    def column(i: int) -> list[np.ndarray]:
        moved = theta.copy()
        moved[i] += steps[i]
        return features(moved, of_column[i])

    whole = [number for number in numbers if kept.get(number) is None]
    of_column = {i: list(numbers) if i in set(anew) else whole for i in range(model.size)}
    of_column = {i: own for i, own in of_column.items() if own}
    base = dict(zip(numbers, features(theta, numbers), strict=True))
    out = {number: np.empty((comparisons[number].size, model.size)) if number in whole else kept[number].copy() for number in numbers}
    for done, (i, columns) in enumerate(zip(of_column, pool.map(column, of_column), strict=True), 1):
        for number, moved in zip(of_column[i], columns, strict=True):
            out[number][:, i] = (moved - base[number]) / steps[i]
        if progress is not None:
            progress(done / len(of_column))
    return [out[number] for number in numbers]
