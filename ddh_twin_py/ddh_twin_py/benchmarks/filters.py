"""The generic Kalman step beside other filters: 15 states, 6 readings, 8 inputs."""

from __future__ import annotations

import time

import numba
import numpy as np

from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.benchmarks.tools import NotThere, tool
from ddh_twin_py.estimation.fusion.kalman_kernel import kalman_step
from ddh_twin_py.physics.compiled import kernel

STATES, READINGS, INPUTS = 15, 6, 8
LIMIT = 3.0
"""µs a step."""


class Case:
    """A stable random system and its readings, the same for every filter."""

    def __init__(self, steps: int, seed: int = 1) -> None:
        rng = np.random.default_rng(seed)
        raw = rng.normal(size=(STATES, STATES))
        self.transition = 0.98 * raw / np.abs(np.linalg.eigvals(raw)).max()
        self.input_matrix = rng.normal(size=(STATES, INPUTS))
        root = 0.1 * rng.normal(size=(STATES, STATES))
        self.process = root @ root.T + 1e-3 * np.eye(STATES)
        self.reading_matrix = rng.normal(size=(READINGS, STATES))
        self.noise = rng.uniform(0.05, 0.2, READINGS)
        self.control = rng.normal(size=(steps, INPUTS))
        self.readings = rng.normal(size=(steps, READINGS))


@kernel
def _sequential(x, covariance, transition, input_matrix, process, reading_matrix, noise, control, readings):
    work = np.empty((2 * x.shape[0] + 1, x.shape[0]))
    for k in range(readings.shape[0]):
        kalman_step(x, covariance, transition, input_matrix, process, reading_matrix, noise, control[k], readings[k], work)


@numba.njit
def _with_blas(x, covariance, transition, input_matrix, process, reading_matrix, noise, control, readings):
    identity, spread = np.eye(x.shape[0]), np.diag(noise)
    for k in range(readings.shape[0]):
        x = transition @ x + input_matrix @ control[k]
        covariance = transition @ covariance @ transition.T + process
        crossed = covariance @ reading_matrix.T
        gain = np.linalg.solve(reading_matrix @ crossed + spread, np.ascontiguousarray(crossed.T)).T
        x = x + gain @ (readings[k] - reading_matrix @ x)
        covariance = (identity - gain @ reading_matrix) @ covariance
        covariance = 0.5 * (covariance + covariance.T)  # without it the filter drifts off within 300 steps
    return x, covariance


def sequential(case: Case) -> tuple[np.ndarray, np.ndarray, float]:
    """The project's step: mean, covariance, seconds."""
    kept = np.zeros(STATES), np.eye(STATES)
    matrices = case.transition, case.input_matrix, case.process, case.reading_matrix, case.noise
    _sequential(*(part.copy() for part in kept), *matrices, case.control[:1], case.readings[:1])
    started = time.perf_counter()
    _sequential(*kept, *matrices, case.control, case.readings)
    return *kept, time.perf_counter() - started


def with_blas(case: Case) -> tuple[np.ndarray, np.ndarray, float]:
    """The textbook step in numba, whose products and solve are BLAS and LAPACK."""
    matrices = case.transition, case.input_matrix, case.process, case.reading_matrix, case.noise
    _with_blas(np.zeros(STATES), np.eye(STATES), *matrices, case.control[:1], case.readings[:1])
    started = time.perf_counter()
    x, covariance = _with_blas(np.zeros(STATES), np.eye(STATES), *matrices, case.control, case.readings)
    return x, covariance, time.perf_counter() - started


def with_filterpy(case: Case) -> tuple[np.ndarray, np.ndarray, float]:
    """filterpy.

    Raises:
        NotThere: it is not.
    """
    tool("filterpy")
    kalman = tool("filterpy.kalman")
    other = kalman.KalmanFilter(dim_x=STATES, dim_z=READINGS, dim_u=INPUTS)
    other.x, other.P = np.zeros(STATES), np.eye(STATES)
    other.F, other.B, other.Q, other.H, other.R = case.transition, case.input_matrix, case.process, case.reading_matrix, np.diag(case.noise)
    started = time.perf_counter()
    for control, readings in zip(case.control, case.readings, strict=True):
        other.predict(u=control)
        other.update(readings)
    return other.x, other.P, time.perf_counter() - started


def compare_filters(steps: int) -> tuple[list[Figure], list[str]]:
    """Figures of the step beside the others, and what was left out, with the reason."""
    case = Case(steps)

    def microseconds(filter_run, repeats: int) -> float:
        return min(filter_run(case)[2] for _ in range(repeats)) / steps * 1e6

    own = microseconds(sequential, 5)
    name = f"Kalman step, {STATES} states, {READINGS} readings"
    figures = [
        Figure(name, own, "µs", LIMIT, "limit"),
        Figure(f"{name}, beside numba with BLAS", own, "µs", microseconds(with_blas, 3), "numba with BLAS here"),
    ]
    try:
        figures.append(Figure(f"{name}, beside filterpy", own, "µs", microseconds(with_filterpy, 1), "filterpy here"))
    except NotThere as reason:
        return figures, [f"filterpy: {reason}"]
    return figures, []
