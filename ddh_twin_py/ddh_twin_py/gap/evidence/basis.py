"""The unknowns that every hypothesis shares, and sums of anything else with them integrated out.

    y = J theta + S s + C x + e,   theta ~ N(0, I),  s ~ N(0, I),  e ~ N(0, P^-1)

theta are the rig's parameters in deviations of their tolerances, S the slack of the model's laws,
C the columns of a hypothesis. J and S are sensitivities at one place and stay; y and C change from
hypothesis to hypothesis and cost a few products.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ddh_twin_py.estimation.fitting.weighting import Weighting
from ddh_twin_py.gap.evidence.box import Normal
from ddh_twin_py.gap.evidence.pieces import Pieces, Rows


@dataclass(frozen=True)
class Sums:
    """Sums with the shared unknowns integrated out: X'PX (m, m), X'Py (m,), y'Py."""

    information: np.ndarray
    score: np.ndarray
    chi_square: float


class Basis:
    """Parameters and slack of a case at one place.

    Args:
        weighting: of the recordings. parameters, slack: columns by recording, (rows, k) and (rows, m).
        lowest, highest: bounds of the parameters, in deviations, (k,).
        power: to which the likelihood is raised; below 1 where the model's laws are not quite the rig's.
    """

    def __init__(self, weighting: Weighting, parameters: Rows, slack: Rows, lowest: np.ndarray, highest: np.ndarray,
                 power: float = 1.0) -> None:
        self.weighting, self.power, self.lowest, self.highest = weighting, power, lowest, highest
        self._of_rig, self._of_laws = Pieces([parameters]), Pieces([slack])
        of_rig = np.hstack([self._all(weighted) for weighted in weighting.in_parts(parameters)])
        of_laws = np.hstack([self._of_laws.against(weighted) for weighted in weighting.in_parts(slack)])
        self.information = power * np.hstack([of_rig, np.vstack([of_rig[self.parameters :].T, of_laws])])
        self._prepare()

    @property
    def parameters(self) -> int:
        """Unknowns that have bounds: parameters, and what stands behind them."""
        return self._of_rig.size

    @property
    def size(self) -> int:
        """Of all shared unknowns, slack too."""
        return self._of_rig.size + self._of_laws.size

    def _all(self, weighted: Rows) -> np.ndarray:
        """All columns against values or columns, by recording, (rows,) or (rows, m): (size,) or (size, m)."""
        return np.concatenate([self._of_rig.against(weighted), self._of_laws.against(weighted)])

    def _prepare(self) -> None:
        self._factor = cho_factor(self.information + np.eye(self.size), lower=True, check_finite=False)
        own = self.information[self.parameters :, self.parameters :]
        self._slack = cho_factor(own + np.eye(own.shape[0]), lower=True, check_finite=False)

    def otherwise(self, power: float, wider: float) -> Basis:
        """The same with another power of the likelihood and a slack that is ``wider`` times as wide; no product is taken again."""
        other = copy(self)
        scale = np.ones(self.size)
        scale[self.parameters :] = wider
        other.power, other._of_laws = power, self._of_laws.scaled(wider)
        other.information = power / self.power * np.outer(scale, scale) * self.information
        other._prepare()
        return other

    def with_more(self, slack: Rows) -> Basis:
        """The same with further slack, columns by recording, (rows, m)."""
        other = self._grown(slack, self.size)
        other._of_laws = self._of_laws.with_more(slack)
        other._prepare()
        return other

    def with_unknowns(self, columns: Rows, lowest: np.ndarray, highest: np.ndarray) -> Basis:
        """The same with further unknowns of standard deviation 1 behind the parameters, within bounds (m,); by recording, (rows, m)."""
        other = self._grown(columns, self.parameters)
        other._of_rig = self._of_rig.with_more(columns)
        other.lowest, other.highest = np.concatenate([self.lowest, lowest]), np.concatenate([self.highest, highest])
        other._prepare()
        return other

    def _grown(self, more: Rows, at: int) -> Basis:
        """The same with the information of further columns before the one at an index, yet without the columns and unprepared."""
        other = copy(self)
        cross, own = self._crossed(more)
        order = np.insert(np.arange(self.size), at, self.size + np.arange(own.shape[0]))
        other.information = np.block([[self.information, cross], [cross.T, own]])[np.ix_(order, order)]
        return other

    def sums(self, columns: Rows, values: Rows) -> Sums:
        """Sums of a hypothesis.

        Args:
            columns: by recording, (rows, m). values: by recording, (rows,).
        """
        return self._integrated(*self._products(columns, values))

    def normal(self, columns: Rows, values: Rows) -> Normal:
        """The same with the slack integrated out and the parameters within their bounds."""
        return self._within_bounds(*self._products(columns, values))

    def both(self, columns: Rows, values: Rows) -> tuple[Sums, Normal]:
        """`sums` and `normal`."""
        products = self._products(columns, values)
        return self._integrated(*products), self._within_bounds(*products)

    def both_of_slack(self, shares: np.ndarray, values: Rows) -> tuple[Sums, Normal]:
        """The same of columns of which the slack is ``shares``, (m,), none 0: what these make is known, the values alone are weighed."""
        weighted = self._weighed(values)
        cross = self._all(weighted)
        square = float(sum(v @ w for v, w in zip(values, weighted, strict=True)))
        crossed = self.information[:, self.parameters :] / shares
        squared, own_score = crossed[self.parameters :] / shares[:, None], cross[self.parameters :] / shares
        products = np.column_stack([crossed, cross]), np.block([[squared, own_score[:, None]], [own_score, np.array([square])]])
        return self._integrated(*products), self._within_bounds(*products)

    def _integrated(self, crossed: np.ndarray, squared: np.ndarray) -> Sums:
        """Sums of `_products`."""
        cross, cross_y = crossed[:, :-1], crossed[:, -1]
        solved = cho_solve(self._factor, cross, check_finite=False)
        solved_y = cho_solve(self._factor, cross_y, check_finite=False)
        return Sums(squared[:-1, :-1] - cross.T @ solved, squared[:-1, -1] - cross.T @ solved_y,
                    float(squared[-1, -1] - cross_y @ solved_y))

    def _within_bounds(self, crossed: np.ndarray, squared: np.ndarray) -> Normal:
        """Normal equations of `_products`."""
        k = self.parameters
        mixed = self.information[:k, k:]
        by_slack = cho_solve(self._slack, np.column_stack([mixed.T, crossed[k:]]), check_finite=False)
        information = self.information[:k, :k] + np.eye(k) - mixed @ by_slack[:, :k]
        crossed, squared = crossed[:k] - mixed @ by_slack[:, k:], squared - crossed[k:].T @ by_slack[:, k:]
        return Normal(information, crossed[:, -1], crossed[:, :-1], squared[:-1, :-1], squared[:-1, -1], float(squared[-1, -1]),
                      self.lowest, self.highest)

    def _products(self, columns: Rows, values: Rows) -> tuple[np.ndarray, np.ndarray]:
        """Columns and, last, values: against parameters and slack, (size, m + 1), and against themselves, (m + 1, m + 1)."""
        return self._crossed([np.column_stack([c, v]) for c, v in zip(columns, values, strict=True)])

    def _crossed(self, columns: Rows) -> tuple[np.ndarray, np.ndarray]:
        """Columns against parameters and slack, (size, m), and against themselves, (m, m)."""
        parts = [(self._all(weighted), sum(c.T @ w for c, w in zip(columns, weighted, strict=True)))
                 for weighted in self.weighting.in_parts(columns)]
        cross, squares = (self.power * np.hstack(several) for several in zip(*parts, strict=True))
        return cross, squares

    def shared(self, columns: Rows, values: Rows, x: np.ndarray) -> np.ndarray:
        """Estimate of parameters and slack, (size,), where the columns depart by x, (m,)."""
        rest = [v - c @ x for v, c in zip(values, columns, strict=True)]
        return cho_solve(self._factor, self._all(self._weighed(rest)), check_finite=False)

    def covariance(self) -> np.ndarray:
        """Posterior covariance of the parameters, (k, k), no effect acting."""
        return cho_solve(self._factor, np.eye(self.size), check_finite=False)[: self.parameters, : self.parameters]

    def joint_covariance(self) -> np.ndarray:
        """The same of parameters and slack, (size, size)."""
        return cho_solve(self._factor, np.eye(self.size), check_finite=False)

    def slack(self, residual: Rows) -> np.ndarray:
        """Estimate of the slack, in its standard deviations, (m,), where residuals, by recording, (rows,), are left."""
        return cho_solve(self._slack, self._of_laws.against(self._weighed(residual)), check_finite=False)

    def misfit(self, residual: Rows) -> float:
        """Chi-square of residuals with the slack, but not the parameters, integrated out."""
        weighted = self._weighed(residual)
        cross = self._of_laws.against(weighted)
        square = float(sum(r @ w for r, w in zip(residual, weighted, strict=True)))
        return square - float(cross @ cho_solve(self._slack, cross, check_finite=False))

    def misfits(self, residual: Rows) -> list[np.ndarray]:
        """What every row adds to that chi-square, by recording, (rows,)."""
        weighted = self._weighed(residual)
        left = cho_solve(self._slack, self._of_laws.against(weighted), check_finite=False)
        taken = self._weighed(self._of_laws.times(left))
        return [r * (w - t) for r, w, t in zip(residual, weighted, taken, strict=True)]

    def beyond(self, columns: Rows) -> list[np.ndarray]:
        """What every row tells of each column, parameters and slack having done what they can of it, by recording, (rows, m).

        Its sum over all rows, and what these unknowns pay for it, is the column's own place in `Sums.information`.
        """
        cross = self.power * np.hstack([self._all(weighted) for weighted in self.weighting.in_parts(columns)])
        solved = cho_solve(self._factor, cross, check_finite=False)
        by_rig, by_laws = self._of_rig.times(solved[: self.parameters]), self._of_laws.times(solved[self.parameters :])
        left = [c - rig - laws for c, rig, laws in zip(columns, by_rig, by_laws, strict=True)]
        return [self.power * rest * weighted for rest, weighted in zip(left, self.weighting.applied(left), strict=True)]

    def _weighed(self, values: Rows) -> list[np.ndarray]:
        """Values as they are weighed, by recording, (rows,)."""
        return [self.power * w for w in self.weighting.applied(values)]
