"""Sums over recordings with the model's allowances integrated out.

Every row belongs to at most one class that may be off, or to a signal with a few smooth curves,
so that they are integrated out exactly without ever standing in a matrix. Classes that several
recordings share are one flaw of the model, of which each stretch of a recording may show a variant.

With a the loads of a class in stretch r, s_r = a'a, V_r = a'X and variants of relative size w:
    P X'X -= w^2/(1 + w^2 s_r) V_r V_r'   for the variant,
    then   -= (sum_r u_r V_r)(sum_r u_r V_r)' / (1 + sum_r u_r s_r)   for what is shared, u_r = 1/(1 + w^2 s_r)
which is the matrix inversion lemma, twice.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_matrix

from ddh_twin_py.estimation.comparison import Block, Comparison
from ddh_twin_py.estimation.linear_gaussian import Gram

VARIANT = 1.0
"""Size of what a stretch of a recording has for itself in a shared class, over what is shared."""
STRETCH = 120.0
"""s; oil warms, and with it what the model's laws are off by."""


class Sums:
    """Sums over recordings of columns X (k) and values y; add recordings, then ask for the `Gram`."""

    def __init__(self, columns: int) -> None:
        self._products = np.zeros((columns + 1, columns + 1))
        self._shared: dict[tuple, tuple[np.ndarray, float]] = {}
        self._log_determinant = 0.0
        self._rows = 0

    def add(self, comparison: Comparison, columns: np.ndarray, values: np.ndarray, milder: dict[str, float] | None = None) -> None:
        """Add a recording.

        Args:
            columns: (rows, k) in the order of the comparison. values: (rows,).
            milder: signal to what its deviations are multiplied by.
        """
        for block in comparison.blocks:
            share = 1.0 / milder[block.signal] if milder else 1.0
            rows = np.hstack([share * columns[block.rows], share * values[block.rows, None]])
            self._products += rows.T @ rows
            self._rows += rows.shape[0]
            if block.curves is None:
                self._add_classes(block, rows)
            else:
                self._remove_curves(block.curves, rows)

    def _remove_curves(self, curves: np.ndarray, rows: np.ndarray) -> None:
        factor = cho_factor(curves.T @ curves + np.eye(curves.shape[1]), lower=True, check_finite=False)
        cross = curves.T @ rows
        self._products -= cross.T @ cho_solve(factor, cross, check_finite=False)
        self._log_determinant += 2.0 * float(np.sum(np.log(np.diagonal(factor[0]))))

    def _add_classes(self, block: Block, rows: np.ndarray) -> None:
        count = len(block.names)
        groups, group = np.unique(block.kind + count * (block.binning.time / STRETCH).astype(np.int64), return_inverse=True)
        loads = csr_matrix((block.load, (group, np.arange(group.size))), shape=(groups.size, group.size))
        cross = loads @ rows
        size = np.bincount(group, block.load**2, groups.size)
        share = 1.0 / (1.0 + VARIANT**2 * size)
        self._products -= cross.T @ (cross * (VARIANT**2 * share)[:, None])
        self._log_determinant -= float(np.sum(np.log(share)))
        kinds = csr_matrix((share, (groups % count, np.arange(groups.size))), shape=(count, groups.size))
        for name, row, own in zip(block.names, kinds @ cross, kinds @ size, strict=True):
            before = self._shared.get(name)
            self._shared[name] = (row, own) if before is None else (before[0] + row, before[1] + own)

    def gram(self) -> tuple[Gram, float]:
        """X'PX, X'Py, y'Py of all that was added, and the log determinant of the allowances."""
        products, log_determinant = self._products, self._log_determinant
        if self._shared:
            cross = np.array([row for row, _ in self._shared.values()])
            size = np.array([own for _, own in self._shared.values()])
            products = products - cross.T @ (cross / (1.0 + size)[:, None])
            log_determinant += float(np.sum(np.log1p(size)))
        return Gram(products[:-1, :-1], products[:-1, -1], float(products[-1, -1]), self._rows), log_determinant

    def classes(self, estimate: np.ndarray) -> dict[tuple, tuple[float, float]]:
        """Mean and variance of each shared class in units of its allowance, given the columns' estimate (k,)."""
        weights = np.append(-estimate, 1.0)
        return {name: (float(row @ weights) / (1.0 + own), 1.0 / (1.0 + own)) for name, (row, own) in self._shared.items()}


def sums_of(comparisons: Sequence[Comparison], columns: Sequence[np.ndarray], values: Sequence[np.ndarray],
            milder: Sequence[dict[str, float]] | None = None) -> Sums:
    """Sums over several recordings; see `Sums.add`."""
    total = Sums(columns[0].shape[1])
    for i, (comparison, x, y) in enumerate(zip(comparisons, columns, values, strict=True)):
        total.add(comparison, x, y, None if milder is None else milder[i])
    return total
