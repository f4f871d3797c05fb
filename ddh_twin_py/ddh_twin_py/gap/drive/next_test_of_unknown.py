"""The test that would best show what an unknown cause depends on: the one that varies most what it seems to vary with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.gap.contract import NextTest
from ddh_twin_py.gap.drive.direct_drive import STEP, DirectDrive
from ddh_twin_py.gap.drive.next_test import trials
from ddh_twin_py.gap.drive.rehearsed_trial import RehearsedTrial
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.next_test.beliefs import belief_in
from ddh_twin_py.gap.next_test.proposal import TOO_LITTLE, described
from ddh_twin_py.gap.next_test.separating import Believed
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import TANK

VARIABLES = ("oil temperature", "speed")
"""What a test can vary at will."""
_FARTHEST = 2.0  # ranges of the recordings to which what they show is carried on


def next_test_of_unknown(model: DirectDrive, found: Found, ids: tuple[str, ...], signal: str, size: float,
                         depends_on: Sequence[str]) -> NextTest | None:
    """What to do next where no listed effect explains a gap, by the contract: description, between, expected_separation.

    The cause either grows with the variable, as seen over the range of the recordings, or is the same
    at any value of it; the expected log Bayes factor between the two is that of a test in which the
    signal is off by its size times (v - mean)/range, at most `_FARTHEST` times, any constant being free.

    Args:
        model, found: of the case. ids: the best listed set. signal: that is off most, and size: by how much, RMS in
            multiples of its noise. depends_on: variables, strongest first; the first of `VARIABLES` among them is asked
            about, else the oil's temperature.

    Returns:
        None where no candidate tells more.
    """
    belief = belief_in(found, ids)
    variable = next((name for name in depends_on if name in VARIABLES), VARIABLES[0])
    middle, reach = _range(model, belief, variable)
    best, description, seen = TOO_LITTLE, "", (0.0, 0.0)
    for trial, options in trials(model, found, belief):
        trial.features(belief.theta, belief.acting)
        values = _values(trial.experiment, trial.record(belief.theta, belief.acting), variable)
        apart = _apart(trial, trial.rows(options[0].sensors), signal, size, np.clip((values - middle) / reach, -_FARTHEST, _FARTHEST))
        if apart > best:
            best, description, seen = apart, options[0].words, (float(values.min()), float(values.max()))
    if not description:
        return None
    low, high, unit = _shown(variable, seen)
    return {
        "description": f"{described(description, round(best, 2))} The {variable} then goes from {low:.0f} to {high:.0f} {unit}.",
        "between": [f"unknown, growing with the {variable}", f"unknown, the same at any {variable}"],
        "expected_separation": round(best, 2)}


def _values(experiment: Experiment, record: np.ndarray, variable: str) -> np.ndarray:
    """A variable over a run's intervals, SI, (n,)."""
    points, temperatures = experiment.operating(record, STEP)
    return temperatures[:, TANK] if variable == "oil temperature" else points["speed_absolute"]


def _range(model: DirectDrive, belief: Believed, variable: str) -> tuple[float, float]:
    """Mean of a variable over the recordings in question and how far it goes from there, SI."""
    values = np.concatenate([_values(experiment, model.record(number, belief.theta, belief.acting), variable)
                             for number, experiment in enumerate(model.field, model.first)])
    return float(values.mean()), max(float(np.abs(values - values.mean()).max()), 1e-6)


def _apart(trial: RehearsedTrial, kept: np.ndarray, signal: str, size: float, share: np.ndarray) -> float:
    """Expected log Bayes factor where the signal is off by ``size`` times ``share``, (n,), against any constant, on rows ``kept``."""
    block = next((b for b in trial.comparison.blocks if b.signal == signal), None)
    if block is None:
        return 0.0
    one = np.zeros(trial.comparison.size)
    one[block.rows] = trial.comparison.noise(signal) / block.spread
    off = one.copy()
    off[block.rows] *= size * np.interp(block.binning.time, trial.experiment.axis, share)
    return trial.apart(off, 1e3 * one[:, None], kept)


def _shown(variable: str, seen: tuple[float, float]) -> tuple[float, float, str]:
    if variable == "oil temperature":
        return seen[0] - ZERO_CELSIUS, seen[1] - ZERO_CELSIUS, "degC"
    return seen[0] / RAD_PER_S_OF_RPM, seen[1] / RAD_PER_S_OF_RPM, "rpm"
