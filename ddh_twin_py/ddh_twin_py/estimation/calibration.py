"""Fit a rig's uncertain parameters to recordings: maximum a posteriori, with an honest covariance.

The unknowns are deviations in units of the sheet's tolerance (and of the sensors' offset
tolerance), so that the prior is N(0, I); beside them stand the allowances of `comparison` for
what no parameter of the model can mend. Sensitivities are differences of whole free runs, whose
fixed steps make them smooth; Levenberg-Marquardt keeps them while it converges with them (chord
steps) and takes new ones when it does not. Signals that are far off count for less in the first
sweeps and fully in the others: a fit that went on so would settle where one signal is given up.

Tarantola, Inverse Problem Theory, SIAM 2005, chapter 3, for the posterior covariance.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import lsq_linear

from ddh_twin_py.estimation.allowances import Sums, sums_of
from ddh_twin_py.estimation.comparison import CLOCK_JITTER, Comparison, Discrepancy, scatter_of
from ddh_twin_py.estimation.experiment import PRESSURES, Experiment
from ddh_twin_py.estimation.held_out import rms_over_noise
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.own_oil import of_own_oil, refer_to_own_oil
from ddh_twin_py.rig.sheet import BOUNDS, CUT, FIELD_OF_PATH, Quantity

AIR = "surroundings.enclosure_rise"
"""What the ambient sensor's zero error comes to: the air is warmer than it reads."""
SKEW = "measurement.time_skew"
"""How much later hydraulic samples are stamped than the drive's; unknown by `CLOCK_JITTER`."""
_ALLOWED = {SKEW: (CLOCK_JITTER, "clocks of drive and pressures")}
"""Standard deviation of what else no sheet lists, and why."""
INFORMED = 0.9
"""A parameter whose standard deviation fell below this share of its prior was informed by the recordings."""
_DIFFERENCES = (0.1, 0.01, 0.003)  # of a tolerance, from far to near; pressures hang on leakage with a curve
_SWEEPS = 10
_FIRST_DAMPING, _DAMPED_OUT = 1.0, 1.0e6  # in units of the prior's precision, of which each direction has 1
_CHORDS = 4
_FAR, _MILD_SWEEPS = 4.0, 3  # RMS of a signal's deviations above which it is judged milder, and for how long
_SETTLED = 1.0e-3  # share of chi-square that a further step would promise or gain
_SETTLED_EACH = 0.1  # the same in squared posterior deviations per unknown, which is less where unknowns are few
_STEP = 2.0e-3  # s, hydraulic step of the runs of a fit; its error is below 1e-4 of a rise of temperature
_COARSE = 4.0e-3  # s, of the runs for the first sensitivities


class CalibrationError(ValueError):
    """A fit that cannot be made; the message names what was asked for and what is possible."""


@dataclass(frozen=True)
class FittedParameter:
    """One parameter: prior and posterior in ``unit``, and whether the recordings said anything about it."""

    name: str
    unit: str
    prior: float
    prior_std: float
    value: float
    std: float
    informed: bool

    @property
    def share(self) -> float:
        """Standard deviation after over before; 1 is nothing learnt."""
        return self.std / self.prior_std

    @property
    def moved(self) -> float:
        """How far it moved, in prior standard deviations."""
        return (self.value - self.prior) / self.prior_std


@dataclass(frozen=True)
class Calibration:
    """What a fit found.

    Attributes:
        rig: the rig with fitted values, standard deviations and sources.
        parameters: with prior and posterior, sensor offsets at the end.
        correlation: between them in that order, (k, k).
        before, after: RMS of each signal's residual over its noise, sheet and fit.
        sweeps: times that sensitivities were taken. settled: whether the last step was negligible.
        discrepancy: what the model was forgiven, sized by this fit.
        refused: parameters that were asked for and that the recordings cannot identify; the rig keeps
            their prior. asked: whether only some were asked for; all others were held exact.
    """

    rig: Rig
    parameters: list[FittedParameter]
    correlation: np.ndarray
    before: dict[str, float]
    after: dict[str, float]
    sweeps: int
    settled: bool
    discrepancy: Discrepancy
    refused: tuple[FittedParameter, ...] = ()
    asked: bool = False

    def together(self, least: float = 0.95) -> list[tuple[str, str, float]]:
        """Pairs of which only a combination is informed: names and correlation, |r| above ``least``, closest first."""
        names = [parameter.name for parameter in self.parameters]
        rows, columns = np.nonzero(np.triu(np.abs(self.correlation) > least, 1))
        pairs = [(names[i], names[j], float(self.correlation[i, j])) for i, j in zip(rows, columns, strict=True)]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))


def uncertain_paths(rig: Rig) -> list[str]:
    """Paths of the quantities that have a tolerance."""
    return [path for path, quantity in rig.quantities.items() if quantity.standard_deviation > 0.0]


def offset_paths(experiments: Sequence[Experiment]) -> list[str]:
    """Paths of what no sheet lists and every fit needs: zero errors of the sensors that the recordings have, clocks."""
    signals = dict.fromkeys(name for e in experiments for name in e.signals)
    names = [name if name in PRESSURES else name.split("/")[1] for name in signals if name in PRESSURES or "/" in name]
    air = any("ambient" in e.recording.temperatures for e in experiments)
    return [f"measurement.{name}_offset" for name in names] + [AIR] * air + [SKEW]


def _same_everywhere(path: str) -> bool:
    """Whether every reading is a linear function of a zero error, whatever else is fitted: those that do not reach the oil."""
    return path.startswith(("measurement.pressure_", "measurement.motor_")) and path.endswith("_offset")


def with_offsets(rig: Rig, paths: Sequence[str]) -> Rig:
    """The rig with the sheet's tolerance on those zero errors that nothing is known of yet."""
    quantities = dict(rig.quantities)
    for path in paths:
        sensor = rig.sensors["pressure" if path.startswith("measurement.pressure") else "temperature"]
        if quantities[path].standard_deviation == 0.0:
            std, what = _ALLOWED.get(path, (sensor.offset_tolerance, "the sensor's zero"))
            quantities[path] = replace(quantities[path], std=std, source=what)
    return replace(rig, quantities=quantities)


def calibrate(experiments: Sequence[Experiment], rig: Rig, only: Sequence[str] = (), threads: int = 2,
              discrepancy: Discrepancy | None = None, progress: Callable[[float], None] | None = None) -> Calibration:
    """Fit the rig to recordings of it.

    Args:
        experiments: recordings of one rig. rig: its sheet; values and tolerances are the prior.
        only: paths to fit; empty fits all that have a tolerance. Sensor offsets are always fitted.
        threads: free runs side by side. discrepancy: what the model is forgiven.
        progress: told the share done.

    Raises:
        CalibrationError: no recording, recordings of several rigs or with nothing to fit, or a path that
            the sheet does not have or holds exact.
    """
    if not experiments:
        raise CalibrationError("no recording was given")
    _check_recordings(experiments)
    offsets = offset_paths(experiments)
    rig = with_offsets(rig, offsets)
    wanted = list(only) or [path for path in uncertain_paths(rig) if not path.startswith("measurement.")]
    problem = Problem(experiments, rig, check_paths(rig, wanted) + [path for path in offsets if path not in wanted],
                      discrepancy or Discrepancy())
    with ThreadPoolExecutor(max_workers=threads) as pool:
        fit = problem.fit(pool, progress)
    if progress is not None:
        progress(1.0)
    return problem.result(fit, tuple(only))


def _check_recordings(experiments: Sequence[Experiment]) -> None:
    """Refuse recordings of several rigs, and those that no free run can be made of or compared with."""
    for e in experiments:
        if not np.isfinite(e.recording.drive.column("speed_command")).any():
            raise CalibrationError(f"{e.recording.path}: no usable speed_command; a free run needs it")
        if not any((signal.binning.bin >= 0).any() for signal in e.signals.values()):
            raise CalibrationError(f"{e.recording.path}: no usable sample of any signal; there is nothing to fit to")
    named = [e.recording for e in experiments if e.recording.rig is not None and e.recording.rig.rig_id]
    for other in named[1:]:
        if other.rig.rig_id != named[0].rig.rig_id:
            raise CalibrationError(f"{named[0].path} is of rig {named[0].rig.rig_id!r} and {other.path} of rig {other.rig.rig_id!r}; "
                                   "a fit takes recordings of one rig")


def check_paths(rig: Rig, paths: Sequence[str]) -> list[str]:
    """The paths, where all can be fitted.

    Raises:
        CalibrationError: unknown path (with the nearest valid one), or one that the sheet holds exact.
    """
    for path in paths:
        if path not in rig.quantities:
            nearest = difflib.get_close_matches(path, list(rig.quantities), 1, 0.0)[0]
            raise CalibrationError(f"{path}: no such parameter; the nearest is {nearest!r}")
        if rig.quantities[path].standard_deviation == 0.0:
            raise CalibrationError(f"{path}: the sheet holds it exact (tolerance 0), there is nothing to fit")
    return list(paths)


@dataclass
class Fit:
    """Where a fit stands: deviations (k,), predictions there and at the start, what the recordings say, what was done."""

    theta: np.ndarray
    predictions: list[dict[str, np.ndarray]]
    first: list[dict[str, np.ndarray]]
    information: np.ndarray
    covariance: np.ndarray
    allowances: dict[tuple, tuple[float, float]]
    sweeps: int
    settled: bool


@dataclass(frozen=True)
class _Stand:
    """Cost at a place, what the recordings say of the parameters there, and the sums behind it."""

    cost: float
    information: np.ndarray
    score: np.ndarray
    sums: Sums


def _tempers(comparison: Comparison, prediction, sweep: int) -> dict[str, float]:
    """Signal to how much milder it is judged in this sweep."""
    if sweep > _MILD_SWEEPS:
        return dict.fromkeys((b.signal for b in comparison.blocks), 1.0)
    residual = comparison.residual(prediction)
    return {b.signal: max(1.0, float(np.sqrt(np.mean(residual[b.rows] ** 2))) / _FAR) for b in comparison.blocks}


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
    """Recordings of one rig and its uncertain parameters as one vector of deviations."""

    def __init__(self, experiments: Sequence[Experiment], rig: Rig, paths: list[str], discrepancy: Discrepancy) -> None:
        self.experiments, self.rig, self.paths, self.discrepancy = list(experiments), rig, paths, discrepancy
        self.scale = np.array([rig.quantities[path].standard_deviation for path in paths])
        self.size = len(paths)
        room = np.array([(rig[path] - BOUNDS[path].lowest, BOUNDS[path].highest - rig[path]) for path in paths]) / self.scale[:, None]
        below, above = np.clip(room, 0.0, CUT).T  # where tolerances end, and what cannot be negative is not
        self.lowest, self.highest = -below, above
        self._base = [e.parameters(rig) for e in self.experiments]

    def record(self, number: int, theta: np.ndarray) -> np.ndarray:
        """Parameters (1,) of recording ``number`` at deviations (k,)."""
        own = self._base[number].copy()
        for path, deviation, scale in zip(self.paths, theta, self.scale, strict=True):
            field = FIELD_OF_PATH[path]
            if path == "load.payload_mass":
                own[field] *= 1.0 + deviation * scale / self.rig[path]
            else:
                own[field] += deviation * scale
        refer_to_own_oil(own, self._base[number])
        return own

    def predict(self, theta: np.ndarray, step: float = _STEP) -> list[dict[str, np.ndarray]]:
        """Predictions of every recording; ``step`` (s) of the hydraulics."""
        return [e.predict(self.record(i, theta), step) for i, e in enumerate(self.experiments)]

    def fit(self, pool: ThreadPoolExecutor, progress=None, start: np.ndarray | None = None, sweeps: int | None = None) -> Fit:
        """Levenberg-Marquardt from the sheet (or ``start``) on; far from the answer, what is far off counts less.

        Args:
            sweeps: most times that sensitivities are taken; None is `_SWEEPS`.
        """
        sweeps = _SWEEPS if sweeps is None else sweeps
        theta = np.zeros(self.size) if start is None else start.copy()
        first = predictions = self.predict(theta)
        self._learn_scatter(predictions)
        settled, sweep, comparisons, fresh = False, 0, [], []
        keep = False  # of the sensitivities, where only the deviations of the bins changed
        for sweep in range(1, sweeps + 1):
            told = None if progress is None else (lambda done, sweep=sweep: progress((sweep - 1 + 0.9 * done) / sweeps))
            before, known = comparisons, fresh
            comparisons = [Comparison(e.signals, p, self.discrepancy) for e, p in zip(self.experiments, predictions, strict=True)]
            known = [] if sweep == 1 else [k * (b.spread / c.spread)[:, None] for k, b, c in zip(known, before, comparisons, strict=True)]
            base = None if sweep == 1 else predictions
            jacobians = self.jacobians(pool, theta, comparisons, _DIFFERENCES[min(sweep, len(_DIFFERENCES)) - 1], told, base, known, keep)
            fresh = [jacobian.copy() for jacobian in jacobians]  # as taken, before Broyden's updates
            temper = [_tempers(c, p, sweep) for c, p in zip(comparisons, predictions, strict=True)]
            full = all(factor == 1.0 for t in temper for factor in t.values())
            state = self._stand(comparisons, jacobians, predictions, theta, temper)
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
                    gained = state.cost - self._cost(comparisons, tried, theta + move, temper)
                    if gained > max(0.1 * promised, min(0.1, 0.1 * little)):
                        break
                    damping = max(10.0 * damping, _FIRST_DAMPING)
                    move, promised = self._step(state, theta, damping)
                else:
                    break
                damping = 0.0 if damping <= _FIRST_DAMPING else 0.1 * damping
                _broyden(jacobians, comparisons, predictions, tried, move)
                theta, predictions = theta + move, tried
                temper = [_tempers(c, p, sweep) for c, p in zip(comparisons, predictions, strict=True)]
                state = self._stand(comparisons, jacobians, predictions, theta, temper)
                if gained < little:
                    break
            if settled and keep:
                break
            self._learn_scatter(predictions)
            keep = settled
        plain = [dict.fromkeys(t, 1.0) for t in temper]
        state = self._stand(comparisons, jacobians, predictions, theta, plain)
        covariance = np.linalg.inv(state.information + np.eye(self.size))
        return Fit(theta, predictions, first, state.information, covariance, state.sums.classes(np.zeros(self.size)), sweep, settled)

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

        wanted = [i for i, path in enumerate(self.paths) if not (known and (keep or _same_everywhere(path)))]
        at_theta = self.predict(theta, size) if predictions is None else predictions
        base = [c.features(p) for c, p in zip(comparisons, at_theta, strict=True)]
        out = [k.copy() for k in known] or [np.empty((c.size, self.size)) for c in comparisons]
        for done, (i, columns) in enumerate(zip(wanted, pool.map(column, wanted), strict=True), 1):
            for jacobian, moved, at in zip(out, columns, base, strict=True):
                jacobian[:, i] = (moved - at) / step[i]
            if progress is not None:
                progress(done / len(wanted))
        return out

    def _stand(self, comparisons, jacobians, predictions, theta, temper) -> _Stand:
        residuals = [c.residual(p) for c, p in zip(comparisons, predictions, strict=True)]
        sums = sums_of(comparisons, jacobians, residuals, temper)
        gram, _ = sums.gram()
        return _Stand(gram.yy + float(theta @ theta), gram.xx, gram.xy, sums)

    @staticmethod
    def _cost(comparisons, predictions, theta, temper) -> float:
        """The cost alone; see `_stand`."""
        residuals = [c.residual(p) for c, p in zip(comparisons, predictions, strict=True)]
        gram, _ = sums_of(comparisons, [np.empty((c.size, 0)) for c in comparisons], residuals, temper).gram()
        return gram.yy + float(theta @ theta)

    def _steps(self, theta: np.ndarray, difference: float) -> np.ndarray:
        """Step of each difference, towards the sheet's value."""
        return np.where(theta > 0.0, -difference, difference)

    def rms(self, predictions) -> dict[str, float]:
        """RMS of each signal over its noise, of the samples that were used; see `held_out.rms_over_noise`."""
        found = rms_over_noise(self.experiments, predictions, lambda _, signal: signal.binning.bin >= 0)
        return {name: rms for name, (rms, _) in found.items()}

    def _without(self, fit: Fit, refused: list[int]) -> Fit:
        """The fit with some unknowns put back to their prior mean, the others where they then fit best (Gaussian conditional).

        Standard deviations stay those with everything unknown, since what is put back is no better known.
        """
        cross = fit.covariance[:, refused] @ np.linalg.inv(fit.covariance[np.ix_(refused, refused)])
        theta = fit.theta - cross @ fit.theta[refused]
        theta[refused] = 0.0
        return replace(fit, theta=theta, predictions=self.predict(theta))

    def result(self, fit: Fit, asked: tuple[str, ...] = ()) -> Calibration:
        """Values in their units, and the rig that holds them; what was asked for and not informed keeps its prior."""
        spread = np.sqrt(np.diagonal(fit.covariance))
        back = [i for i, path in enumerate(self.paths) if path in asked and spread[i] > INFORMED]
        if back:
            fit = self._without(fit, back)
        names = ", ".join(e.recording.path for e in self.experiments)
        refused = {self.paths[i] for i in back}
        parameters, quantities = [], dict(self.rig.quantities)
        for path, deviation, share, scale in zip(self.paths, fit.theta, spread, self.scale, strict=True):
            quantity = self.rig.quantities[path]
            fitted = FittedParameter(path, quantity.unit, quantity.value, scale, quantity.value + deviation * scale,
                                     share * scale, bool(share < INFORMED))
            parameters.append(fitted)
            if path not in refused:
                quantities[path] = _fitted_quantity(quantity, fitted, names)
        rig_id = next((e.recording.rig.rig_id for e in self.experiments if e.recording.rig is not None), self.rig.rig_id)
        return Calibration(replace(self.rig, rig_id=rig_id, quantities=of_own_oil(quantities, self.rig.quantities)), parameters,
                           fit.covariance / np.outer(spread, spread), self.rms(fit.first), self.rms(fit.predictions),
                           fit.sweeps, fit.settled, sized(self.discrepancy, fit.allowances),
                           tuple(p for p in parameters if p.name in refused), bool(asked))


def _fitted_quantity(quantity: Quantity, fitted: FittedParameter, names: str) -> Quantity:
    source = f"fitted to {names}" if fitted.informed else f"{quantity.source}; not informed by {names}"
    return replace(quantity, value=fitted.value, std=fitted.std, source=source)


def sized(discrepancy: Discrepancy, allowances: dict[tuple, tuple[float, float]]) -> Discrepancy:
    """The same allowances with the size that a fit found them to have (one step of expectation maximisation), not below a third."""
    groups: dict[tuple[str, str], list[float]] = {}
    for name, (value, variance) in allowances.items():
        if name[1] in discrepancy.scale:
            groups.setdefault((name[0], name[1]), []).append(value * value + variance)
    own = {key: discrepancy.of(*key) * max(1.0 / 3.0, float(np.sqrt(np.mean(squares)))) for key, squares in groups.items()}
    return replace(discrepancy, own={**discrepancy.own, **own})
