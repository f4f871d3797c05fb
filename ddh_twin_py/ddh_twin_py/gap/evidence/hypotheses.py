"""Which sets of effects the recordings speak for, all on one linearisation.

Every hypothesis is a linear Gaussian model: the rig's parameters (their prior and what the
commissioning recording says of them), the allowances for the model's own flaws, and the columns
of its effects. Its evidence is exact and costs a small matrix, so that hundreds of pairs are tried. An
effect's size is as likely as its signals: the prior of a departure is the one that moves the
worst signal by some of its `LEVELS` of noise, the same for all effects, so that no
effect is preferred for its unit.

A model's laws are a little wrong, and alike in thousands of rows, which a likelihood would count
as thousands of witnesses. It is therefore raised to a `POWER` below 1 (a generalised posterior).
Each effect is also present under every hypothesis with a departure of `SLACK`, and one that is
said to act has a departure that stands out from it: a spike and a slab, both of some width.

MacKay, Information Theory, Inference and Learning Algorithms (2003), chapter 28, for evidence and Occam's factor;
Grünwald & van Ommen, Inconsistency of Bayesian inference for misspecified linear models, Bayesian Analysis 12 (2017), for the
power; George & McCulloch, Variable selection via Gibbs sampling, J. Am. Stat. Assoc. 88 (1993), for the spike of some width.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr, logsumexp

from ddh_twin_py.estimation.fitting.linear_gaussian import gain
from ddh_twin_py.gap.evidence.basis import Sums
from ddh_twin_py.gap.evidence.box import Held, Normal
from ddh_twin_py.gap.evidence.sensitivity import TYPICAL, Column

Ids = tuple[str, ...]
"""A set of effects, by their ids, sorted; empty for no effect."""
WIDTH = 1.2
"""Width of a departure's prior in fits, in multiples of its column."""
LEVELS = (2.2, 5.0, 11.0)
"""Rises of the worst signal, in multiples of its noise, that a faint, a moderate and a clear effect have; one is as likely as another."""
WIDTHS = tuple(level / TYPICAL / math.sqrt(2.0) for level in LEVELS)
"""Widths of a departure's prior in what is said of the evidence, in multiples of its column: each makes one of the levels the likeliest."""
WIDTHS_WITHOUT_COMMISSIONING = (WIDTH,)
"""The same where columns are as long as what stands out from tolerances (`linearised.STANDS_OUT`): its levels lie close to each other."""
LEAST = 0.2
"""Departure below which nothing is called an effect, in multiples of its column: the worst signal rises by its noise."""
SLACK = 0.01
"""Standard deviation of what the model's laws are off along an effect, in multiples of its column."""
POWER = 0.1
"""Power to which the likelihood is raised: the model's laws are not quite the rig's, so that many rows say the same wrong thing."""
POWER_WITHOUT_COMMISSIONING = 0.06
"""The same where no commissioning recording has shown how well the laws hold: the floor is 1.6 times the noise, its square 2.6."""
PRIOR_NONE = 0.3
"""Prior probability that nothing but parameters is off."""
PRIOR_PAIRS = 0.15
"""Prior probability that two effects act at once."""
_SHRINKS = 0.1
"""Prior probability that an effect that is known for growing is smaller than expected; see `Effect.grows`."""
_NEVER = -1e9  # log probability of what is impossible
_FAR = 30.0  # deviations outside from which a normal falls off like an exponential
_PAIRS_AMONG = 30  # columns whose pairs are tried


@dataclass(frozen=True)
class Hypothesis:
    """A set of effects and what it gains.

    Attributes:
        columns: indices of the columns, sorted. log_evidence: over that of no effect on the same sums.
        departure: estimated multiples of each column. spread: their standard deviations.
        shared: the rig's parameters beside it, (k,).
    """

    columns: tuple[int, ...]
    log_evidence: float
    departure: np.ndarray
    spread: np.ndarray
    shared: np.ndarray


def weigh(information: np.ndarray, score: np.ndarray, room: np.ndarray,
          widths: Sequence[float] = WIDTHS) -> tuple[float, np.ndarray, np.ndarray]:
    """What departures along columns add to the log evidence, each in its own direction and within its bounds alone.

    The prior of a departure x is the mean of 2 x^2/w^2 N(x; 0, w^2) over the widths w, beyond `LEAST`: what is too small to be
    seen is not asked about (a moment prior, Johnson & Rossell, J. R. Stat. Soc. B 72, 2010). What bounds leave of it is not made whole
    again: an effect of which laws allow only what is hardly seen is so much less likely to be what is seen.

    Args:
        information, score: X'PX (m, m) and X'Py (m,) with the shared unknowns integrated out.
        room: largest departures that the laws allow, (m,). widths: of their prior, in multiples of the columns.

    Returns:
        log evidence gained, and, with `WIDTH`, estimate (m,) and covariance (m, m), in multiples of the columns.
    """
    wide = np.array(list(itertools.product(widths, repeat=score.size)))
    inner = np.linalg.inv(information * wide[:, :, None] * wide[:, None, :] + np.eye(score.size))
    covariance = inner * wide[:, :, None] * wide[:, None, :]
    estimate = covariance @ score
    logs = 0.5 * estimate @ score + 0.5 * np.linalg.slogdet(inner)[1]
    inside, estimate, covariance = _within(estimate, covariance, np.minimum(LEAST, room), room)
    logs += score.size * math.log(2.0) + inside
    logs += np.log(np.maximum(_of_squares(estimate, covariance), 1e-300)) - 2.0 * np.sum(np.log(wide), axis=1)
    _, estimate, covariance = gain(information, score, np.full(score.size, WIDTH))
    return float(logsumexp(logs)) - math.log(len(logs)), np.minimum(estimate, room), covariance


def _of_squares(mean: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Expectation, (n,), of the product of the squares of normals with mean (n, m) and covariance (n, m, m).

    By E[x_i f(x)] = mean_i E[f] + sum_j cov_ij E[df/dx_j] (Isserlis; Stein), one factor after another.
    """

    @functools.cache
    def expected(powers: tuple[int, ...]) -> np.ndarray:
        i = next((i for i, power in enumerate(powers) if power), None)
        if i is None:
            return np.ones(len(mean))
        rest = _less(powers, i)
        others = [j for j, power in enumerate(rest) if power]
        return mean[:, i] * expected(rest) + sum(rest[j] * covariance[:, i, j] * expected(_less(rest, j)) for j in others)

    return expected((2,) * mean.shape[1])


def _less(powers: tuple[int, ...], i: int) -> tuple[int, ...]:
    """Powers with one factor less of the i-th."""
    return (*powers[:i], powers[i] - 1, *powers[i + 1 :])


def _within(mean: np.ndarray, covariance: np.ndarray, least: np.ndarray, most: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normals within bounds, one unknown after another cut off, the one farthest outside first, and the rest moved along with it.

    Minka, Expectation propagation for approximate Bayesian inference, UAI (2001): assumed-density filtering by moments.

    Args:
        mean, covariance: (n, m) and (n, m, m). least, most: bounds, (m,).

    Returns:
        log probability that all are within, (n,), mean and covariance there.
    """
    outside = np.maximum(least - mean, mean - most) / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    total = np.zeros(len(mean))
    for i in np.argsort(-outside.max(axis=0)):
        spread = np.sqrt(covariance[:, i, i])
        log, centre, width = _cut((least[i] - mean[:, i]) / spread, (most[i] - mean[:, i]) / spread)
        along = covariance[:, :, i] / spread[:, None]
        total += log
        mean = mean + along * centre[:, None]
        covariance = covariance - along[:, :, None] * along[:, None, :] * (1.0 - width)[:, None, None]
    return total, np.clip(mean, least, most), covariance


def _cut(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Log probability of a standard normal between two ends, and its mean and variance there; far outside too."""
    turned = low > 0.0
    begin, end = np.where(turned, -high, low), np.where(turned, -low, high)  # towards the side from which nothing cancels
    below = np.minimum(log_ndtr(begin) - log_ndtr(end), 0.0)
    log = np.maximum(log_ndtr(end) + np.log(np.maximum(-np.expm1(below), 1e-300)), _NEVER)
    at_begin, at_end = (np.exp(np.minimum(-0.5 * x**2 - log, 700.0)) / math.sqrt(2.0 * math.pi) for x in (begin, end))
    mean = np.clip(at_begin - at_end, begin, end)
    squares = np.where(np.isfinite(begin), begin, 0.0) * at_begin - np.where(np.isfinite(end), end, 0.0) * at_end
    nearest = np.where(end < 0.0, end, 1.0)
    variance = np.where(end < -_FAR, nearest**-2.0, np.clip(1.0 + squares - mean**2, 0.0, 1.0))
    return log, np.where(turned, -mean, mean), variance


def evidence_of(held: Held, room: np.ndarray, widths: Sequence[float] = WIDTHS) -> tuple[float, np.ndarray, np.ndarray]:
    """Log evidence of a hypothesis, estimate (m,) and covariance (m, m) of its departures; see `weigh`."""
    shared = held.log_volume - 0.5 * held.chi_square
    if not room.size:
        return shared, np.zeros(0), np.zeros((0, 0))
    log, estimate, covariance = weigh(held.information, held.score, room, widths)
    return log + shared, estimate, covariance


class Evidence:
    """Hypotheses on sums over the recordings.

    Args:
        sums: of all columns, the shared unknowns integrated out without bounds. normal: the same before that.
        columns: what they are. widths: see `weigh`.

    Attributes:
        none: where no column departs. log_of_none: its log evidence but for a constant.
    """

    def __init__(self, sums: Sums, normal: Normal, columns: Sequence[Column], widths: Sequence[float] = WIDTHS) -> None:
        self.columns, self.sums, self._normal, self._widths = list(columns), sums, normal, widths
        self.none = normal.held(np.zeros(0, np.int64), np.zeros(0), WIDTH)
        self.log_of_none = evidence_of(self.none, np.zeros(0))[0]

    def of(self, chosen: Sequence[int], near: Hypothesis | None = None) -> Hypothesis:
        """Gain of a set of columns over none; ``near`` is one beside which the rig's parameters are about the same."""
        index = np.array(chosen, dtype=np.int64)
        room = np.array([self.columns[i].room for i in index])
        held = self._normal.held(index, room, WIDTH, near.shared if near else self.none.shared)
        log, estimate, covariance = evidence_of(held, room, self._widths)
        return Hypothesis(tuple(int(i) for i in index), log - self.log_of_none, estimate, np.sqrt(np.diagonal(covariance)), held.shared)

    def singles(self) -> list[Hypothesis]:
        """Every column by itself."""
        return [self.of([i]) for i in range(len(self.columns))]

    def pairs(self, singles: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Pairs of columns of different effects: any two of the best, and the best with every other."""
        best = sorted(range(len(singles)), key=lambda i: -singles[i].log_evidence)[:_PAIRS_AMONG]
        # what lies hidden behind another effect shows only beside it: the partner of each of the leading few
        wanted = {tuple(sorted(p)) for p in itertools.combinations(best, 2)}
        wanted |= {tuple(sorted((i, j))) for i in best[:6] for j in range(len(self.columns)) if i != j}
        wanted = [p for p in sorted(wanted) if self.columns[p[0]].effect.id != self.columns[p[1]].effect.id]
        return [self.of(p, max((singles[i] for i in p), key=lambda one: one.log_evidence)) for p in wanted]


def slack_shares(columns: Sequence[Column]) -> np.ndarray:
    """Share of each column in its effect's slack, (m,): an effect of several columns is not more wrong for it."""
    ids = [column.effect.id for column in columns]
    return np.array([1.0 / math.sqrt(ids.count(own)) for own in ids])


def effects_of(hypothesis: Hypothesis, columns: Sequence[Column]) -> tuple[str, ...]:
    """Ids of the effects of a hypothesis, sorted."""
    return tuple(sorted({columns[i].effect.id for i in hypothesis.columns}))


def way_shares(columns: Sequence[Column]) -> np.ndarray:
    """Prior probability of each column among those of its effect, (m,): its laws are alike, and so are its directions unless it grows."""
    of_direction = np.array([(_SHRINKS if c.x < 0.0 else 1.0 - _SHRINKS) if c.effect.grows else 0.5 for c in columns])
    ids = [column.effect.id for column in columns]
    total = dict.fromkeys(ids, 0.0)
    for own, share in zip(ids, of_direction, strict=True):
        total[own] += share
    return of_direction / np.array([total[own] for own in ids])


def log_prior(ids: Ids, effects: int) -> float:
    """Log prior probability of a set of at most two effects, of so many that were asked about; () is no effect."""
    if len(ids) == 2:
        return math.log(PRIOR_PAIRS / max(1, effects * (effects - 1) // 2))
    return math.log((1.0 - PRIOR_NONE - PRIOR_PAIRS) / effects if ids else PRIOR_NONE)


def weighted(hypotheses: Sequence[Hypothesis], columns: Sequence[Column],
             effects: int) -> dict[tuple[str, ...], tuple[float, Hypothesis | None]]:
    """Log posterior weight of every set of effects (laws and directions summed) and its best way; () is no effect."""
    of_way = np.log(way_shares(columns))
    groups: dict[tuple[str, ...], list[tuple[float, Hypothesis]]] = {}
    for hypothesis in hypotheses:
        ids = effects_of(hypothesis, columns)
        prior = log_prior(ids, effects) + float(np.sum(of_way[list(hypothesis.columns)]))
        groups.setdefault(ids, []).append((hypothesis.log_evidence + prior, hypothesis))
    out: dict[tuple[str, ...], tuple[float, Hypothesis | None]] = {(): (log_prior((), effects), None)}
    for ids, members in groups.items():
        best = max(members, key=lambda m: m[0])[1]
        out[ids] = (float(logsumexp([m[0] for m in members])), best)
    return out


def probabilities(weights: dict[tuple[str, ...], float]) -> dict[tuple[str, ...], float]:
    """Posterior probabilities from log weights, largest first."""
    total = logsumexp(list(weights.values()))
    found = {ids: float(np.exp(w - total)) for ids, w in weights.items()}
    return dict(sorted(found.items(), key=lambda item: -item[1]))
