"""How far a test would tell hypotheses apart that recordings have left: an expected log Bayes factor.

Each hypothesis predicts the test with its own fitted parameters and departures. Where the first is
true and both leave the same freedom, the log Bayes factor against the other is expected to be

    d' V^-1 d / 2,   V = P^-1 + G C G'

with d the difference of the predictions, P the weights of a comparison (noise and what the model is
forgiven), G the test's sensitivities to the rig's parameters and to the slack of its laws, and C what
the recordings so far have left of their covariance. A difference that parameters could take up in
the test without contradicting the recordings counts for nothing.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy
from ddh_twin_py.estimation.fitting.experiment import Signal
from ddh_twin_py.estimation.fitting.weighting import Weighting
from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.evidence.hypotheses import slack_shares
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import Column, acting_of, sane
from ddh_twin_py.gap.explain.side_by_side import THREADS
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

_DIFFERENCE = 0.3  # of what a parameter or a departure may still be off by


@dataclass(frozen=True)
class Believed:
    """A hypothesis as the recordings have left it.

    Attributes:
        effects: ids. theta: parameters, deviations, (k,). columns: of its effects. x: departures, (m,).
        covariance: of the departures, (m, m). slack: of all columns, in their standard deviations, (c,).
    """

    effects: tuple[str, ...]
    theta: np.ndarray
    columns: tuple[Column, ...]
    x: np.ndarray
    covariance: np.ndarray
    slack: np.ndarray

    @property
    def acting(self) -> Acting:
        """What acts."""
        return acting_of(self.columns, self.x)


class Remaining:
    """What the recordings have left open, in few unknowns: the parameters, and one slack for each effect.

    Two laws of one effect cannot act in one run. An effect's slack is taken by the law that a hypothesis has it act by, else by its first.

    Args:
        linearised: of the recordings. believed: the hypotheses.

    Attributes:
        laws: effect, law and a departure that it may well have, of each slack, (g,). covariance: of parameters and
            slacks, the latter in the effects' own units, (k + g, k + g).
    """

    def __init__(self, linearised: Linearised, believed: Sequence[Believed]) -> None:
        columns, basis = linearised.columns, linearised.basis
        k = basis.parameters
        law = {c.effect.id: c.law for c in reversed([*(c for b in believed for c in b.columns), *columns])}
        taken = [(i, c) for i, c in enumerate(columns) if c.law == law[c.effect.id]]
        groups = {name: number for number, name in enumerate(dict.fromkeys(c.effect.id for _, c in taken))}
        share = linearised.slack * slack_shares(columns)
        self._to_laws = np.zeros((len(groups), len(columns)))
        first: dict[str, Column] = {}
        for i, column in taken:
            self._to_laws[groups[column.effect.id], i] = share[i] * column.x
            first.setdefault(column.effect.id, column)
        self.laws = [(c.effect, c.law, linearised.slack * c.x) for c in first.values()]
        whole = np.zeros((k + len(groups), k + len(columns)))
        whole[:k, :k] = np.eye(k)
        whole[k:, k:] = self._to_laws
        self.covariance = whole @ basis.joint_covariance() @ whole.T

    def move_of_slack(self, one: Believed, other: Believed) -> np.ndarray:
        """By how much two hypotheses' slacks differ, in standard deviations of the unknowns, (k + g, 1)."""
        k = one.theta.size
        move = np.zeros((self.covariance.shape[0], 1))
        move[k:, 0] = self._to_laws @ (one.slack - other.slack) / np.sqrt(np.diagonal(self.covariance)[k:])
        return move


class Trial(ABC):
    """A test that has not been made, to be predicted under hypotheses.

    Args:
        signals: name to signal that would be read. discrepancy: what the model is forgiven. added: zeros of sensors that the
            recordings lack, unknowns behind the parameters.

    Attributes:
        comparison: of the test, None until `features` is first asked. added: see above.
    """

    def __init__(self, signals: Mapping[str, Signal], discrepancy: Discrepancy, added: int = 0) -> None:
        self.added = added
        self._signals, self._discrepancy = signals, discrepancy
        self.comparison: Comparison | None = None
        self._weighting: Weighting | None = None

    @abstractmethod
    def predict(self, theta: np.ndarray, acting: Acting) -> dict[str, np.ndarray]:
        """What every sample would read, with parameters, deviations, (k,) or with zeros of added sensors, and effects."""

    def features(self, theta: np.ndarray, acting: Acting) -> np.ndarray:
        """What the test is compared by, (rows,); see `predict`. The first that is asked about tells where signals are steep."""
        predicted = self.predict(theta, acting)
        if self.comparison is None:
            self.comparison = Comparison(self._signals, predicted, self._discrepancy)
            self._weighting = Weighting([self.comparison])
        return self.comparison.features(predicted)

    def rows(self, sensors: Sequence[str]) -> np.ndarray:
        """Which rows there are with these temperature sensors, (rows,)."""
        kept = np.ones(self.comparison.size, dtype=bool)
        for block in self.comparison.blocks:
            if block.signal.startswith(TEMPERATURE_PREFIX) and block.signal.removeprefix(TEMPERATURE_PREFIX) not in sensors:
                kept[block.rows] = False
        return kept

    def products(self, columns: np.ndarray, kept: np.ndarray) -> np.ndarray:
        """X'PX of columns (rows, q) on the rows that there are, (q, q)."""
        own = columns * kept[:, None]
        return own.T @ self._weighting.applied([own])[0]

    def of_departures(self, belief: Believed) -> np.ndarray:
        """What is open of a hypothesis' own departures, as columns of one standard deviation each, (rows, m)."""
        base = self.features(belief.theta, belief.acting)
        value, vector = np.linalg.eigh(belief.covariance)
        out = [np.zeros((base.size, 0))]
        for j in range(value.size):
            step = _DIFFERENCE * np.sqrt(max(value[j], 0.0)) * vector[:, j]
            moved, share = _within(belief, step)
            out.append((self.features(belief.theta, acting_of(belief.columns, moved)) - base)[:, None] / (_DIFFERENCE * share))
        return _told(np.hstack(out))

    def sensitivities(self, belief: Believed, remaining: Remaining, wanted: np.ndarray | None = None) -> np.ndarray:
        """Differences of the features by each unknown, scaled to its standard deviation: `Remaining`'s, then zeros of sensors that
        the recordings lack, (rows, q).

        Args:
            wanted: unknowns of `Remaining` that are taken, (k + g,); the others count as known. None takes all.
        """
        base = self.features(belief.theta, belief.acting)
        spread = np.sqrt(np.diagonal(remaining.covariance))
        k, p = belief.theta.size, remaining.covariance.shape[0]
        take = np.ones(p, dtype=bool) if wanted is None else wanted
        whole = np.concatenate([belief.theta, np.zeros(self.added)])

        def column(i: int) -> np.ndarray:
            if k <= i < p:
                effect, law, typical = remaining.laws[i - k]
                step = effect.limit(_DIFFERENCE * np.sign(typical) * spread[i])
                moved = self.features(belief.theta, [*belief.acting, (effect, law, step)])
                return (moved - base) * spread[i] / step
            at = i if i < k else i - p + k
            step = _DIFFERENCE * (spread[i] if i < k else 1.0) * (-1.0 if whole[at] > 0.0 else 1.0)
            other = whole.copy()
            other[at] += step
            return (self.features(other, belief.acting) - base) * (spread[i] if i < k else 1.0) / step

        taken = [i for i in range(p + self.added) if i >= p or take[i]]
        out = np.zeros((base.size, p + self.added))
        out[:, taken] = _side_by_side(column, taken, base.size)
        return _told(out)

    def along(self, belief: Believed, remaining: Remaining, directions: np.ndarray) -> np.ndarray:
        """The same by moves of all unknowns of `Remaining` at once, in their standard deviations, (p, r); gives (rows, r)."""
        base = self.features(belief.theta, belief.acting)
        spread = np.sqrt(np.diagonal(remaining.covariance))
        k = belief.theta.size

        def column(direction: np.ndarray) -> np.ndarray:
            step = _DIFFERENCE / max(1.0, float(np.max(np.abs(direction))))
            move = step * spread * direction
            laws = [(effect, law, float(x)) for (effect, law, _), x in zip(remaining.laws, move[k:], strict=True)]
            return (self.features(belief.theta + move[:k], [*belief.acting, *laws]) - base) / step

        return _told(_side_by_side(column, directions.T, base.size))

    def apart(self, difference: np.ndarray, free: np.ndarray, kept: np.ndarray) -> float:
        """Expected log Bayes factor, see the module.

        Args:
            difference: of two predictions, (rows,). free: what is open, as independent columns of one standard deviation
                each, (rows, q). kept: rows that there are, (rows,).
        """
        products = self.products(np.column_stack([free, difference]), kept)
        cross = products[:-1, -1]
        taken = np.linalg.solve(np.eye(cross.size) + products[:-1, :-1], cross)
        return max(0.0, 0.5 * float(products[-1, -1] - cross @ taken))


def _within(belief: Believed, step: np.ndarray) -> tuple[np.ndarray, float]:
    """Departures a step (m,) away, (m,), and which share of it that is: where bounds shorten it, the way on which they leave more."""
    lowest, highest = (np.array([getattr(c.effect, end) for c in belief.columns]) for end in ("lowest", "highest"))
    ways = []
    for way in (step, -step):
        moved = np.clip(belief.x + way, lowest, highest)
        if np.array_equal(moved, belief.x + way):
            return moved, 1.0
        ways.append((float((moved - belief.x) @ way / (way @ way)), moved))
    share, moved = max(ways, key=lambda one: one[0])
    return (moved, share) if share > 0.0 else (belief.x, 1.0)


def _side_by_side(column: Callable[..., np.ndarray], wanted: Sequence, rows: int) -> np.ndarray:
    """A column (rows,) for each of what is wanted, (rows, q), worked out two at a time."""
    with ThreadPoolExecutor(max_workers=THREADS) as pool:
        columns = list(pool.map(column, wanted))
    return np.column_stack(columns) if columns else np.zeros((rows, 0))


def root_of(remaining: Remaining, added: int) -> np.ndarray:
    """Root of the correlation of what is open, with ``added`` independent unknowns below, (p + added, p + added)."""
    spread = np.sqrt(np.diagonal(remaining.covariance))
    p = spread.size
    whole = np.eye(p + added)
    whole[:p, :p] = remaining.covariance / np.outer(spread, spread)
    value, vector = np.linalg.eigh(whole)
    return vector * np.sqrt(np.maximum(value, 0.0))


def _told(columns: np.ndarray) -> np.ndarray:
    """The same without what a run says that went astray."""
    return np.where(sane(columns), columns, 0.0)
