"""How far held-out data are off under a hypothesis where all that is left open is taken at its best.

What fitted recordings left open of a rig, and how a recording of which too little is read begins, moves a free run on another
duty; a hypothesis is not to blame for it. What still is off then, is off whatever these are: a check of the hypothesis against
new data with its nuisances profiled out (posterior predictive check; Gelman, Meng & Stern, Statistica Sinica 6 (1996) 733).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ddh_twin_py.gap.held_runs import ratios_of
from ddh_twin_py.gap.model import Acting, Held
from ddh_twin_py.gap.size import of_all

_OPEN = 0.3  # deviations: what is known better than that does not move
_DIFFERENCE = 0.05  # deviations
_SAMPLES = 2000  # of a signal at most that a step is computed from
_WEIGHT = 10.0  # of a signal's mean square against one deviation: as many independent samples has it at least
_STEPS, _SHARES, _SETTLED = 3, (1.0, 0.4, 0.15), 0.05  # steps, what is tried of each, cost that one must gain

Runs = list[dict[str, np.ndarray]]


@dataclass(frozen=True)
class AtBest:
    """Held-out data beside a hypothesis where what is open is at its best for them.

    Attributes:
        over: RMS over floor of each signal. theta: parameters there, in deviations, (k,).
    """

    over: dict[str, float]
    theta: np.ndarray

    @property
    def gap(self) -> float:
        """Of all signals, in multiples of the floor; see `size.of_all`."""
        return of_all(self.over)


class HeldBest:
    """Held-out data with what is open of rig and begin.

    Args:
        held: the data. floor: of each signal, in multiples of its noise. within: keeps parameters (k,) to their bounds.
        theta: parameters about which sensitivities are taken, in deviations, (k,). covariance: what is open of them, (k, k).
    """

    def __init__(self, held: Held, floor: Mapping[str, float], within: Callable[[np.ndarray], np.ndarray], theta: np.ndarray,
                 covariance: np.ndarray) -> None:
        self._held, self._floor, self._within = held, floor, within
        free = np.flatnonzero(np.sqrt(np.maximum(np.diagonal(covariance), 0.0)) > _OPEN)
        self._ends = np.cumsum(held.open_begins())
        p, b = free.size, int(self._ends[-1])
        self._precision = np.eye(p + b)
        if p:
            prior = covariance[np.ix_(free, free)]
            self._precision[:p, :p] = np.linalg.inv(prior + 1.0e-6 * np.eye(p))
        of_rig = [(np.eye(theta.size)[i], np.zeros(b)) for i in free]
        self._of_begin = [(np.zeros(theta.size), way) for way in np.eye(b)]
        self._moves = of_rig + self._of_begin
        used = [{name: _spread_out(held.mask()(s)) for name, s in own.items()} for own in held.signals()]
        self._used = [{name: index for name, index in own.items() if index.size} for own in used]
        self._slopes = self._sensitivities(theta, (), of_rig, self._run(theta, (), np.zeros(len(self._moves))))

    def beside(self, theta: np.ndarray, acting: Acting, closely: bool = False) -> AtBest:
        """The data beside a hypothesis.

        Args:
            theta: parameters that a fit found, (k,). acting: effects. closely: take sensitivities anew where the first steps lead; a
                valve may be open there that is shut where they were taken.
        """
        z = np.zeros(len(self._moves))
        runs = self._run(theta, acting, z)
        of_begin = self._sensitivities(theta, acting, self._of_begin, runs)  # the warmth of oil bends, and what acts bends it
        slopes = [{name: np.hstack([own[name], begin[name]]) for name in own} for own, begin in zip(self._slopes, of_begin, strict=True)]
        z, runs = self._descended(theta, acting, z, runs, slopes)
        if closely:
            z, runs = self._descended(theta, acting, z, runs, self._sensitivities(theta, acting, self._moves, runs, z))
        return AtBest({name: ratio / self._floor[name] for name, ratio in ratios_of(self._held, runs).items()}, self._at(theta, z)[0])

    def _descended(self, theta: np.ndarray, acting: Acting, z: np.ndarray, runs: Runs, slopes: Runs) -> tuple[np.ndarray, Runs]:
        """Where a few steps with the same sensitivities lead, and the runs there."""
        cost = self._cost(runs, z)
        for _ in range(_STEPS):
            step, gained = self._step(runs, z, slopes), 0.0
            for share in _SHARES:
                tried = z + share * step
                other = self._run(theta, acting, tried)
                reached = self._cost(other, tried)
                if reached < cost:
                    gained, z, runs, cost = cost - reached, tried, other, reached
                    break
            if gained < _SETTLED:
                break
        return z, runs

    def _run(self, theta: np.ndarray, acting: Acting, z: np.ndarray) -> Runs:
        moved, begin = self._at(theta, z)
        return self._held.run(moved, acting, self._by_recording(begin))

    def _at(self, theta: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Parameters (k,) and begins of all recordings after moves."""
        moved = theta + sum((x * by for x, (by, _) in zip(z, self._moves, strict=True)), np.zeros(theta.size))
        return self._within(moved), sum((x * by for x, (_, by) in zip(z, self._moves, strict=True)), np.zeros(self._ends[-1]))

    def _by_recording(self, begin: np.ndarray) -> list[np.ndarray]:
        return np.split(begin, self._ends[:-1])

    def _off(self, runs: Runs) -> Runs:
        """Residuals over floors of the samples that are used, by recording."""
        return [{name: (s[name].measured[i] - run[name][i]) / (s[name].noise * self._floor[name]) for name, i in used.items()}
                for used, s, run in zip(self._used, self._held.signals(), runs, strict=True)]

    def _cost(self, runs: Runs, z: np.ndarray) -> float:
        squares = sum(float(np.mean(off**2)) for own in self._off(runs) for off in own.values())
        return _WEIGHT * squares + float(z @ self._precision @ z)

    def _step(self, runs: Runs, z: np.ndarray, slopes: Runs) -> np.ndarray:
        """Gauss-Newton's step."""
        information, score = self._precision.copy(), -self._precision @ z
        for off, own in zip(self._off(runs), slopes, strict=True):
            for name, slope in own.items():
                information += _WEIGHT / off[name].size * (slope.T @ slope)
                score -= _WEIGHT / off[name].size * (slope.T @ off[name])
        return cho_solve(cho_factor(information), score)

    def _sensitivities(self, theta: np.ndarray, acting: Acting, moves: list[tuple[np.ndarray, np.ndarray]], runs: Runs,
                       z: np.ndarray | None = None) -> Runs:
        """Of residuals over floors to moves, by recording, signal to (samples, moves); ``runs`` are those at ``z``, None: before any."""
        base = self._off(runs)
        at, begins = (theta, np.zeros(self._ends[-1])) if z is None else self._at(theta, z)

        def moved(move: tuple[np.ndarray, np.ndarray]) -> Runs:
            by, begin = move
            return self._off(self._held.run(at + _DIFFERENCE * by, acting, self._by_recording(begins + _DIFFERENCE * begin)))

        with ThreadPoolExecutor(max_workers=2) as pool:
            changed = list(pool.map(moved, moves))
        return [{name: np.nan_to_num(np.array([(other[number][name] - off) / _DIFFERENCE for other in changed]).reshape(-1, off.size).T,
                                     posinf=0.0, neginf=0.0) for name, off in own.items()} for number, own in enumerate(base)]


def _spread_out(counts: np.ndarray) -> np.ndarray:
    """Indices of at most `_SAMPLES` of the samples that count, evenly among them."""
    index = np.flatnonzero(counts)
    return index[:: max(1, -(-index.size // _SAMPLES))]
