"""A quadratic whose unknowns have bounds: where it is lowest within them, and the volume under its exponential.

A rig's tolerances end: a parameter at the end of its tolerance goes no further, whatever a recording would like. A
Gaussian would let it, at a price, and hide a large effect in it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.special import erfcx, ndtr

from ddh_twin_py.estimation.fitting.linear_gaussian import factored, solved

_ROUNDS = 200


def lowest_point(matrix: np.ndarray, slope: np.ndarray, start: np.ndarray, lowest: np.ndarray, highest: np.ndarray) -> np.ndarray:
    """Where u' M u / 2 - slope' u is lowest within bounds, (n,).

    Projected Newton steps on the unknowns that no bound holds (Bertsekas, SIAM J. Control Optim. 20, 1982); where such a
    step does not descend, it ends at the first bound that it meets.

    Args:
        matrix: M, positive definite, (n, n). slope: (n,). start: (n,). lowest, highest: (n,).
    """
    u = np.clip(start, lowest, highest)
    done = None  # the unknowns that were free when a step went its whole way: the lowest point of those
    for _ in range(_ROUNDS):
        gradient = matrix @ u - slope
        free = ~(((u <= lowest) & (gradient > 0.0)) | ((u >= highest) & (gradient < 0.0)))
        if not free.any() or (done is not None and np.array_equal(free, done)):
            break
        while True:  # what rests on a bound and would go through it stays
            step = np.zeros(u.size)
            index = np.flatnonzero(free)
            step[index] = solved(factored(matrix[index[:, None], index]), -gradient[index])
            through = ((u <= lowest) & (step < 0.0)) | ((u >= highest) & (step > 0.0))
            if not through.any():
                break
            free &= ~through
        aim = u + step
        inside = np.clip(aim, lowest, highest)
        move, done = inside - u, free if np.array_equal(inside, aim) else None
        if gradient @ move + 0.5 * move @ matrix @ move >= 0.0:
            with np.errstate(divide="ignore", invalid="ignore"):
                reach = np.where(step > 0.0, (highest - u) / step, np.where(step < 0.0, (lowest - u) / step, np.inf))
            first = int(np.argmin(reach))
            move = min(1.0, float(reach[first])) * step
            if reach[first] < 1.0:
                move[first] = (highest if step[first] > 0.0 else lowest)[first] - u[first]
        u = np.clip(u + move, lowest, highest)
    return u


@dataclass(frozen=True)
class Held:
    """Columns beside shared unknowns of which some are held by their bounds and the others integrated out.

    Attributes:
        information, score: of the columns, (m, m) and (m,). chi_square: where no column departs.
        log_volume: of the shared unknowns about their optimum. shared: the optimum, (k,). departure: of the columns there, (m,).
        lowest: chi-square and priors there.
    """

    information: np.ndarray
    score: np.ndarray
    chi_square: float
    log_volume: float
    shared: np.ndarray
    departure: np.ndarray
    lowest: float


@dataclass(frozen=True)
class Normal:
    """Sums of shared unknowns t within bounds and of columns x: chi-square is t'At - 2 a't + 2 t'Cx + x'Dx - 2 d'x + q.

    Attributes:
        information, score: A (k, k), the prior in it, and a (k,). cross: C (k, m). own, own_score: D (m, m) and d (m,).
        square: q. lowest, highest: bounds of the shared unknowns, (k,).
    """

    information: np.ndarray
    score: np.ndarray
    cross: np.ndarray
    own: np.ndarray
    own_score: np.ndarray
    square: float
    lowest: np.ndarray
    highest: np.ndarray
    _known: dict[bytes, tuple] = field(default_factory=dict, init=False, repr=False, compare=False)

    def held(self, chosen: np.ndarray, room: np.ndarray, width: float, start: np.ndarray | None = None) -> Held:
        """Some of the columns.

        Args:
            chosen: indices, (m,). room: how far each may depart, (m,); none departs backwards. width: of their prior.
            start: shared unknowns near the optimum, (k,).
        """
        k, m = self.score.size, chosen.size
        cross, own, own_score = self.cross[:, chosen], self.own[np.ix_(chosen, chosen)], self.own_score[chosen]
        matrix = self._together(cross, own, width)
        slope = np.concatenate([self.score, own_score])
        lowest, highest = np.concatenate([self.lowest, np.zeros(m)]), np.concatenate([self.highest, np.maximum(room, 0.0)])
        begin = np.concatenate([np.zeros(k) if start is None else start, np.zeros(m)])
        u = lowest_point(matrix, slope, begin, lowest, highest)
        gradient = (matrix @ u - slope)[:k]
        t = u[:k]
        at_end = ((t <= self.lowest) & (gradient > 0.0)) | ((t >= self.highest) & (gradient < 0.0))
        lowest_value = self.square - float((slope - 0.5 * matrix @ u) @ u) * 2.0
        return self._integrated(t, at_end, np.abs(gradient), cross, own, own_score, u[k:], lowest_value)

    def covariance(self, width: float) -> np.ndarray:
        """Of the shared unknowns and all columns together, (k + m, k + m), bounds left out; ``width``: of the columns' prior."""
        matrix = self._together(self.cross, self.own, width)
        return solved(factored(matrix), np.eye(matrix.shape[0]))

    def _together(self, cross: np.ndarray, own: np.ndarray, width: float) -> np.ndarray:
        """Information of the shared unknowns and of columns with their prior, (k + m, k + m)."""
        k, m = cross.shape
        out = np.empty((k + m, k + m))
        out[:k, :k], out[:k, k:], out[k:, :k] = self.information, cross, cross.T
        out[k:, k:] = own + np.eye(m) / width**2
        return out

    def _integrated(self, t, at_end, steep, cross, own, own_score, departure, value) -> Held:
        free = ~at_end
        fixed = t[at_end]
        mixed = self.information[np.ix_(free, at_end)]
        score = self.score[free] - mixed @ fixed
        aside = own_score - cross[at_end].T @ fixed
        square = self.square - 2.0 * self.score[at_end] @ fixed + fixed @ self.information[np.ix_(at_end, at_end)] @ fixed
        factor, spread = self._alone(free)
        m = departure.size
        by_all = solved(factor, np.column_stack([cross[free], score, mixed]))
        by_columns, by_score, by_mixed = by_all[:, :m], by_all[:, m], by_all[:, m + 1 :]
        stiff = np.maximum(np.diagonal(self.information)[at_end] - np.sum(mixed * by_mixed, axis=0), 1e-12)
        inside = ndtr((self.highest[free] - t[free]) / spread) - ndtr((self.lowest[free] - t[free]) / spread)
        log_volume = (-float(np.sum(np.log(np.diagonal(factor)))) + float(np.sum(np.log(np.maximum(inside, 1e-300))))
                      + float(np.sum(np.log(0.5 * erfcx(steep[at_end] / np.sqrt(2.0 * stiff))) - 0.5 * np.log(stiff))))
        return Held(own - cross[free].T @ by_columns, aside - cross[free].T @ by_score, float(square - score @ by_score), log_volume, t,
                    departure, value)

    def _alone(self, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Factor of A of the unknowns that no bound holds, and their deviations; the same for most sets of columns."""
        if free.tobytes() not in self._known:
            factor = factored(self.information[np.ix_(free, free)])
            inverse = solved(factor, np.eye(int(free.sum())))
            self._known[free.tobytes()] = factor, np.sqrt(np.diagonal(inverse))
        return self._known[free.tobytes()]
