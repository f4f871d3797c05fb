"""Fixed-interval smoother: temperatures and unknown heats of a recording from the readings before and after each instant.

The filter writes a `Trace` of its steps, `smooth` goes back through it with the adjoint recursion
of the modified Bryson-Frazier smoother, which gives what Rauch, Tung and Striebel's gives without
inverting a covariance. With the adjoint l and L (both zero after the last step), back through

    a reading   l <- -H^T r / s + (I - K H)^T l,   L <- H^T H / s + (I - K H)^T L (I - K H)
    a movement  l <- F^T l,                        L <- F^T L F

the smoothed state at a step with mean x and covariance P is x - P l, its covariance P - P L P; r is
the reading's innovation, s its variance, K its gain, H picks the sensor's lagged reading and offset.

Bierman, Fixed interval smoothing with discrete measurements, Int. J. Control 18 (1973) 65.
"""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fusion.uncertain_parameters import N_UNKNOWN_HEATS, UNKNOWN_HEAT_AT, UNKNOWN_HEAT_TIME
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.physics.thermal_network import N

_BLOCK = 256  # steps that are kept in memory
SMOOTHED_EVERY = 2.0
"""s between two smoothed temperatures; the filter's readings are all used."""


@dataclass(slots=True)
class _Step:
    """One epoch of the filter: its movement, its readings, and (at some) the estimate after it."""

    elapsed: float
    transition: np.ndarray  # float32, (d, d + parameters)
    gains: np.ndarray  # float32, (r, size)
    sensor: np.ndarray
    innovation: np.ndarray
    variance: np.ndarray
    row: int = -1  # index of the interval whose estimate this is; -1: none is kept
    mean: np.ndarray | None = None  # temperatures, K, and unknown heats, W, (N + N_UNKNOWN_HEATS,)
    covariance: np.ndarray | None = None  # their rows, (N + N_UNKNOWN_HEATS, size)


@dataclass(frozen=True)
class Smoothed:
    """What the smoother says.

    Attributes:
        row: intervals, (k,). temperature, temperature_std: K, (k, N), order `thermal_network.NODES`.
        heat, heat_std: W, (k, N_UNKNOWN_HEATS), order `uncertain_parameters.UNKNOWN_HEATS`.
    """

    row: np.ndarray
    temperature: np.ndarray
    temperature_std: np.ndarray
    heat: np.ndarray
    heat_std: np.ndarray


class Trace:
    """What the smoother needs of a filter's run: about 25 kB per second of data, in a temporary file but for the last minutes.

    Args:
        every: filter epochs between two smoothed temperatures.
    """

    def __init__(self, every: int = 1) -> None:
        self.every = max(1, every)
        self._steps: list[_Step] = []  # the last ones
        self._file = tempfile.TemporaryFile(prefix="ddh_twin_trace_")
        self._places: list[int] = []  # where each block of `_BLOCK` steps before them lies
        self._size = 0
        self._forgotten: dict[int, list[int]] = {}
        self._since = 0

    def __len__(self) -> int:
        return len(self._places) * _BLOCK + len(self._steps)

    @property
    def nbytes(self) -> tuple[int, int]:
        """Bytes of the arrays in memory, and of the file."""
        arrays = (a for s in self._steps for a in (s.transition, s.gains, s.mean, s.covariance) if a is not None)
        return sum(a.nbytes for a in arrays), self._file.seek(0, 2)

    def _backward(self) -> Iterator[tuple[int, _Step]]:
        """All steps with their numbers, the last one first."""
        yield from reversed(list(enumerate(self._steps, len(self._places) * _BLOCK)))
        for block in range(len(self._places) - 1, -1, -1):
            self._file.seek(self._places[block])
            yield from reversed(list(enumerate(pickle.load(self._file), block * _BLOCK)))

    def forget(self, *states: int) -> None:
        """States were replaced by such that have nothing to do with them."""
        self._forgotten.setdefault(len(self), []).extend(states)

    def moved(self, elapsed: float, transition: np.ndarray) -> None:
        """The filter moved by ``elapsed`` seconds."""
        if len(self._steps) == _BLOCK:
            self._places.append(self._file.seek(0, 2))
            pickle.dump(self._steps, self._file, pickle.HIGHEST_PROTOCOL)
            self._steps = []
        self._size = size = transition.shape[1] + transition.shape[0] - N  # the offsets, one per sensor, do not move the rest
        none, gains = np.empty(0), np.empty((0, size), np.float32)
        self._steps.append(_Step(elapsed, transition.astype(np.float32), gains, none.astype(np.int64), none, none))

    def read(self, gains: np.ndarray, sensor: np.ndarray, innovation: np.ndarray, spread: np.ndarray) -> None:
        """Readings were applied after the last movement, in this order."""
        step = self._steps[-1]
        step.gains, step.sensor = gains.astype(np.float32), sensor.copy()
        step.innovation, step.variance = innovation.copy(), spread**2

    def estimated(self, row: int, dynamic: np.ndarray, heat: np.ndarray, covariance: np.ndarray) -> None:
        """The estimate after the last step, at interval ``row``; kept now and then.

        Args:
            dynamic: begins with the temperatures, K. heat: the unknown heats, W, the last rows of the covariance (size, size).
        """
        self._since += 1
        if self._since >= self.every and self._steps:
            step, self._since = self._steps[-1], 0
            kept = np.r_[:N, covariance.shape[0] - N_UNKNOWN_HEATS : covariance.shape[0]]
            step.row, step.mean, step.covariance = row, np.concatenate([dynamic[:N], heat]), covariance[kept]

    def covariances(self) -> tuple[np.ndarray, np.ndarray]:
        """Intervals (k,) of the estimates kept, and the filter's covariances of their temperatures, K^2, (k, N, N)."""
        kept = [step for _, step in self._backward() if step.covariance is not None][::-1]
        return np.array([step.row for step in kept]), np.array([step.covariance[:N, :N] for step in kept]).reshape(-1, N, N)

    def smooth(self) -> Smoothed:
        """All that was kept, in order of time."""
        wide = N + N_UNKNOWN_HEATS
        first, second = np.zeros(self._size), np.zeros((self._size, self._size))
        rows: list[int] = []
        means: list[np.ndarray] = []
        deviations: list[np.ndarray] = []
        for k, step in self._backward():
            for state in self._forgotten.get(k + 1, ()):
                first[state] = second[state, :] = second[:, state] = 0.0
            if step.mean is not None:
                rows.append(step.row)
                means.append(step.mean - step.covariance @ first)
                own = np.concatenate([np.diagonal(step.covariance[:N]), np.diagonal(step.covariance[N:, -N_UNKNOWN_HEATS:])])
                variance = own - np.einsum("ij,ij->i", step.covariance @ second, step.covariance)
                deviations.append(np.sqrt(np.maximum(variance, 0.0)))
            back(first, second, step.transition.astype(np.float64), step.elapsed, step.gains.astype(np.float64), step.sensor,
                 step.innovation, step.variance)
        mean, deviation = (np.array(column[::-1]).reshape(-1, wide) for column in (means, deviations))
        return Smoothed(np.array(rows[::-1], np.int64), mean[:, :N], deviation[:, :N], mean[:, N:], deviation[:, N:])


@kernel
def back(first, second, transition, elapsed, gains, sensor, innovation, variance):
    """Take the adjoint (size,) and (size, size) back through one epoch, in place: readings, then the movement."""
    d, width = transition.shape
    size = first.shape[0]
    offset, parameter = d, size - (width - d)
    pushed = np.empty(size)
    for r in range(sensor.shape[0] - 1, -1, -1):
        k, s = sensor[r], variance[r]
        reading, zero = N + k, offset + k
        gain = gains[r] / s
        share = 0.0
        for i in range(size):
            share += gain[i] * first[i]
        first[reading] -= share + innovation[r] / s
        first[zero] -= share + innovation[r] / s
        total = 1.0 / s
        for i in range(size):
            value = 0.0
            for j in range(size):
                value += second[i, j] * gain[j]
            pushed[i] = value
        for i in range(size):
            total += gain[i] * pushed[i]
        for i in range(size):
            second[i, reading] -= pushed[i]
            second[i, zero] -= pushed[i]
        for j in range(size):
            second[reading, j] -= pushed[j]
            second[zero, j] -= pushed[j]
        second[reading, reading] += total
        second[reading, zero] += total
        second[zero, reading] += total
        second[zero, zero] += total
    kept = np.exp(-elapsed / UNKNOWN_HEAT_TIME)
    heats = parameter + UNKNOWN_HEAT_AT
    column = np.dot(np.ascontiguousarray(second[:, :d]), transition)  # (size, width)
    for i in range(size):
        for j in range(d):
            second[i, j] = column[i, j]
        for j in range(heats, heats + N_UNKNOWN_HEATS):
            second[i, j] *= kept
        for j in range(d, width):
            second[i, parameter + j - d] += column[i, j]
    row = np.dot(transition.T, np.ascontiguousarray(second[:d]))  # (width, size)
    for j in range(size):
        for i in range(d):
            second[i, j] = row[i, j]
        for i in range(heats, heats + N_UNKNOWN_HEATS):
            second[i, j] *= kept
        for i in range(d, width):
            second[parameter + i - d, j] += row[i, j]
    for i in range(size):
        for j in range(i):
            mean = 0.5 * (second[i, j] + second[j, i])
            second[i, j] = mean
            second[j, i] = mean
    moved = np.dot(transition.T, np.ascontiguousarray(first[:d]))
    for i in range(heats, heats + N_UNKNOWN_HEATS):
        first[i] *= kept
    first[:d] = moved[:d]
    for i in range(d, width):
        first[parameter + i - d] += moved[i]
