"""Which sets of effects the recordings speak for, all on one linearisation.

Every hypothesis is a linear Gaussian model: the rig's parameters (their prior and what the
commissioning recording says of them), the allowances for the model's own flaws, and the columns
of its effects. Its evidence is exact and costs a small matrix, so that all pairs are tried. An
effect's size is as likely as its signals: the prior of a departure is the one that moves the
worst signal by some `sensitivity.TYPICAL` of its noise, the same for all effects, so that no
effect is preferred for its unit.

MacKay, Information Theory, Inference and Learning Algorithms (2003), chapter 28, for evidence and Occam's factor.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp, ndtr

from ddh_twin_py.estimation.linear_gaussian import Gram, Marginal, gain
from ddh_twin_py.gap.sensitivity import Column

WIDTH = 2.0
"""Prior standard deviation of a departure, in multiples of its column's."""
PRIOR_NONE = 0.3
"""Prior probability that nothing but parameters is off."""
PRIOR_PAIRS = 0.15
"""Prior probability that two effects act at once."""
_PAIRS_AMONG = 30  # columns whose pairs are tried


@dataclass(frozen=True)
class Hypothesis:
    """A set of effects and what it gains.

    Attributes:
        columns: indices of the columns, sorted. log_evidence: over that of no effect, prior included.
        departure: estimated multiples of each column. spread: their standard deviations.
        chi_square: how much of it the set explains.
    """

    columns: tuple[int, ...]
    log_evidence: float
    departure: np.ndarray
    spread: np.ndarray
    chi_square: float


class Evidence:
    """Sums over the recordings, parameters marginalised, ready for any set of columns.

    Args:
        gram: sums with the parameters' columns first, then the effects'.
        parameters: how many parameters. theta: where they stand, in prior standard deviations.
    """

    def __init__(self, gram: Gram, parameters: int, theta: np.ndarray, columns: Sequence[Column]) -> None:
        shifted = gram.xy.copy()
        shifted[:parameters] -= theta  # the prior is centred on the sheet, the linearisation on theta
        self.columns = list(columns)
        self._marginal = Marginal(Gram(gram.xx, shifted, gram.yy + float(theta @ theta), gram.rows), np.arange(parameters))
        self.information, self.score = self._marginal.project(np.arange(parameters, parameters + len(columns)))
        self.chi_square, self.rows = self._marginal.chi_square, gram.rows
        self.prior = np.full(len(columns), WIDTH)

    def of(self, chosen: Sequence[int]) -> Hypothesis:
        """Gain of a set of columns over none, each departing in its own direction alone."""
        index = np.array(chosen, dtype=np.int64)
        information = self.information[np.ix_(index, index)]
        log, estimate, covariance = gain(information, self.score[index], self.prior[index])
        spread = np.sqrt(np.diagonal(covariance))
        within = float(np.sum(np.log(2.0 * np.maximum(ndtr(estimate / spread), 1e-300))))
        explained = float(2.0 * estimate @ self.score[index] - estimate @ information @ estimate)
        return Hypothesis(tuple(int(i) for i in index), log + within, estimate, spread, explained)

    def singles(self) -> list[Hypothesis]:
        """Every column by itself."""
        return [self.of([i]) for i in range(len(self.columns))]

    def pairs(self, singles: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Pairs of columns of different effects: any two of the best, and the best with every other."""
        best = sorted(range(len(singles)), key=lambda i: -singles[i].log_evidence)[:_PAIRS_AMONG]
        # what lies hidden behind another effect shows only beside it: the partner of each of the leading few
        wanted = {tuple(sorted(p)) for p in itertools.combinations(best, 2)}
        wanted |= {tuple(sorted((i, j))) for i in best[:6] for j in range(len(self.columns)) if i != j}
        return [self.of(p) for p in sorted(wanted) if self.columns[p[0]].effect.id != self.columns[p[1]].effect.id]


def effects_of(hypothesis: Hypothesis, columns: Sequence[Column]) -> tuple[str, ...]:
    """Ids of the effects of a hypothesis, sorted."""
    return tuple(sorted({columns[i].effect.id for i in hypothesis.columns}))


def weighted(hypotheses: Sequence[Hypothesis], columns: Sequence[Column],
             effects: int) -> dict[tuple[str, ...], tuple[float, Hypothesis | None]]:
    """Log posterior weight of every set of effects (laws and directions summed) and its best way; () is no effect."""
    ways: dict[str, int] = {}
    for column in columns:
        ways[column.effect.id] = ways.get(column.effect.id, 0) + 1
    groups: dict[tuple[str, ...], list[tuple[float, Hypothesis]]] = {}
    pairs = max(1, effects * (effects - 1) // 2)
    for hypothesis in hypotheses:
        ids = effects_of(hypothesis, columns)
        prior = math.log(PRIOR_PAIRS / pairs) if len(ids) == 2 else math.log((1.0 - PRIOR_NONE - PRIOR_PAIRS) / effects)
        prior -= sum(math.log(ways[i]) for i in ids)
        groups.setdefault(ids, []).append((hypothesis.log_evidence + prior, hypothesis))
    out: dict[tuple[str, ...], tuple[float, Hypothesis | None]] = {(): (math.log(PRIOR_NONE), None)}
    for ids, members in groups.items():
        best = max(members, key=lambda m: m[0])[1]
        out[ids] = (float(logsumexp([m[0] for m in members])), best)
    return out


def probabilities(weights: dict[tuple[str, ...], float]) -> dict[tuple[str, ...], float]:
    """Posterior probabilities from log weights, largest first."""
    total = logsumexp(list(weights.values()))
    found = {ids: float(np.exp(w - total)) for ids, w in weights.items()}
    return dict(sorted(found.items(), key=lambda item: -item[1]))
