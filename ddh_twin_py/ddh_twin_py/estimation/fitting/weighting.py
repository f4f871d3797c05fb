"""Weights of residuals once the model's allowances are integrated out: P = (I + A A')^-1, without ever forming it.

A holds what the model is forgiven (see `comparison`): loads of classes that may be off together, a
variant of each per stretch, and smooth curves of temperatures. Rows of unit variance. Every row belongs to
at most one class, or to a signal with a few smooth curves. Classes that several recordings share
are one flaw of the model, of which each stretch of a recording may show a variant.

With a the loads of a class in stretch r, s_r = a'a, V_r = a'X and variants of relative size w:
    X'PX = X'X - sum_r u_r w^2 V_r V_r'   for the variants, u_r = 1/(1 + w^2 s_r),
    then   - (sum_r u_r V_r)(sum_r u_r V_r)' / (1 + sum_r u_r s_r)   for what is shared,
which is the matrix inversion lemma, twice.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_matrix

from ddh_twin_py.estimation.fitting.comparison import Block, Comparison

VARIANT = 1.0
"""Size of what a stretch of a recording has for itself in a shared class, over what is shared."""
STRETCH = 120.0
"""s; oil warms, and with it what the model's laws are off by."""
_AT_ONCE = 32  # columns that are weighed at once; all of them of half an hour would be a further copy of hundreds of megabytes


class Weighting:
    """P of several recordings that share their classes.

    Args:
        comparisons: one per recording.

    Attributes:
        log_determinant: of I + A A'. rows: of all recordings.
    """

    def __init__(self, comparisons: Sequence[Comparison]) -> None:
        self.rows = sum(c.size for c in comparisons)
        self.log_determinant = 0.0
        self._sizes = [c.size for c in comparisons]
        self._curves: list[tuple[int, slice, np.ndarray, tuple]] = []
        self._groups: list[tuple[int, slice, csr_matrix, np.ndarray, np.ndarray]] = []
        names: dict[tuple, int] = {}
        shared: dict[int, float] = {}
        for number, comparison in enumerate(comparisons):
            for block in comparison.blocks:
                if block.curves is not None:
                    factor = cho_factor(block.curves.T @ block.curves + np.eye(block.curves.shape[1]), lower=True, check_finite=False)
                    self.log_determinant += 2.0 * float(np.sum(np.log(np.diagonal(factor[0]))))
                    self._curves.append((number, block.rows, block.curves, factor))
                else:
                    self._take(number, block, names, shared)
        self._names = list(names)
        self._gathering = [csr_matrix((share, (which, np.arange(which.size))), shape=(len(names), which.size))
                           for _, _, _, share, which in self._groups]
        self._shared = np.array([shared[i] for i in range(len(names))])
        self.log_determinant += float(np.sum(np.log1p(self._shared)))

    def _take(self, number: int, block: Block, names: dict[tuple, int], shared: dict[int, float]) -> None:
        """Groups of a block: a class within a stretch of the recording."""
        count = len(block.names)
        groups, group = np.unique(block.kind + count * (block.binning.time / STRETCH).astype(np.int64), return_inverse=True)
        loads = csr_matrix((block.load, (group, np.arange(group.size))), shape=(groups.size, group.size))
        size = np.bincount(group, block.load**2, groups.size)
        share = 1.0 / (1.0 + VARIANT**2 * size)
        self.log_determinant -= float(np.sum(np.log(share)))
        which = np.array([names.setdefault(block.names[kind], len(names)) for kind in groups % count], dtype=np.int64)
        for i, s in zip(which, share * size, strict=True):
            shared[int(i)] = shared.get(int(i), 0.0) + float(s)
        self._groups.append((number, block.rows, loads, share, which))

    def applied(self, columns: Sequence[np.ndarray]) -> list[np.ndarray]:
        """P times columns, given and returned by recording, (rows, k) each."""
        out = [np.array(c, dtype=np.float64) for c in columns]
        for number, rows, curves, factor in self._curves:
            out[number][rows] -= curves @ cho_solve(factor, curves.T @ columns[number][rows], check_finite=False)
        if not self._groups:
            return out
        loaded = self._loaded(columns)
        total = self._in_classes(loaded)
        for own, (number, rows, loads, share, which) in zip(loaded, self._groups, strict=True):
            out[number][rows] -= loads.T @ (_rowwise(VARIANT**2 * share, own) + _rowwise(share, total[which]))
        return out

    def _loaded(self, columns: Sequence[np.ndarray]) -> list[np.ndarray]:
        """What columns make in every stretch of the classes of each block, (groups, k)."""
        return [loads @ columns[number][rows] for number, rows, loads, _, _ in self._groups]

    def _in_classes(self, loaded: Sequence[np.ndarray]) -> np.ndarray:
        """What columns, as `_loaded`, say of the shared classes, in units of their allowance, (classes, k)."""
        return _rowwise(1.0 / (1.0 + self._shared), sum(gather @ own for gather, own in zip(self._gathering, loaded, strict=True)))

    def classes(self, residuals: Sequence[np.ndarray]) -> dict[tuple, tuple[float, float]]:
        """Mean and variance of each shared class in units of its allowance, given residuals by recording, (rows,)."""
        mean = self._in_classes(self._loaded(residuals)) if self._groups else np.zeros(0)
        return {name: (float(m), 1.0 / (1.0 + s)) for name, m, s in zip(self._names, mean, self._shared, strict=True)}

    def in_parts(self, columns: Sequence[np.ndarray]) -> Iterator[list[np.ndarray]]:
        """P times columns, given by recording, (rows, m), and told by recording, (rows, k), a few after the other."""
        for at in range(0, max(columns[0].shape[1], 1), _AT_ONCE):
            yield self.applied([c[:, at : at + _AT_ONCE] for c in columns])

    def products(self, left: Sequence[np.ndarray], right: Sequence[np.ndarray]) -> np.ndarray:
        """left' P right, summed over recordings; ``right`` should be the narrower."""
        return np.hstack([sum(a.T @ b for a, b in zip(left, weighted, strict=True)) for weighted in self.in_parts(right)])


def _rowwise(factor: np.ndarray, rows: np.ndarray) -> np.ndarray:
    return factor.reshape(-1, *([1] * (rows.ndim - 1))) * rows
