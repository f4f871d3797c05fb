"""The fit of a rig's uncertain quantities to recordings: maximum a posteriori, Levenberg-Marquardt on whole free runs.

The unknowns are deviations in units of the sheet's tolerance (and of the sensors' offset
tolerance), so that the prior is N(0, I); beside them stand the allowances of `comparison` for
what no parameter of the model can mend. Sensitivities are differences of whole free runs, whose
fixed steps make them smooth; Levenberg-Marquardt keeps them while it converges with them (chord
steps) and takes new ones when it does not. Signals that are far off count for less in the first
sweeps and fully in the others: a fit that went on so would settle where one signal is given up.

Tarantola, Inverse Problem Theory, SIAM 2005, chapter 3, for the posterior covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import lsq_linear

from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy, scatter_of
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.estimation.fitting.held_out import rms_over_noise
from ddh_twin_py.estimation.fitting.unknowns import same_everywhere
from ddh_twin_py.estimation.fitting.weighting import Weighting
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.own_oil import refer_to_own_oil
from ddh_twin_py.rig.sheet import BOUNDS, CUT, FIELD_OF_PATH

_DIFFERENCES = (0.1, 0.001)  # of a tolerance, far off and near; 0.003 and less agree, 0.01 crosses places where a piston comes free
_SWEEPS = 10
_FIRST_DAMPING, _DAMPED_OUT = 1.0, 1.0e6  # in units of the prior's precision, of which each direction has 1
_CHORDS = 4
RESTARTS = 2
"""Of a fit that ends at the ends of tolerances; see `Problem.fit`."""
_AT_END = 0.05  # how near to the end of its tolerance a deviation is at it
_WELL_KNOWN = 0.5  # standard deviation after the fit, below which it is odd to stand there
_FAR, _MILD_SWEEPS = 4.0, 3  # RMS of a signal's deviations above which it is judged milder, and for how long
_SETTLED = 1.0e-3  # share of chi-square that a further step would promise or gain
_SETTLED_EACH = 0.1  # the same in squared posterior deviations per unknown, which is less where unknowns are few
_STEP = 2.0e-3  # s, hydraulic step of the runs of a fit; its error is below 1e-4 of a rise of temperature
_COARSE = 4.0e-3  # s, of the runs for the first sensitivities


class FitError(ValueError):
    """A fit that cannot begin; the message names recording, signal and rig file."""


@dataclass
class Fit:
    """Where a fit stands: deviations (k,), predictions there and at the start, what the recordings say, what was done.

    ``deviance``: -2 log of likelihood and prior but for a constant.
    """

    theta: np.ndarray
    predictions: list[dict[str, np.ndarray]]
    first: list[dict[str, np.ndarray]]
    information: np.ndarray
    covariance: np.ndarray
    allowances: dict[tuple, tuple[float, float]]
    deviance: float
    sweeps: int
    settled: bool

    @property
    def spread(self) -> np.ndarray:
        """Standard deviations, in deviations of the prior, (k,)."""
        return np.sqrt(np.diagonal(self.covariance))


@dataclass(frozen=True)
class _Stand:
    """Cost at a place, and what the recordings say of the parameters there: information (k, k) and score (k,)."""

    cost: float
    information: np.ndarray
    score: np.ndarray


class _Judged:
    """Recordings compared at one place, with the weights of residuals there."""

    def __init__(self, comparisons: list[Comparison]) -> None:
        self.comparisons = comparisons
        self.weighting = Weighting(comparisons)

    def residuals(self, predictions) -> list[np.ndarray]:
        """Measured less predicted, by recording, (rows,)."""
        return [c.residual(p) for c, p in zip(self.comparisons, predictions, strict=True)]

    def tempers(self, predictions, sweep: int) -> list[np.ndarray]:
        """By recording, what rows count in this sweep, (rows,): less where their signal is far off."""
        out = [np.ones(c.size) for c in self.comparisons]
        if sweep <= _MILD_SWEEPS:
            for share, comparison, residual in zip(out, self.comparisons, self.residuals(predictions), strict=True):
                for block in comparison.blocks:
                    share[block.rows] = 1.0 / max(1.0, float(np.sqrt(np.mean(residual[block.rows] ** 2))) / _FAR)
        return out

    def stand(self, jacobians, predictions, theta: np.ndarray, temper) -> _Stand:
        """What the recordings say at ``theta``, rows counting as ``temper`` says."""
        rows = [np.column_stack([j, r]) * t[:, None] for j, r, t in zip(jacobians, self.residuals(predictions), temper, strict=True)]
        sums = self.weighting.products(rows, rows)
        return _Stand(float(sums[-1, -1] + theta @ theta), sums[:-1, :-1], sums[:-1, -1])

    def cost(self, predictions, theta: np.ndarray, temper) -> float:
        """The cost alone; see `stand`."""
        rows = [(r * t)[:, None] for r, t in zip(self.residuals(predictions), temper, strict=True)]
        return float(self.weighting.products(rows, rows)[0, 0] + theta @ theta)

    def deviance(self, predictions, theta: np.ndarray) -> float:
        """-2 log of likelihood and prior but for a constant."""
        spread = sum(float(np.log(c.spread).sum()) for c in self.comparisons)
        return self.cost(predictions, theta, [np.ones(c.size) for c in self.comparisons]) + self.weighting.log_determinant + 2.0 * spread


def _within(matrix: np.ndarray, slope: np.ndarray, theta: np.ndarray, lowest: np.ndarray, highest: np.ndarray) -> np.ndarray:
    """Step to the lowest place of the quadratic with no deviation below ``lowest`` or above ``highest``."""
    factor = np.linalg.cholesky(matrix)
    target = solve_triangular(factor, slope, lower=True, check_finite=False)
    return lsq_linear(factor.T, target, bounds=(lowest - 1e-9 - theta, highest + 1e-9 - theta), method="bvls").x


def _broyden(jacobians, comparisons, before, after, move) -> None:
    """Let sensitivities learn from a step that was taken (Broyden 1965), in place."""
    length = float(move @ move)
    if length == 0.0:
        return
    for jacobian, comparison, old, new in zip(jacobians, comparisons, before, after, strict=True):
        missed = comparison.features(new) - comparison.features(old) - jacobian @ move
        jacobian += np.outer(missed, move / length)


class Problem:
    """Recordings of one rig and what is open of them as one vector of deviations: its uncertain parameters, then how each one begins.

    Attributes:
        scale: of each parameter, in its unit, (p,). size: k, parameters and begins. lowest, highest: bounds, (k,).
    """

    def __init__(self, experiments: Sequence[Experiment], rig: Rig, paths: list[str], discrepancy: Discrepancy) -> None:
        self.experiments, self.rig, self.paths, self.discrepancy = list(experiments), rig, paths, discrepancy
        self.scale = np.array([rig.quantities[path].standard_deviation for path in paths])
        ends = np.cumsum([len(paths), *(e.open_begins for e in self.experiments)])
        self._begins = [slice(*pair) for pair in zip(ends[:-1], ends[1:], strict=True)]
        self.size = int(ends[-1])
        room = np.array([(rig[path] - BOUNDS[path].lowest, BOUNDS[path].highest - rig[path]) for path in paths]) / self.scale[:, None]
        below, above = np.clip(room, 0.0, CUT).T  # where tolerances end, and what cannot be negative is not
        open_begins = np.full(self.size - len(paths), CUT)
        self.lowest, self.highest = np.concatenate([-below, -open_begins]), np.concatenate([above, open_begins])
        self._base = [e.parameters(rig) for e in self.experiments]
        for experiment, base in zip(self.experiments, self._base, strict=True):
            experiment.refine(base, _STEP)

    def record(self, number: int, theta: np.ndarray) -> np.ndarray:
        """Parameters (1,) of recording ``number`` at deviations (k,), of which those of the parameters count, (p,)."""
        own = self._base[number].copy()
        for path, deviation, scale in zip(self.paths, theta[: len(self.paths)], self.scale, strict=True):
            field = FIELD_OF_PATH[path]
            if path == "load.payload_mass":
                own[field] *= 1.0 + deviation * scale / self.rig[path]
            else:
                own[field] += deviation * scale
        refer_to_own_oil(own, self._base[number])
        return own

    def begin(self, number: int, theta: np.ndarray) -> np.ndarray:
        """How recording ``number`` begins at deviations (k,), as `Experiment.predict` takes it."""
        return theta[self._begins[number]]

    def predict(self, theta: np.ndarray, step: float = _STEP) -> list[dict[str, np.ndarray]]:
        """Predictions of every recording; ``step`` (s) of the hydraulics."""
        return [e.predict(self.record(i, theta), step, begin=self.begin(i, theta)) for i, e in enumerate(self.experiments)]

    def fit(self, pool: ThreadPoolExecutor, progress=None, start: np.ndarray | None = None, sweeps: int | None = None,
            restarts: int = 0) -> Fit:
        """The fit from the sheet on, or from ``start``.

        Args:
            sweeps: most times that sensitivities are taken on one way; None is `_SWEEPS`.
            restarts: how often a fit that ends with well informed deviations at the ends of their tolerances is begun again
                with these at 0. Where a piston that sticks comes free at another time, a way may end in a valley of its own;
                the better one counts.
        """
        best = self._descend(pool, np.zeros(self.size) if start is None else start, _SWEEPS if sweeps is None else sweeps, progress)
        for _ in range(restarts):
            ends = (np.minimum(best.theta - self.lowest, self.highest - best.theta) < _AT_END) & (best.spread < _WELL_KNOWN)
            if not ends.any():
                break
            kept = self.discrepancy
            other = self._descend(pool, np.where(ends, 0.0, best.theta), _SWEEPS if sweeps is None else sweeps, None)
            other = replace(other, first=best.first, sweeps=best.sweeps + other.sweeps)
            if other.deviance > best.deviance - _SETTLED_EACH * self.size:
                self.discrepancy, best = kept, replace(best, sweeps=other.sweeps)
                break
            best = other
        return best

    def _descend(self, pool: ThreadPoolExecutor, start: np.ndarray, sweeps: int, progress) -> Fit:
        """Levenberg-Marquardt; far from the answer, what is far off counts less."""
        theta = start.copy()
        first = predictions = self.predict(theta)
        self._learn_scatter(predictions)
        settled, sweep, judged, fresh = False, 0, None, []
        keep = False  # of the sensitivities, where only the deviations of the bins changed
        for sweep in range(1, sweeps + 1):
            told = None if progress is None else (lambda done, sweep=sweep: progress((sweep - 1 + 0.9 * done) / sweeps))
            before, judged = judged, self._judge(predictions)
            known = [] if before is None else [
                k * (b.spread / c.spread)[:, None] for k, b, c in zip(fresh, before.comparisons, judged.comparisons, strict=True)]
            base = None if sweep == 1 else predictions
            difference = _DIFFERENCES[min(sweep, len(_DIFFERENCES)) - 1]
            jacobians = self.jacobians(pool, theta, judged.comparisons, difference, told, base, known, keep)
            fresh = [jacobian.copy() for jacobian in jacobians]  # as taken, before Broyden's updates
            temper = judged.tempers(predictions, sweep)
            full = all(np.all(t == 1.0) for t in temper)
            state = judged.stand(jacobians, predictions, theta, temper)
            self._check_finite(state, jacobians)
            damping = 0.0  # shorter steps along what is weakly known, and so goes far and bends
            for _ in range(_CHORDS):
                move, promised = self._step(state, theta, 0.0)
                little = min(_SETTLED * state.cost, _SETTLED_EACH * self.size)
                settled = promised < little and sweep > 1 and full
                if promised < little:
                    break
                if damping > 0.0:
                    move, promised = self._step(state, theta, damping)
                while damping < _DAMPED_OUT:
                    tried = self.predict(theta + move)
                    gained = state.cost - judged.cost(tried, theta + move, temper)
                    if gained > max(0.1 * promised, min(0.1, 0.1 * little)):
                        break
                    damping = max(10.0 * damping, _FIRST_DAMPING)
                    move, promised = self._step(state, theta, damping)
                else:
                    break
                damping = 0.0 if damping <= _FIRST_DAMPING else 0.1 * damping
                _broyden(jacobians, judged.comparisons, predictions, tried, move)
                theta, predictions = theta + move, tried
                temper = judged.tempers(predictions, sweep)
                state = judged.stand(jacobians, predictions, theta, temper)
                if gained < little:
                    break
            if settled and keep:
                break
            self._learn_scatter(predictions)
            keep = settled
        state = judged.stand(jacobians, predictions, theta, [np.ones(c.size) for c in judged.comparisons])
        covariance = np.linalg.inv(state.information + np.eye(self.size))
        allowances = judged.weighting.classes(judged.residuals(predictions))
        deviance = self._judge(predictions).deviance(predictions, theta)
        return Fit(theta, predictions, first, state.information, covariance, allowances, deviance, sweep, settled)

    def _check_finite(self, state: _Stand, jacobians) -> None:
        """Refuse to go on where the runs broke down."""
        if np.isfinite(state.cost) and np.isfinite(state.information).all() and np.isfinite(state.score).all():
            return
        broken = [path for k, path in enumerate(self.paths) if not all(np.isfinite(jacobian[:, k]).all() for jacobian in jacobians)]
        what = f"change with {broken[0]}" if broken else "misfit"
        names = ", ".join(e.recording.path for e in self.experiments)
        raise FitError(f"{names}: the {what} of the free run from {self.rig.file} has no finite value; "
                       "are its quantities far from those of the rig that was recorded?")

    def _judge(self, predictions) -> _Judged:
        return _Judged([Comparison(e.signals, p, self.discrepancy) for e, p in zip(self.experiments, predictions, strict=True)])

    def _step(self, state: _Stand, theta: np.ndarray, damping: float) -> tuple[np.ndarray, float]:
        """Move within the tolerances' ends, and what it would gain if all were linear."""
        slope, curvature = state.score - theta, state.information + np.eye(self.size)
        move = _within(curvature + damping * np.eye(self.size), slope, theta, self.lowest, self.highest)
        return move, float(2.0 * move @ slope - move @ curvature @ move)

    def _learn_scatter(self, predictions) -> None:
        """Let classes be as uncertain as their bins scatter at this place."""
        plain = replace(self.discrepancy, scatter={})
        scatter: dict[tuple, float] = {}
        for e, p in zip(self.experiments, predictions, strict=True):
            comparison = Comparison(e.signals, p, plain)
            for name, factor in scatter_of(comparison, comparison.residual(p)).items():
                scatter[name] = max(factor, scatter.get(name, 1.0))
        self.discrepancy = replace(plain, scatter=scatter)

    def jacobians(self, pool, theta, comparisons, difference: float, progress=None, predictions=None, known=(),
                  keep: bool = False) -> list[np.ndarray]:
        """Sensitivities of every recording's features by every deviation, (rows, k) each.

        Args:
            difference: of a tolerance. progress: told the share done.
            predictions: at ``theta`` with the step of `predict`; None takes a coarser one for base and differences.
            known: sensitivities from another place; those that are the same everywhere are kept,
                or with ``keep`` all.
        """
        step = self._steps(theta, difference)
        size = _COARSE if predictions is None else _STEP

        def column(i: int) -> list[np.ndarray]:
            moved = theta.copy()
            moved[i] += step[i]
            return [c.features(p) for c, p in zip(comparisons, self.predict(moved, size), strict=True)]

        alike = {i for i, path in enumerate(self.paths) if same_everywhere(path)}
        wanted = [i for i in range(self.size) if not (known and (keep or i in alike))]
        at_theta = self.predict(theta, size) if predictions is None else predictions
        base = [c.features(p) for c, p in zip(comparisons, at_theta, strict=True)]
        out = [k.copy() for k in known] or [np.empty((c.size, self.size)) for c in comparisons]
        for done, (i, columns) in enumerate(zip(wanted, pool.map(column, wanted), strict=True), 1):
            for jacobian, moved, at in zip(out, columns, base, strict=True):
                jacobian[:, i] = (moved - at) / step[i]
            if progress is not None:
                progress(done / len(wanted))
        return out

    def _steps(self, theta: np.ndarray, difference: float) -> np.ndarray:
        """Step of each difference, towards the sheet's value."""
        return np.where(theta > 0.0, -difference, difference)

    def rms(self, predictions) -> dict[str, float]:
        """RMS of each signal over its noise, of the samples that were used; see `held_out.rms_over_noise`."""
        found = rms_over_noise(self.experiments, predictions, lambda _, signal: signal.binning.bin >= 0)
        return {name: rms for name, (rms, _) in found.items()}
