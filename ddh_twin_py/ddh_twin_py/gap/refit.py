"""A hypothesis fitted in full: the model runs with its effects, the rig's parameters follow.

Gauss-Newton with the parameters' sensitivities of one place (chord steps); the effects' own
columns are taken anew after every step that gains much. At the end the model is linear about the optimum and its
evidence is that of `hypotheses.weigh` (Laplace's approximation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ddh_twin_py.gap.basis import Basis
from ddh_twin_py.gap.box import Normal
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.hypotheses import LEAST, WIDTH, evidence_of
from ddh_twin_py.gap.linearised import Linearised
from ddh_twin_py.gap.sensitivity import TYPICAL, Column, sane
from ddh_twin_py.gap.side_by_side import side_by_side
from ddh_twin_py.gap.step_length import Lengths

_STEPS = 8
_NEAR = 0.05  # of a column: how far the effects' own differences reach
_SETTLED = 0.1  # of chi-square that a step must promise, and gain
_BENT = 2.0  # of chi-square that a step must gain for the effects' own columns to be taken anew


@dataclass(frozen=True)
class Refitted:
    """A hypothesis at its optimum.

    Attributes:
        columns: the effects' ways. x: departures in the effects' own units, (m,). covariance: of them, (m, m).
        joint: covariance of parameters and departures, (k + m, k + m), with what parameters at the end of their tolerance leave open.
        theta: the rig's parameters, in deviations, (k,). predictions: by recording.
        log_evidence: to be compared with that of other hypotheses on the same basis; minus infinity where every run went astray.
        chi_square: misfit at the optimum, slack integrated out, priors left out.
    """

    columns: tuple[Column, ...]
    x: np.ndarray
    covariance: np.ndarray
    joint: np.ndarray
    theta: np.ndarray
    predictions: list[dict[str, np.ndarray]]
    log_evidence: float
    chi_square: float

    @property
    def acting(self) -> list[tuple[Effect, int, float]]:
        """Its effects as a model runs them; see `model.Acting`."""
        return [(c.effect, c.law, float(x)) for c, x in zip(self.columns, self.x, strict=True)]

    @property
    def slight(self) -> set[str]:
        """Those of its effects that move no signal by as much as `hypotheses.LEAST` asks for, whatever their columns rise to."""
        both = zip(self.columns, self.x, strict=True)
        return {column.effect.id for column, x in both if abs(x / column.x) * min(1.0, column.rise / TYPICAL) < LEAST}

    @property
    def effects(self) -> tuple[str, ...]:
        """Ids, sorted."""
        return tuple(sorted(column.effect.id for column in self.columns))


class Refit:
    """Fits hypotheses of one case.

    Args:
        linearised: the case about one place, whose sensitivities to the parameters are kept. basis: instead of its own.
        width: of the departures' prior, in multiples of their columns.
    """

    def __init__(self, linearised: Linearised, basis: Basis | None = None, width: float = WIDTH) -> None:
        self._width = width
        self._model, self._comparisons, self._sensitivities = linearised.model, linearised.comparisons, linearised.sensitivities
        self._basis, self._place, self._at_place = basis or linearised.basis, linearised.theta, linearised.predictions

    def of(self, columns: Sequence[Column], theta: np.ndarray, departure: np.ndarray) -> Refitted:
        """Fit a hypothesis from a start.

        Args:
            columns: its effects. theta: parameters, deviations, (k,). departure: multiples of the columns, (m,).
        """
        scale = np.array([c.x for c in columns])
        x = np.array([c.effect.limit(float(a)) for c, a in zip(columns, departure * scale, strict=True)])
        starts = [(self._place, 0.0 * x), (self._model.within(theta), x), (self._place, x)]  # the first is known and needs no run
        runs, costs = [], []
        for start in starts[: 3 if scale.size else 2]:
            runs.append(self._run(columns, *start))
            costs.append(self._cost(self._residual(runs[-1]), *start, scale))
            if costs[-1] < costs[0]:
                break
        nearest = int(np.argmin(costs))
        return self._from(columns, *starts[nearest], runs[nearest])

    def _from(self, columns: Sequence[Column], theta: np.ndarray, x: np.ndarray, predictions: list[dict[str, np.ndarray]]) -> Refitted:
        """Fit a hypothesis from a place, parameters (k,) and departures (m,), and what it predicts there."""
        scale, room = np.array([c.x for c in columns]), np.array([c.room for c in columns])
        residual = self._residual(predictions)
        cost = self._cost(residual, theta, x, scale)
        if not np.isfinite(cost):
            nowhere = np.full((theta.size + x.size,) * 2, np.nan)
            return Refitted(tuple(columns), x, nowhere[theta.size :, theta.size :], nowhere, theta, predictions, -np.inf, np.inf)
        stale = True
        for _ in range(_STEPS):
            if stale:
                local, stale = self._columns(columns, theta, x, scale, predictions), False
            held = self._normal(residual, local, theta, x / scale).held(np.arange(scale.size), room, self._width, theta)
            shared, estimate = held.shared, held.departure
            promised = abs(cost - held.lowest)  # less than nothing from a start that a column's direction excludes
            if promised < _SETTLED:
                break
            gained, lengths = 0.0, Lengths(promised)
            while lengths.next:
                share = lengths.next
                new_theta = self._model.within(theta + share * (shared - theta))
                new_x = np.array([c.effect.limit(float(a)) for c, a in zip(columns, x + share * (estimate * scale - x), strict=True)])
                tried = self._run(columns, new_theta, new_x)
                new_residual = self._residual(tried)
                new_cost = self._cost(new_residual, new_theta, new_x, scale)
                if new_cost < cost:
                    gained = cost - new_cost
                    theta, x, predictions, residual, cost = new_theta, new_x, tried, new_residual, new_cost
                    break
                lengths.lost(new_cost - cost)
            stale = gained >= _BENT
            if gained < _SETTLED:
                break
        if stale:
            local = self._columns(columns, theta, x, scale, predictions)
        normal = self._normal(residual, local, theta, x / scale)
        held = normal.held(np.arange(scale.size), room, self._width, theta)
        units = np.concatenate([np.ones(theta.size), scale])
        log, _, covariance = evidence_of(held, room)
        log -= 0.5 * max(0.0, cost - held.lowest)  # what the linear model promises and no step could find
        covariance, joint = covariance * np.outer(scale, scale), normal.covariance(self._width) * np.outer(units, units)
        return Refitted(tuple(columns), x, covariance, joint, theta, predictions, log, self._basis.misfit(residual))

    def again(self, fitted: Refitted) -> Refitted:
        """Fit a hypothesis from where another fit of it stands."""
        return self._from(fitted.columns, fitted.theta, fitted.x, fitted.predictions)

    def local(self, fitted: Refitted) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Columns of its departures about its optimum, (rows, m), and what they and the parameters explain there, (rows,), by recording."""
        scale = np.array([c.x for c in fitted.columns])
        columns = self._columns(fitted.columns, fitted.theta, fitted.x, scale, fitted.predictions)
        return columns, self._values(self._residual(fitted.predictions), columns, fitted.theta, fitted.x / scale)

    def _run(self, columns, theta, x) -> list[dict[str, np.ndarray]]:
        acting = [(c.effect, c.law, float(v)) for c, v in zip(columns, x, strict=True)]
        known = theta is self._place
        wanted = [number for number, altered in enumerate(self._model.altered) if not known or (altered and x.any())]
        ran = dict(zip(wanted, side_by_side([partial(self._model.run_one, number, theta, acting) for number in wanted]), strict=True))
        return [ran[number] if number in ran else self._at_place[number] for number in range(len(self._model.altered))]

    def _residual(self, predictions) -> list[np.ndarray]:
        return [c.residual(p) for c, p in zip(self._comparisons, predictions, strict=True)]

    def _cost(self, residual, theta, x, scale) -> float:
        """Infinite where a run went astray."""
        if not all(sane(r).all() for r in residual):
            return np.inf
        return self._basis.misfit(residual) + float(theta @ theta) + float(np.sum((x / scale / self._width) ** 2))

    def _columns(self, columns, theta, x, scale, predictions) -> list[np.ndarray]:
        """Differences of the features by every departure in multiples of its column, by recording, (rows, m)."""
        out = [np.zeros((c.size, len(columns))) for c in self._comparisons]
        features = [c.features(p) for c, p in zip(self._comparisons, predictions, strict=True)]
        altered = [number for number, acts in enumerate(self._model.altered) if acts]  # elsewhere no effect acts

        def fill(j: int, number: int, moved: np.ndarray) -> None:
            acting = [(c.effect, c.law, float(v)) for c, v in zip(columns, moved, strict=True)]
            change = self._comparisons[number].features(self._model.run_one(number, theta, acting)) - features[number]
            out[number][:, j] = change * scale[j] / (moved[j] - x[j]) if sane(change).all() else 0.0

        calls = []
        for j, column in enumerate(columns):
            moved = x.copy()
            for reach in (_NEAR, -_NEAR):
                moved[j] = column.effect.limit(float(x[j] + reach * scale[j]))
                if moved[j] != x[j]:
                    break
            calls += [partial(fill, j, number, moved) for number in altered]
        side_by_side(calls)
        return out

    def _normal(self, residual, local, theta, departure) -> Normal:
        return self._basis.normal(local, self._values(residual, local, theta, departure))

    def _values(self, residual, local, theta, departure) -> list[np.ndarray]:
        return [r + j @ theta + c @ departure for r, j, c in zip(residual, self._sensitivities, local, strict=True)]
