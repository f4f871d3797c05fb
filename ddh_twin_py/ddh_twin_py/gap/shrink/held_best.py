"""How far held-out data are off under a hypothesis where all that is left open is taken at its best.

What fitted recordings left open of a rig, and how a recording of which too little is read begins, moves a free run on another
duty; a hypothesis is not to blame for it. What still is off then, is off whatever these are: a check of the hypothesis against
new data with its nuisances profiled out (posterior predictive check; Gelman, Meng & Stern, Statistica Sinica 6 (1996) 733).
An effect's own size is held, unless it is asked which size these data would have: what is true has the same in every duty.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import block_diag, cho_factor, cho_solve

from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.explain.side_by_side import THREADS
from ddh_twin_py.gap.model import Held
from ddh_twin_py.gap.shrink.held_runs import INDEPENDENT, ratios_of
from ddh_twin_py.gap.shrink.size import of_all

_OPEN = 0.3  # deviations: what is known better than that does not move
_DIFFERENCE = 0.05  # deviations
_SAMPLES = 2000  # of a signal at most that a step is computed from
_LEAST_FREE = 1.0  # degrees of freedom: where these data tell nothing anew, a move of one deviation is none
_STEPS, _SHARES, _SETTLED = 3, (1.0, 0.4, 0.15), 0.05  # steps, what is tried of each, cost that one must gain

Runs = list[dict[str, np.ndarray]]


@dataclass(frozen=True)
class AtBest:
    """Held-out data beside a hypothesis where what is open is at its best for them.

    Attributes:
        over: RMS over floor of each signal. theta: parameters there, in deviations, (k,). departures: of the effects there, (m,).
        squares: mean square over floor of each signal's samples that were used, by recording that reads it.
        moved: squared deviations of what is open. expected: of them, where the fitted recordings and these are of one rig.
    """

    over: dict[str, float]
    theta: np.ndarray
    departures: np.ndarray
    squares: dict[str, list[float]]
    moved: float
    expected: float

    @property
    def displaced(self) -> float:
        """Standard deviations by which what is open moved farther than is expected, as a chi-squared with so many degrees of freedom."""
        return (self.moved - self.expected) / math.sqrt(2.0 * max(self.expected, _LEAST_FREE))

    @property
    def gap(self) -> float:
        """Of all signals, in multiples of the floor; see `size.of_all`."""
        return of_all(self.over)

    def cost(self, least: Mapping[str, float]) -> float:
        """What is left, as `HeldBest` weighs it, squared deviations; of signals in ``least`` what is beyond that many floors."""
        return _cost(self.squares, least) + self.moved


@dataclass(frozen=True)
class _Ways:
    """A hypothesis and the ways in which it may move.

    Attributes:
        theta, begin, acting: parameters (k,), begins of all recordings (b,), effects with their departures (m,).
        moves: one a row, of all three, (n, k + b + m). precision: of how far along each, (n, n).
    """

    theta: np.ndarray
    begin: np.ndarray
    acting: Acting
    moves: np.ndarray
    precision: np.ndarray

    def moved(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, Acting]:
        """Parameters, begins and effects so far along the moves, (n,)."""
        theta, begin, sizes = np.split(z @ self.moves, np.cumsum([self.theta.size, self.begin.size]))
        acting = [(effect, law, x + float(more)) for (effect, law, x), more in zip(self.acting, sizes, strict=True)]
        return self.theta + theta, self.begin + begin, acting


class HeldBest:
    """Held-out data with what is open of rig and begin.

    Args:
        held: the data. floor: of each signal, in multiples of its noise. within: keeps parameters (k,) to their bounds.
        theta: parameters about which sensitivities are taken, in deviations, (k,). covariance: what is open of them, (k, k).
        told: called with the number of times that the data were run so far.
    """

    def __init__(self, held: Held, floor: Mapping[str, float], within: Callable[[np.ndarray], np.ndarray], theta: np.ndarray,
                 covariance: np.ndarray, told: Callable[[int], None] | None = None) -> None:
        self._held, self._floor, self._within = held, floor, within
        self._told, self._ran = told, itertools.count(1)
        free = np.flatnonzero(np.sqrt(np.maximum(np.diagonal(covariance), 0.0)) > _OPEN)
        self._ends = np.cumsum(held.open_begins())
        begins = int(self._ends[-1])
        self._of_rig = range(free.size)
        self._moves = block_diag(np.eye(theta.size)[free], np.eye(begins))
        prior = covariance[np.ix_(free, free)] + 1.0e-6 * np.eye(free.size)
        self._precision = block_diag(np.linalg.inv(prior), np.eye(begins))
        used = [{name: _spread_out(held.mask()(s)) for name, s in own.items()} for own in held.signals()]
        self._used = [{name: index for name, index in own.items() if index.size} for own in used]
        self._to_begins: dict[tuple, Runs] = {}
        self._slopes = self._sensitivities(self._ways(theta, (), ()), self._of_rig, np.zeros(len(self._moves)))

    def beside(self, theta: np.ndarray, acting: Acting, closely: bool = False, spread: Sequence[float] = (),
               least: Mapping[str, float] | None = None) -> AtBest:
        """The data beside a hypothesis.

        Args:
            theta: parameters that a fit found, (k,). acting: effects. closely: take sensitivities anew where the first steps lead; a
                valve may be open there that is shut where they were taken. spread: standard deviations by which the effects'
                departures may be others, (m,); empty or all 0: they may not.
            least: signals that have no say in what is best until they are so many floors off; infinite: none at all.
        """
        least = least or {}
        ways = self._ways(theta, acting, spread)
        z = np.zeros(len(ways.moves))
        runs, begins = self._run(ways, z), self._of_begins(ways, z)  # the warmth of oil bends, and what acts bends it
        sizes = self._sensitivities(ways, range(len(self._moves), z.size), z)
        slopes = [{name: np.hstack([one[name] for one in own]) for name in own[0]} for own in zip(self._slopes, begins, sizes, strict=True)]
        z, runs = self._descended(ways, z, runs, slopes, least)
        if closely:
            slopes = self._sensitivities(ways, range(z.size), z)
            z, runs = self._descended(ways, z, runs, slopes, least)
        at, _, acts = self._at(ways, z)
        told = _summed(_told(slopes), self._speaking(runs, least), np.zeros_like(ways.precision))
        expected = float(np.trace(np.linalg.solve(ways.precision + told, told)))
        return AtBest({name: ratio / self._floor[name] for name, ratio in ratios_of(self._held, runs).items()}, at,
                      np.array([x for _, _, x in acts]), self._squares(runs), float(z @ ways.precision @ z), expected)

    def _of_begins(self, ways: _Ways, z: np.ndarray) -> Runs:
        """Sensitivities to the begins of a hypothesis that has not moved, which is asked about several times."""
        asked = ways.theta.tobytes(), tuple((effect.id, law, x) for effect, law, x in ways.acting)
        if asked not in self._to_begins:
            self._to_begins[asked] = self._sensitivities(ways, range(len(self._of_rig), len(self._moves)), z)
        return self._to_begins[asked]

    def _ways(self, theta: np.ndarray, acting: Acting, spread: Sequence[float]) -> _Ways:
        free = np.asarray(spread if len(spread) else np.zeros(len(acting)))
        sizes = np.diag(free)[free > 0.0]
        return _Ways(theta, np.zeros(int(self._ends[-1])), acting, block_diag(self._moves, sizes),
                     block_diag(self._precision, np.eye(len(sizes))))

    def _descended(self, ways: _Ways, z: np.ndarray, runs: Runs, slopes: Runs, least: Mapping[str, float]) -> tuple[np.ndarray, Runs]:
        """Where a few steps with the same sensitivities lead, and the runs there."""
        def cost_of(z: np.ndarray, runs: Runs) -> float:
            return _cost(self._squares(runs), least) + float(z @ ways.precision @ z)

        cost, told = cost_of(z, runs), _told(slopes)
        if not math.isfinite(cost):  # runs went astray: there is no way from here
            return z, runs
        for _ in range(_STEPS):
            step, gained = self._step(ways, z, runs, slopes, told, least), 0.0
            for share in _SHARES:
                tried = z + share * step
                other = self._run(ways, tried)
                reached = cost_of(tried, other)
                if reached < cost:
                    gained, z, runs, cost = cost - reached, tried, other, reached
                    break
            if gained < _SETTLED:
                break
        return z, runs

    def _at(self, ways: _Ways, z: np.ndarray, beyond: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray, Acting]:
        """Parameters, begins and effects after moves, within what is allowed; ``beyond``: further moves, allowed or not."""
        theta, begin, acting = ways.moved(z)
        theta, acting = self._within(theta), [(effect, law, effect.limit(x)) for effect, law, x in acting]
        return (theta, begin, acting) if beyond is None else _Ways(theta, begin, acting, ways.moves, ways.precision).moved(beyond)

    def _run(self, ways: _Ways, z: np.ndarray, beyond: np.ndarray | None = None, roughly: bool = False) -> Runs:
        theta, begin, acting = self._at(ways, z, beyond)
        if self._told is not None:
            self._told(next(self._ran))
        return self._held.run(theta, acting, np.split(begin, self._ends[:-1]), roughly)

    def _off(self, runs: Runs) -> Runs:
        """Residuals over floors of the samples that are used, by recording."""
        return [{name: (s[name].measured[i] - run[name][i]) / (s[name].noise * self._floor[name]) for name, i in used.items()}
                for used, s, run in zip(self._used, self._held.signals(), runs, strict=True)]

    def _squares(self, runs: Runs) -> dict[str, list[float]]:
        """Mean square of the residuals over floors of each signal, by recording that reads it."""
        out: dict[str, list[float]] = {}
        for own in self._off(runs):
            for name, off in own.items():
                out.setdefault(name, []).append(float(np.mean(off**2)))
        return out

    def _speaking(self, runs: Runs, least: Mapping[str, float]) -> set[str]:
        """Signals that have a say."""
        return {name for name, own in self._squares(runs).items() if sum(own) > len(own) * least.get(name, 0.0) ** 2}

    def _step(self, ways: _Ways, z: np.ndarray, runs: Runs, slopes: Runs, told: Mapping[str, np.ndarray],
              least: Mapping[str, float]) -> np.ndarray:
        """Gauss-Newton's step; ``told``: see `_told`."""
        speaking, score = self._speaking(runs, least), -ways.precision @ z
        for off, own in zip(self._off(runs), slopes, strict=True):
            for name, slope in own.items():
                if name in speaking:
                    score -= INDEPENDENT / off[name].size * (slope.T @ off[name])
        return cho_solve(cho_factor(_summed(told, speaking, ways.precision)), score)

    def _sensitivities(self, ways: _Ways, moves: Sequence[int], z: np.ndarray) -> Runs:
        """Of residuals over floors to some moves about ``z``, by recording, signal to (samples, moves)."""
        if not len(moves):
            return [{name: np.empty((index.size, 0)) for name, index in own.items()} for own in self._used]

        def moved(move: int | None, roughly: bool) -> Runs:
            return self._off(self._run(ways, z, None if move is None else _DIFFERENCE * np.eye(z.size)[move], roughly))

        with ThreadPoolExecutor(max_workers=THREADS) as pool:
            for roughly in (True, False):  # a rough run may go astray where a fine one does not
                base, *changed = pool.map(partial(moved, roughly=roughly), [None, *moves])
                if all(np.isfinite(off).all() for own in base for off in own.values()):
                    break
        return [{name: np.nan_to_num(np.array([(other[number][name] - off) / _DIFFERENCE for other in changed]).T, posinf=0.0, neginf=0.0)
                 for name, off in own.items()} for number, own in enumerate(base)]


def _told(slopes: Runs) -> dict[str, np.ndarray]:
    """What each signal tells of the moves, (n, n), over all recordings."""
    out: dict[str, np.ndarray] = {}
    for own in slopes:
        for name, slope in own.items():
            out[name] = out.get(name, 0.0) + INDEPENDENT / len(slope) * (slope.T @ slope)
    return out


def _summed(told: Mapping[str, np.ndarray], speaking: set[str], more: np.ndarray) -> np.ndarray:
    return sum((own for name, own in told.items() if name in speaking), more)


def _cost(squares: Mapping[str, Sequence[float]], least: Mapping[str, float]) -> float:
    """Of mean squares over floors; of signals in ``least`` what is beyond that many floors, where these are infinite nothing."""
    bounds = {name: len(own) * least.get(name, 0.0) ** 2 for name, own in squares.items()}
    return INDEPENDENT * sum(max(sum(own), bounds[name]) for name, own in squares.items() if math.isfinite(bounds[name]))


def _spread_out(counts: np.ndarray) -> np.ndarray:
    """Indices of at most `_SAMPLES` of the samples that count, evenly among them."""
    index = np.flatnonzero(counts)
    return index[:: max(1, -(-index.size // _SAMPLES))]
