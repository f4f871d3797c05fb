"""A hypothesis fitted in full: the model runs with its effects, the rig's parameters follow.

Gauss-Newton with the parameters' sensitivities of one place (chord steps); the effects' own
columns are taken anew after every step that gains much. At the end the model is linear about the optimum and its
evidence is that of `hypotheses.weigh` (Laplace's approximation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.evidence.basis import Basis
from ddh_twin_py.gap.evidence.box import Held, Normal
from ddh_twin_py.gap.evidence.hypotheses import LEAST, WIDTH, evidence_of
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.pieces import Pieces
from ddh_twin_py.gap.evidence.sensitivity import TYPICAL, Column, acting_of, sane
from ddh_twin_py.gap.explain.side_by_side import side_by_side
from ddh_twin_py.gap.explain.step_length import Lengths

_STEPS, _MOST = 8, 24  # steps after which only a fit that still gains much goes on, and those after which none does
_NEAR = 0.05  # of a column: how far the effects' own differences reach
_SETTLED, _MUCH = 0.1, 10.0  # of chi-square that a step must promise, and gain; the same after `_STEPS`
_BENT = 2.0  # of chi-square that a step must gain for the effects' own columns to be taken anew
_BESIDE = 0.25  # deviations: how far the differences by what changed beside an effect reach


@dataclass(frozen=True)
class Refitted:
    """A hypothesis at its optimum.

    Attributes:
        columns: the effects' ways. x: departures in the effects' own units, (m,). covariance: of them, (m, m).
        joint: covariance of parameters and departures, (k + m, k + m), with what parameters at the end of their tolerance leave open.
        theta: the rig's parameters, in deviations, (k,). predictions: by recording.
        log_evidence: to be compared with that of other hypotheses on the same basis; minus infinity where every run went astray.
        chi_square: misfit at the optimum, slack integrated out, priors left out.
        beside: what changed along with each effect, in deviations, (m,); 0 where nothing may, see `effect.Beside`.
    """

    columns: tuple[Column, ...]
    x: np.ndarray
    covariance: np.ndarray
    joint: np.ndarray
    theta: np.ndarray
    predictions: list[dict[str, np.ndarray]]
    log_evidence: float
    chi_square: float
    beside: np.ndarray

    @property
    def ways(self) -> tuple[Column, ...]:
        """Its columns, the effects with what changed along with them."""
        return along_with(self.columns, self.beside)

    @property
    def acting(self) -> list[tuple[Effect, int, float]]:
        """Its effects as a model runs them; see `model.Acting`."""
        return acting_of(self.ways, self.x)

    @property
    def slight(self) -> set[str]:
        """Those of its effects that move no signal by as much as `hypotheses.LEAST` asks for, whatever their columns rise to."""
        both = zip(self.columns, self.x, strict=True)
        return {column.effect.id for column, x in both if abs(x / column.x) * min(1.0, column.rise / TYPICAL) < LEAST}

    @property
    def effects(self) -> tuple[str, ...]:
        """Ids, sorted."""
        return tuple(sorted(column.effect.id for column in self.columns))


def along_with(columns: Sequence[Column], beside: np.ndarray) -> tuple[Column, ...]:
    """Columns with effects beside which so much has changed, deviations (m,)."""
    return tuple(replace(c, effect=c.effect.along_with(float(z))) if z else c for c, z in zip(columns, beside, strict=True))


@dataclass(frozen=True)
class _About:
    """A hypothesis about a place.

    Attributes:
        basis: of what is shared, parameters and what changes beside effects (p,). shared: sensitivities to it, p of them.
        own: columns of the departures, by recording, (rows, m). also: effects beside which something may have changed, indices.
    """

    basis: Basis
    shared: Pieces
    own: list[np.ndarray]
    also: np.ndarray

    def at(self, theta: np.ndarray, beside: np.ndarray) -> np.ndarray:
        """What is shared, (p,): parameters (k,) and, of what changed beside the effects (m,), what may have."""
        return np.concatenate([theta, beside[self.also]])

    def normal(self, residual: list[np.ndarray], shared: np.ndarray, departure: np.ndarray) -> Normal:
        """Sums of what is left there: residuals by recording, (rows,), shared unknowns (p,), departures in multiples of columns (m,)."""
        both = zip(residual, self.shared.times(shared), self.own, strict=True)
        return self.basis.normal(self.own, [r + s + c @ departure for r, s, c in both])


@dataclass(frozen=True)
class _Stand:
    """Where a fit stands.

    Attributes:
        theta: parameters, (k,). x: departures in the effects' own units, (m,). beside: what changed beside them, (m,).
        predictions: by recording. residual: of them, by recording, (rows,). cost: of all of it, infinite where a run went astray.
    """

    theta: np.ndarray
    x: np.ndarray
    beside: np.ndarray
    predictions: list[dict[str, np.ndarray]]
    residual: list[np.ndarray]
    cost: float


class Refit:
    """Fits hypotheses of one case.

    Args:
        linearised: the case about one place, whose sensitivities to the parameters are kept. basis: instead of its own.
        width: of the departures' prior, in multiples of their columns; None: of that by which hypotheses are weighed.
    """

    def __init__(self, linearised: Linearised, basis: Basis | None = None, width: float | None = None) -> None:
        self._width, self._widths = (WIDTH, linearised.question.widths) if width is None else (width, (width,))
        self._model, self._comparisons, self._sensitivities = linearised.model, linearised.comparisons, linearised.sensitivities
        self._basis, self._place, self._at_place = basis or linearised.basis, linearised.theta, linearised.predictions

    def of(self, columns: Sequence[Column], theta: np.ndarray, departure: np.ndarray) -> Refitted:
        """Fit a hypothesis from a start.

        Args:
            columns: its effects. theta: parameters, deviations, (k,). departure: multiples of the columns, (m,).
        """
        x = np.array([c.effect.limit(float(a)) for c, a in zip(columns, departure * _scale(columns), strict=True)])
        starts = [(self._place, 0.0 * x), (self._model.within(theta), x), (self._place, x)]  # the first is known and needs no run
        stands: list[_Stand] = []
        for start in starts[: 3 if x.size else 2]:
            stands.append(self._stand(columns, *start, np.zeros(x.size), self._run(columns, *start)))
            if stands[-1].cost < stands[0].cost:
                break
        return self._from(columns, min(stands, key=lambda stand: stand.cost))

    def _from(self, columns: Sequence[Column], stand: _Stand) -> Refitted:
        """Fit a hypothesis from where it stands."""
        if not np.isfinite(stand.cost):
            return _astray(columns, stand)
        here = self._about(columns, stand)
        for step in range(1, _MOST + 1):
            sums, held = self._solved(columns, stand, here)
            further = self._further(columns, stand, here, held)
            gained, stand = stand.cost - further.cost, further
            if gained >= _BENT:
                here = self._about(columns, stand)
            if gained < (_SETTLED if step < _STEPS else _MUCH):
                break
        if gained > 0.0:
            sums, held = self._solved(columns, stand, here)
        scale, room = _scale(columns), np.array([c.room for c in columns])
        log, _, covariance = evidence_of(held, room, self._widths)
        log -= 0.5 * max(0.0, stand.cost - held.lowest)  # what the linear model promises and no step could find
        joint = self._joint(sums, stand.theta.size, scale)
        misfit = stand.cost - self._prior(stand.theta, stand.x, scale, stand.beside)
        return Refitted(tuple(columns), stand.x, covariance * np.outer(scale, scale), joint, stand.theta, stand.predictions, log, misfit,
                        stand.beside)

    def _stand(self, columns, theta, x, beside, predictions) -> _Stand:
        residual = self._residual(predictions)
        return _Stand(theta, x, beside, predictions, residual, self._cost(residual, theta, x, _scale(columns), beside))

    def _standing(self, fitted: Refitted) -> _Stand:
        """Where a hypothesis stands that was fitted elsewhere."""
        return self._stand(fitted.columns, fitted.theta, fitted.x, fitted.beside, fitted.predictions)

    def _solved(self, columns: Sequence[Column], stand: _Stand, here: _About) -> tuple[Normal, Held]:
        """Sums about a place of what is left where a fit stands, and the lowest cost that they promise."""
        shared, room = here.at(stand.theta, stand.beside), np.array([c.room for c in columns])
        sums = here.normal(stand.residual, shared, stand.x / _scale(columns))
        return sums, sums.held(np.arange(room.size), room, self._width, shared)

    def _further(self, columns: Sequence[Column], stand: _Stand, here: _About, held: Held) -> _Stand:
        """A step towards the lowest cost that is promised, as far as runs confirm; the same where none does or hardly anything is."""
        promised = abs(stand.cost - held.lowest)  # less than nothing from a start that a column's direction excludes
        if promised < _SETTLED:
            return stand
        scale, k = _scale(columns), stand.theta.size
        aim = stand.beside.copy()
        aim[here.also] = held.shared[k:]
        lengths = Lengths(promised)
        while lengths.next:
            share = lengths.next
            theta = self._model.within(stand.theta + share * (held.shared[:k] - stand.theta))
            beside = stand.beside + share * (aim - stand.beside)
            departed = stand.x + share * (held.departure * scale - stand.x)
            x = np.array([c.effect.limit(float(a)) for c, a in zip(columns, departed, strict=True)])
            tried = self._stand(columns, theta, x, beside, self._run(along_with(columns, beside), theta, x))
            if tried.cost < stand.cost:
                return tried
            lengths.lost(tried.cost - stand.cost)
        return stand

    def joint(self, fitted: Refitted) -> np.ndarray:
        """Covariance of parameters and departures, (k + m, k + m), of a hypothesis as it was fitted elsewhere."""
        stand = self._standing(fitted)
        sums, _ = self._solved(fitted.columns, stand, self._about(fitted.columns, stand))
        return self._joint(sums, fitted.theta.size, _scale(fitted.columns))

    def _joint(self, sums: Normal, parameters: int, scale: np.ndarray) -> np.ndarray:
        """What changed beside the effects integrated out."""
        of_all = sums.covariance(self._width)
        own = np.concatenate([np.arange(parameters), np.arange(of_all.shape[0] - scale.size, of_all.shape[0])])
        units = np.concatenate([np.ones(parameters), scale])
        return of_all[np.ix_(own, own)] * np.outer(units, units)

    def _about(self, columns: Sequence[Column], stand: _Stand) -> _About:
        """The model about where a fit stands, linear in the departures and in what changes beside them."""
        also = self._also(columns)
        own, more = self._columns(columns, stand.theta, stand.x, _scale(columns), stand.predictions, stand.beside, also)
        if not also.size:
            return _About(self._basis, Pieces([self._sensitivities]), own, also)
        ends = np.array([columns[j].effect.beside.end for j in also])
        return _About(self._basis.with_unknowns(more, -ends, ends), Pieces([self._sensitivities, more]), own, also)

    def _also(self, columns: Sequence[Column]) -> np.ndarray:
        """Which effects something may have changed beside, indices: where no recording shows the rig before, parameters hold it."""
        dated = not all(self._model.altered)
        return np.array([j for j, column in enumerate(columns) if dated and column.effect.beside is not None], dtype=np.int64)

    def again(self, fitted: Refitted) -> Refitted:
        """Fit a hypothesis from where another fit of it stands."""
        return self._from(fitted.columns, self._standing(fitted))

    def local(self, fitted: Refitted) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Columns of its departures about its optimum, (rows, m), and what they and the parameters explain there, (rows,), by recording."""
        scale = _scale(fitted.columns)
        columns, _ = self._columns(fitted.columns, fitted.theta, fitted.x, scale, fitted.predictions, fitted.beside)
        both = zip(self._residual(fitted.predictions), self._sensitivities, columns, strict=True)
        return columns, [r + j @ fitted.theta + c @ (fitted.x / scale) for r, j, c in both]

    def _run(self, columns, theta, x) -> list[dict[str, np.ndarray]]:
        acting = acting_of(columns, x)
        known = theta is self._place
        wanted = [number for number, altered in enumerate(self._model.altered) if not known or (altered and x.any())]
        ran = dict(zip(wanted, side_by_side([partial(self._model.run_one, number, theta, acting) for number in wanted]), strict=True))
        return [ran[number] if number in ran else self._at_place[number] for number in range(len(self._model.altered))]

    def _residual(self, predictions) -> list[np.ndarray]:
        return [c.residual(p) for c, p in zip(self._comparisons, predictions, strict=True)]

    def _cost(self, residual, theta, x, scale, beside) -> float:
        """Infinite where a run went astray."""
        if not all(sane(r).all() for r in residual):
            return np.inf
        return self._basis.misfit(residual) + self._prior(theta, x, scale, beside)

    def _prior(self, theta, x, scale, beside) -> float:
        """What parameters, departures and what changed beside them cost by themselves."""
        return float(theta @ theta + beside @ beside) + float(np.sum((x / scale / self._width) ** 2))

    def _columns(self, columns, theta, x, scale, predictions, beside, also=()) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Differences of the features, by recording, (rows, m): by every departure in multiples of its column, and, of the effects
        ``also``, by what changes beside them in deviations."""
        out, more = ([np.zeros((c.size, n)) for c in self._comparisons] for n in (len(columns), len(also)))
        features = [c.features(p) for c, p in zip(self._comparisons, predictions, strict=True)]
        altered = [number for number, acts in enumerate(self._model.altered) if acts]  # elsewhere no effect acts

        def fill(rows: np.ndarray, per: float, number: int, moved: np.ndarray, changed: np.ndarray) -> None:
            acting = acting_of(along_with(columns, changed), moved)
            change = self._comparisons[number].features(self._model.run_one(number, theta, acting)) - features[number]
            rows[:] = change / per if sane(change).all() else 0.0

        calls = []
        for j, column in enumerate(columns):
            moved = x.copy()
            for reach in (_NEAR, -_NEAR):
                moved[j] = column.effect.limit(float(x[j] + reach * scale[j]))
                if abs(moved[j] - x[j]) > 0.5 * _NEAR * abs(scale[j]):  # beside a bound there may be no room but for rounding
                    break
            calls += [partial(fill, out[number][:, j], (moved[j] - x[j]) / scale[j], number, moved, beside) for number in altered]
        for place, j in enumerate(also):
            changed = beside.copy()
            changed[j] += _BESIDE if beside[j] <= 0.0 else -_BESIDE
            calls += [partial(fill, more[number][:, place], changed[j] - beside[j], number, x, changed) for number in altered]
        side_by_side(calls)
        return out, more


def _scale(columns: Sequence[Column]) -> np.ndarray:
    """Departures of columns, in the effects' own units, (m,)."""
    return np.array([c.x for c in columns])


def _astray(columns: Sequence[Column], stand: _Stand) -> Refitted:
    """A hypothesis whose every run went astray."""
    k, size = stand.theta.size, stand.theta.size + stand.x.size
    nowhere = np.full((size, size), np.nan)
    return Refitted(tuple(columns), stand.x, nowhere[k:, k:], nowhere, stand.theta, stand.predictions, -np.inf, np.inf, stand.beside)
