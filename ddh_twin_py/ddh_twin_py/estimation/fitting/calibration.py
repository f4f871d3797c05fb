"""Calibration: a rig's uncertain parameters fitted to recordings of it, with an honest covariance and what was not learnt.

The fit itself is in `problem`, what it does not know in `unknowns`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Discrepancy, sized
from ddh_twin_py.estimation.fitting.experiment import STROKE, Experiment
from ddh_twin_py.estimation.fitting.problem import RESTARTS, Fit, Problem
from ddh_twin_py.estimation.fitting.unknowns import offset_paths, uncertain_paths, with_offsets
from ddh_twin_py.names import nearest
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.own_oil import of_own_oil
from ddh_twin_py.rig.payload import of_declared_payload
from ddh_twin_py.rig.sheet import BOUNDS, CUT, Quantity
from ddh_twin_py.telemetry.recording import Recording, announced_id
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC

_ROUNDING = 1.0e-9  # of a quantity, below which what is left of it is none
INFORMED = 0.9
"""A parameter whose standard deviation fell below this share of its prior was informed by the recordings."""


_AT_END = 0.01  # deviations from the end of its tolerance within which a parameter is pressed against it
_SAME_SAMPLES = 20  # all fields alike at the same stamp: no chance meeting of two recordings


class CalibrationError(ValueError):
    """A fit that cannot be made; the message names what was asked for and what is possible."""


@dataclass(frozen=True)
class FittedParameter:
    """One parameter: prior and posterior in ``unit``, and whether the recordings said anything about it.

    Attributes:
        cut: standard deviations of its prior beyond which it is not fitted.
    """

    name: str
    unit: str
    prior: float
    prior_std: float
    value: float
    std: float
    informed: bool
    cut: float = CUT

    @property
    def share(self) -> float:
        """Standard deviation after over before; 1 is nothing learnt."""
        return self.std / self.prior_std

    @property
    def moved(self) -> float:
        """How far it moved, in prior standard deviations."""
        return (self.value - self.prior) / self.prior_std

    @property
    def at_end(self) -> bool:
        """Whether it is pressed against the end of its tolerance, which is as far as a fit may go."""
        return abs(self.moved) > self.cut - _AT_END


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
            their prior. asked: paths where only some were asked for; all others were held exact.
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
    asked: tuple[str, ...] = ()

    def together(self, least: float = 0.95) -> list[tuple[str, str, float]]:
        """Pairs of which only a combination is informed: names and correlation, |r| above ``least``, closest first."""
        names = [parameter.name for parameter in self.parameters]
        rows, columns = np.nonzero(np.triu(np.abs(self.correlation) > least, 1))
        pairs = [(names[i], names[j], float(self.correlation[i, j])) for i, j in zip(rows, columns, strict=True)]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))


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
        fit = problem.fit(pool, progress, restarts=RESTARTS)
    if progress is not None:
        progress(1.0)
    return _told(problem, fit, tuple(only))


def _check_recordings(experiments: Sequence[Experiment]) -> None:
    """Refuse recordings of several rigs, and those that no free run can be made of or compared with."""
    for e in experiments:
        for topic, stream, column, why in ((DRIVE_TOPIC, e.recording.drive, "speed_command", "needs it"),
                                           (HYDRAULIC_TOPIC, e.recording.hydraulic, STROKE, "starts from it and is put back to it")):
            if not np.isfinite(stream.column(column)).any():
                raise CalibrationError(f"{e.recording.path}: {e.recording.namespace}/{topic} {column}: no finite value; a free run {why}")
        if not any((signal.binning.bin >= 0).any() for signal in e.signals.values()):
            raise CalibrationError(f"{e.recording.path}: no usable sample of any signal; there is nothing to fit to")
    named = [e.recording for e in experiments if e.recording.rig is not None and e.recording.rig.rig_id]
    for other in named[1:]:
        if other.rig.rig_id != named[0].rig.rig_id:
            raise CalibrationError(f"{named[0].path} is of rig {named[0].rig.rig_id!r} and {other.path} of rig {other.rig.rig_id!r}; "
                                   "a fit takes recordings of one rig")
    _check_samples([e.recording for e in experiments])


def _check_samples(recordings: Sequence[Recording]) -> None:
    """Refuse recordings that hold the same samples: what they have in common would count twice."""
    for k, one in enumerate(recordings):
        for other in recordings[:k]:
            stamps = [recording.drive.stamps(recording.epoch_ns) for recording in (one, other)]
            found, at, there = np.intersect1d(*stamps, return_indices=True)
            told, there_told = one.drive.values[at], other.drive.values[there]
            alike = (told == there_told) | (np.isnan(told) & np.isnan(there_told))
            same = alike.all(axis=1) & np.isfinite(told).any(axis=1)
            if same.sum() >= _SAME_SAMPLES:
                raise CalibrationError(f"{other.path} and {one.path}: {one.namespace}/{DRIVE_TOPIC}: {int(same.sum())} samples are in "
                                       "both and would count twice; give one of the two")


def check_paths(rig: Rig, paths: Sequence[str]) -> list[str]:
    """The paths, where all can be fitted.

    Raises:
        CalibrationError: unknown path (with the nearest valid one), or one that the sheet holds exact.
    """
    for path in paths:
        if path not in rig.quantities:
            raise CalibrationError(f"{path}: no such parameter{nearest(path, rig.quantities)}")
        if rig.quantities[path].standard_deviation == 0.0:
            raise CalibrationError(f"{path}: {rig.file} holds it exact (tolerance 0), there is nothing to fit")
    return list(paths)


def _without(problem: Problem, fit: Fit, refused: list[int]) -> Fit:
    """The fit with some unknowns put back to their prior mean, the others where they then fit best (Gaussian conditional).

    Standard deviations stay those with everything unknown, since what is put back is no better known.
    """
    cross = fit.covariance[:, refused] @ np.linalg.inv(fit.covariance[np.ix_(refused, refused)])
    theta = fit.theta - cross @ fit.theta[refused]
    theta[refused] = 0.0
    return replace(fit, theta=theta, predictions=problem.predict(theta))


def _told(problem: Problem, fit: Fit, asked: tuple[str, ...]) -> Calibration:
    """Values in their units, and the rig that holds them; what was asked for and not informed keeps its prior."""
    spread, rig = fit.spread, problem.rig
    back = [i for i, path in enumerate(problem.paths) if path in asked and spread[i] > INFORMED]
    if back:
        fit = _without(problem, fit, back)
    names = ", ".join(e.recording.path for e in problem.experiments)
    refused = {problem.paths[i] for i in back}
    parameters, quantities = [], dict(rig.quantities)
    for path, deviation, share, scale in zip(problem.paths, fit.theta, spread, problem.scale, strict=False):  # begins are not the rig's
        quantity = rig.quantities[path]
        value = quantity.value + deviation * scale
        for end in (0.0, BOUNDS[path].lowest, BOUNDS[path].highest):
            if abs(value - end) < _ROUNDING * abs(quantity.value):
                value = end  # a tolerance that reaches as far as zero, or as a bound, ends there, not a hair beyond
        fitted = FittedParameter(path, quantity.unit, quantity.value, scale, value, share * scale, bool(share < INFORMED))
        parameters.append(fitted)
        if path not in refused:
            quantities[path] = _fitted_quantity(quantity, fitted, names)
    rig_id = announced_id(e.recording for e in problem.experiments) or rig.rig_id
    written = of_declared_payload(of_own_oil(quantities, rig.quantities), rig.quantities)
    correlation = (fit.covariance / np.outer(spread, spread))[: len(parameters), : len(parameters)]
    return Calibration(replace(rig, rig_id=rig_id, quantities=written), parameters, correlation, problem.rms(fit.first),
                       problem.rms(fit.predictions),
                       fit.sweeps, fit.settled, sized(problem.discrepancy, fit.allowances),
                       tuple(p for p in parameters if p.name in refused), asked)


def _fitted_quantity(quantity: Quantity, fitted: FittedParameter, names: str) -> Quantity:
    source = f"fitted to {names}" if fitted.informed else f"{quantity.source}; not informed by {names}"
    return replace(quantity, value=fitted.value, std=fitted.std, source=source)
