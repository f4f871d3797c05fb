"""The unknowns that every hypothesis shares, and sums of anything else with them integrated out.

    y = J theta + S s + C x + e,   theta ~ N(0, I),  s ~ N(0, I),  e ~ N(0, P^-1)

theta are the rig's parameters in deviations of their tolerances, S the slack of the model's laws,
C the columns of a hypothesis. J and S are sensitivities at one place and stay; y and C change from
hypothesis to hypothesis and cost a few products.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ddh_twin_py.estimation.weighting import Weighting

Rows = Sequence[np.ndarray]


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
        power: to which the likelihood is raised; below 1 where the model's laws are not quite the rig's.
    """

    def __init__(self, weighting: Weighting, parameters: Rows, slack: Rows, power: float = 1.0) -> None:
        self.weighting, self.power = weighting, power
        self.columns = [np.hstack([j, s]) for j, s in zip(parameters, slack, strict=True)]
        self.parameters = parameters[0].shape[1]
        self.size = self.columns[0].shape[1]
        self.information = power * weighting.products(self.columns, self.columns)
        self._prepare()

    def _prepare(self) -> None:
        self._factor = cho_factor(self.information + np.eye(self.size), lower=True, check_finite=False)
        own = self.information[self.parameters :, self.parameters :]
        self._slack = cho_factor(own + np.eye(own.shape[0]), lower=True, check_finite=False)

    def otherwise(self, power: float, wider: float) -> Basis:
        """The same with another power of the likelihood and a slack that is ``wider`` times as wide; no product is taken again."""
        other = copy(self)
        scale = np.ones(self.size)
        scale[self.parameters :] = wider
        other.power, other.columns = power, [c * scale for c in self.columns]
        other.information = power / self.power * np.outer(scale, scale) * self.information
        other._prepare()
        return other

    def sums(self, columns: Rows, values: Rows) -> Sums:
        """Sums of a hypothesis.

        Args:
            columns: by recording, (rows, m). values: by recording, (rows,).
        """
        own = [np.column_stack([c, v]) for c, v in zip(columns, values, strict=True)]
        weighted = [self.power * w for w in self.weighting.applied(own)]
        crossed = sum(f.T @ w for f, w in zip(self.columns, weighted, strict=True))
        squared = sum(o.T @ w for o, w in zip(own, weighted, strict=True))
        cross, cross_y = crossed[:, :-1], crossed[:, -1]
        solved = cho_solve(self._factor, cross, check_finite=False)
        solved_y = cho_solve(self._factor, cross_y, check_finite=False)
        return Sums(squared[:-1, :-1] - cross.T @ solved, squared[:-1, -1] - cross.T @ solved_y,
                    float(squared[-1, -1] - cross_y @ solved_y))

    def shared(self, columns: Rows, values: Rows, x: np.ndarray) -> np.ndarray:
        """Estimate of parameters and slack, (size,), where the columns depart by x, (m,)."""
        rest = [v - c @ x for v, c in zip(values, columns, strict=True)]
        score = self.power * self.weighting.products(self.columns, [r[:, None] for r in rest])[:, 0]
        return cho_solve(self._factor, score, check_finite=False)

    def covariance(self) -> np.ndarray:
        """Posterior covariance of the parameters, (k, k), no effect acting."""
        return cho_solve(self._factor, np.eye(self.size), check_finite=False)[: self.parameters, : self.parameters]

    def joint_covariance(self) -> np.ndarray:
        """The same of parameters and slack, (size, size)."""
        return cho_solve(self._factor, np.eye(self.size), check_finite=False)

    def slack(self, residual: Rows) -> np.ndarray:
        """Estimate of the slack, in its standard deviations, (m,), where residuals, by recording, (rows,), are left."""
        cross = self.power * self.weighting.products(self.columns, [r[:, None] for r in residual])[self.parameters :, 0]
        return cho_solve(self._slack, cross, check_finite=False)

    def misfit(self, residual: Rows) -> float:
        """Chi-square of residuals with the slack, but not the parameters, integrated out."""
        weighted = [self.power * w for w in self.weighting.applied([r[:, None] for r in residual])]
        square = float(sum(r @ w[:, 0] for r, w in zip(residual, weighted, strict=True)))
        cross = sum(c[:, self.parameters :].T @ w[:, 0] for c, w in zip(self.columns, weighted, strict=True))
        return square - float(cross @ cho_solve(self._slack, cross, check_finite=False))
