"""Fit a rig's uncertain parameters to recordings: maximum a posteriori, with an honest covariance.

    minimise  sum_s w_s^2 sum_i ((y_si - f_si(theta)) / sigma_s)^2 + |theta|^2

theta are deviations in units of the sheet's tolerance (and of the sensors' offset tolerance), so
the second term is the prior. The weight of a signal, w_s = 1 / (rms_s sqrt(tau_s)), takes account
of what the model leaves: residuals larger than noise (rms_s > 1) and correlated over tau_s
samples carry as little information as that many independent ones. Gauss-Newton with a line
search; sensitivities by forward differences of the free run, whose fixed steps make it smooth.

Tarantola, Inverse Problem Theory, SIAM 2005, chapter 3, for the posterior (J^T J + I)^-1.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.experiment import PRESSURES, STROKE, Experiment
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.sheet import CUT, FIELD_OF_PATH

INFORMED = 0.9
"""A parameter whose standard deviation fell below this share of its prior was informed by the recordings."""
_DIFFERENCE = 1e-2  # of a tolerance
_SWEEPS = 12
_SETTLED = 0.02  # of a posterior standard deviation: no parameter moves further
_SETTLING = 5.0  # s at the beginning of a run that are left out: what moved before it began is not known
_LONGEST_CORRELATION = 400  # samples


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
    def moved(self) -> float:
        """How far it moved, in prior standard deviations."""
        return (self.value - self.prior) / self.prior_std


@dataclass(frozen=True)
class Calibration:
    """What a fit found.

    Attributes:
        rig: the rig with fitted values, standard deviations and sources; pressure and
            temperature offsets in ``offsets``.
        parameters, offsets: with prior and posterior.
        correlation: between all of them in that order, (k, k).
        before, after: RMS of each signal's residual over its noise, sheet and fit.
        sweeps: Gauss-Newton steps taken. settled: whether the last one was negligible.
    """

    rig: Rig
    parameters: list[FittedParameter]
    offsets: list[FittedParameter]
    correlation: np.ndarray
    before: dict[str, float]
    after: dict[str, float]
    sweeps: int
    settled: bool


def uncertain_paths(rig: Rig) -> list[str]:
    """Paths of the quantities that have a tolerance."""
    return [path for path, quantity in rig.quantities.items() if quantity.standard_deviation > 0.0]


def calibrate(experiments: Sequence[Experiment], rig: Rig, only: Sequence[str] = (), threads: int = 2,
              progress: Callable[[float], None] | None = None) -> Calibration:
    """Fit the rig to recordings of it.

    Args:
        experiments: recordings of one rig. rig: its sheet; values and tolerances are the prior.
        only: paths to fit; empty fits all that have a tolerance.
        threads: free runs side by side. progress: told the share done.

    Raises:
        CalibrationError: no recording, or a path that the sheet does not have or holds exact.
    """
    if not experiments:
        raise CalibrationError("no recording was given")
    problem = _Problem(experiments, rig, list(only) or uncertain_paths(rig))
    theta = np.zeros(problem.size)
    predicted = problem.predict(theta)
    before = problem.rms(predicted)
    settled, sweep = False, 0
    with ThreadPoolExecutor(max_workers=threads) as pool:
        for sweep in range(1, _SWEEPS + 1):
            weights = problem.weights(predicted)
            residual = problem.residual(predicted, weights)

            def column(i: int, theta=theta, weights=weights, residual=residual) -> np.ndarray:
                moved = theta.copy()
                moved[i] += _DIFFERENCE
                return (problem.residual(problem.predict(moved), weights) - residual) / _DIFFERENCE

            jacobian = np.empty((residual.size, problem.size))
            for i, values in enumerate(pool.map(column, range(problem.size))):
                jacobian[:, i] = values
                if progress is not None:
                    progress((sweep - 1 + (i + 1) / problem.size) / _SWEEPS)
            information = jacobian.T @ jacobian + np.eye(problem.size)
            step = -np.linalg.solve(information, jacobian.T @ residual + theta)
            theta, predicted, taken = _line_search(problem, theta, step, weights, residual)
            spread = np.sqrt(np.diagonal(np.linalg.inv(information)))
            if np.max(np.abs(taken) / spread) < _SETTLED or not taken.any():
                settled = bool(np.max(np.abs(step) / spread) < 10 * _SETTLED)
                break
    covariance = np.linalg.inv(information)
    if progress is not None:
        progress(1.0)
    return problem.result(theta, covariance, before, problem.rms(predicted), sweep, settled)


def _line_search(problem: _Problem, theta, step, weights, residual):
    cost = residual @ residual + theta @ theta
    for share in (1.0, 0.5, 0.25, 0.1, 0.03):
        trial = np.clip(theta + share * step, -3.0 * CUT, 3.0 * CUT)
        predicted = problem.predict(trial)
        left = problem.residual(predicted, weights)
        if left @ left + trial @ trial < cost:
            return trial, predicted, trial - theta
    return theta, problem.predict(theta), np.zeros_like(theta)


class _Problem:
    """Recordings, parameters and offsets as one vector."""

    def __init__(self, experiments: Sequence[Experiment], rig: Rig, paths: list[str]) -> None:
        for path in paths:
            if path not in rig.quantities:
                nearest = difflib.get_close_matches(path, list(rig.quantities), 1, 0.0)[0]
                raise CalibrationError(f"{path}: no such parameter; the nearest is {nearest!r}")
            if rig.quantities[path].standard_deviation == 0.0:
                raise CalibrationError(f"{path}: the sheet holds it exact (tolerance 0), there is nothing to fit")
        self.experiments, self.rig, self.paths = experiments, rig, paths
        self.offsets = [name for name in dict.fromkeys(n for e in experiments for n in e.signals)
                        if name in PRESSURES or name.startswith("temperature/")]
        self.size = len(paths) + len(self.offsets)
        self._offset_std = np.array([self._sensor(name).offset_tolerance for name in self.offsets])
        self._used = [{name: np.isfinite(signal.measured) & ((signal.time > _SETTLING) | (name == STROKE))
                       for name, signal in e.signals.items()} for e in experiments]

    def _sensor(self, name: str):
        return self.rig.sensors["pressure" if name in PRESSURES else "temperature"]

    def predict(self, theta: np.ndarray) -> list[dict[str, np.ndarray]]:
        """Predictions of every recording."""
        parameters = self.rig.parameters
        offsets = dict(zip(self.offsets, theta[len(self.paths):] * self._offset_std, strict=True))
        out = []
        for experiment in self.experiments:
            parameters["load_payload_mass"] = experiment.payload
            own = parameters.copy()
            for i, path in enumerate(self.paths):
                quantity = self.rig.quantities[path]
                scale = own["load_payload_mass"] / quantity.value if path == "load.payload_mass" else 1.0
                own[FIELD_OF_PATH[path]] += theta[i] * quantity.standard_deviation * scale
            out.append(experiment.predict(own, offsets))
        return out

    def _pieces(self, predicted):
        """Name and normalised residual of every signal of every recording."""
        for experiment, used, values in zip(self.experiments, self._used, predicted, strict=True):
            for name, signal in experiment.signals.items():
                chosen = used[name]
                yield name, (signal.measured[chosen] - values[name][chosen]) / signal.noise

    def weights(self, predicted) -> list[float]:
        """w_s of every signal of every recording."""
        return [1.0 / np.sqrt(max(1.0, np.mean(r * r)) * correlation_length(r)) if r.size else 0.0 for _, r in self._pieces(predicted)]

    def residual(self, predicted, weights: list[float]) -> np.ndarray:
        """Weighted residuals as one vector."""
        return np.concatenate([-w * r for w, (_, r) in zip(weights, self._pieces(predicted), strict=True)])

    def rms(self, predicted) -> dict[str, float]:
        """RMS of each signal over its noise, all recordings together."""
        squares: dict[str, list[np.ndarray]] = {}
        for name, r in self._pieces(predicted):
            squares.setdefault(name, []).append(r * r)
        return {name: float(np.sqrt(np.mean(np.concatenate(parts)))) for name, parts in squares.items() if sum(p.size for p in parts)}

    def result(self, theta, covariance, before, after, sweeps, settled) -> Calibration:
        """Values in their units, and the rig that holds them."""
        spread = np.sqrt(np.diagonal(covariance))
        names = ", ".join(e.recording.path for e in self.experiments)
        parameters, quantities = [], dict(self.rig.quantities)
        for i, path in enumerate(self.paths):
            quantity = self.rig.quantities[path]
            scale = quantity.standard_deviation
            fitted = FittedParameter(path, quantity.unit, quantity.value, scale, quantity.value + theta[i] * scale,
                                     spread[i] * scale, bool(spread[i] < INFORMED))
            parameters.append(fitted)
            source = f"fitted to {names}" if fitted.informed else f"{quantity.source}; not informed by {names}"
            quantities[path] = replace(quantity, value=fitted.value, std=fitted.std, source=source,
                                       tolerance=fitted.std / abs(fitted.value) if fitted.value else 0.0)
        offsets = []
        for j, name in enumerate(self.offsets):
            i, scale = len(self.paths) + j, self._offset_std[j]
            offsets.append(FittedParameter(name, "Pa" if name in PRESSURES else "K", 0.0, scale, theta[i] * scale,
                                           spread[i] * scale, bool(spread[i] < INFORMED)))
        rig_id = next((e.recording.rig.rig_id for e in self.experiments if e.recording.rig is not None), self.rig.rig_id)
        return Calibration(replace(self.rig, rig_id=rig_id, quantities=quantities), parameters, offsets,
                           covariance / np.outer(spread, spread), before, after, sweeps, settled)


def correlation_length(residual: np.ndarray) -> float:
    """Samples over which a residual repeats itself: 1 + 2 sum of its autocorrelation up to the first that is below 0.05."""
    n = residual.size
    power = float(np.mean(residual * residual)) if n else 0.0
    if n < 16 or power == 0.0:
        return 1.0
    most = min(_LONGEST_CORRELATION, n // 4)
    size = 1 << int(np.ceil(np.log2(n + most)))
    spectrum = np.fft.rfft(residual, size)
    autocorrelation = np.fft.irfft(spectrum * np.conj(spectrum), size)[:most] / (n * power)
    below = np.flatnonzero(autocorrelation < 0.05)
    return float(1.0 + 2.0 * autocorrelation[1: below[0] if below.size else most].sum())
