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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.calibration import Problem, offset_paths, with_offsets
from ddh_twin_py.estimation.comparison import Comparison
from ddh_twin_py.estimation.experiment import Experiment
from ddh_twin_py.estimation.weighting import Weighting
from ddh_twin_py.gap.direct_drive import DirectDrive
from ddh_twin_py.gap.hypotheses import slack_shares
from ddh_twin_py.gap.linearised import Linearised
from ddh_twin_py.gap.model import Acting
from ddh_twin_py.gap.sensitivity import Column

STEP = 4.0e-3
"""s, hydraulic step of the runs."""
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
        return [(c.effect, c.law, float(v)) for c, v in zip(self.columns, self.x, strict=True)]


class Remaining:
    """What the recordings have left open, in few unknowns: the parameters, and one slack for each law of each effect.

    Args:
        linearised: of the recordings.

    Attributes:
        laws: effect and law of each slack, (g,), each with the departure that it may well have. covariance: of
            parameters and slacks, the latter in the effects' own units, (k + g, k + g).
    """

    def __init__(self, linearised: Linearised) -> None:
        columns, basis = linearised.columns, linearised.basis
        k = basis.parameters
        groups = {key: number for number, key in enumerate(dict.fromkeys((c.effect.id, c.law) for c in columns))}
        share = linearised.slack * slack_shares(columns)
        first = {key: next(c for c in columns if (c.effect.id, c.law) == key) for key in groups}
        self._to_laws = np.zeros((len(groups), len(columns)))
        for i, column in enumerate(columns):
            self._to_laws[groups[column.effect.id, column.law], i] = share[i] * column.x
        self.laws = [(c.effect, c.law, linearised.slack * c.x) for c in first.values()]
        whole = np.eye(k + len(groups), k + len(columns))
        whole[k:, k:] = self._to_laws
        covariance = basis.joint_covariance()
        self.covariance = whole @ covariance @ whole.T
        self._of = {key: k + number for key, number in groups.items()}

    def slack(self, belief: Believed) -> np.ndarray:
        """A hypothesis' slack by law, in the effects' own units, (g,)."""
        return self._to_laws @ belief.slack

    def freedom(self, belief: Believed) -> np.ndarray:
        """The covariance, with what is open of a hypothesis' own departures, (k + g, k + g)."""
        out = self.covariance.copy()
        at = [self._of.get((c.effect.id, c.law)) for c in belief.columns]
        for i, a in enumerate(at):
            for j, b in enumerate(at):
                if a is not None and b is not None:
                    out[a, b] += belief.covariance[i, j]
        return out


class Trial:
    """A rehearsed test, to be predicted under hypotheses.

    Args:
        model, linearised: of the recordings. experiment: the rehearsal.
    """

    def __init__(self, model: DirectDrive, linearised: Linearised, experiment: Experiment) -> None:
        added = [path for path in offset_paths([experiment]) if path not in model.paths]
        rig = with_offsets(model.rig, added)
        self.experiment = experiment
        self._added = len(added)
        self._problem = Problem([experiment], rig, model.paths + added, linearised.discrepancy)
        self._discrepancy = linearised.discrepancy
        self._comparison: Comparison | None = None

    def predict(self, theta: np.ndarray, acting: Acting) -> dict[str, np.ndarray]:
        """Free run of the test with parameters (k,), in deviations, and effects."""
        record = self._problem.record(0, np.concatenate([theta, np.zeros(self._problem.size - theta.size)]))
        for effect, law, departure in acting:
            effect.laws[law](record, departure)
        return self.experiment.predict(record, STEP)

    def features(self, predicted: Mapping[str, np.ndarray]) -> np.ndarray:
        """What a prediction is compared by, (rows,); the first one that is asked about tells where signals are steep."""
        if self._comparison is None:
            self._comparison = Comparison(self.experiment.signals, predicted, self._discrepancy)
        return self._comparison.features(predicted)

    def rows(self, sensors: Sequence[str]) -> np.ndarray:
        """Which rows there are with these temperature sensors, (rows,)."""
        kept = np.ones(self._comparison.size, dtype=bool)
        for block in self._comparison.blocks:
            if block.signal.startswith("temperature/") and block.signal.split("/", 1)[1] not in sensors:
                kept[block.rows] = False
        return kept

    def crude(self, difference: np.ndarray, kept: np.ndarray) -> float:
        """d' P d / 2 of a difference (rows,): what is told where parameters are known."""
        d = np.where(kept, difference, 0.0)
        return 0.5 * float(d @ Weighting([self._comparison]).applied([d[:, None]])[0][:, 0])

    def sensitivities(self, belief: Believed, remaining: Remaining) -> np.ndarray:
        """Differences of the features by each unknown of `Remaining`, then by zeros of sensors that the recordings lack, (rows, q)."""
        base = self.features(self.predict(belief.theta, belief.acting))
        spread = np.sqrt(np.diagonal(remaining.covariance))
        k = belief.theta.size
        out = []
        whole = np.concatenate([belief.theta, np.zeros(self._added)])
        for i in [*range(k), *range(k, k + self._added)]:
            moved = whole.copy()
            step = _DIFFERENCE * (spread[i] if i < k else 1.0)
            moved[i] += -step if moved[i] > 0.0 else step
            out.append((self.features(self.predict(moved, belief.acting)) - base) / (moved[i] - whole[i]))
        zeros = out[k:]
        out = out[:k]
        for effect, law, typical in remaining.laws:
            x = effect.limit(typical)
            out.append((self.features(self.predict(belief.theta, [*belief.acting, (effect, law, x)])) - base) / x)
        return np.column_stack(out + zeros)

    def apart(self, difference: np.ndarray, sensitivities: np.ndarray, covariance: np.ndarray, kept: np.ndarray) -> float:
        """Expected log Bayes factor, see the module.

        Args:
            difference: of two predictions, (rows,). sensitivities: (rows, q). covariance: of the first unknowns, (p, p);
                the other q - p are zeros of sensors, of variance 1. kept: rows that there are, (rows,).
        """
        q, p = sensitivities.shape[1], covariance.shape[0]
        whole = np.eye(q)
        whole[:p, :p] = covariance
        value, vector = np.linalg.eigh(whole)
        root = vector * np.sqrt(np.maximum(value, 0.0))
        rows = np.column_stack([sensitivities @ root, difference]) * kept[:, None]
        products = rows.T @ Weighting([self._comparison]).applied([rows])[0]
        cross = products[:-1, -1]
        taken = np.linalg.solve(np.eye(q) + products[:-1, :-1], cross)
        return max(0.0, 0.5 * float(products[-1, -1] - cross @ taken))
