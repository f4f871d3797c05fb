"""A case about one place: what every signal answers to every parameter and effect, computed once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy, scatter_of
from ddh_twin_py.estimation.fitting.weighting import Weighting
from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.evidence.basis import Basis
from ddh_twin_py.gap.evidence.hypotheses import WIDTH, Evidence, Hypothesis, Ids, slack_shares, weighted
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.evidence.sensitivity import Column, Way, stacked, taken_at, without_astray
from ddh_twin_py.gap.evidence.slopes import slopes_of
from ddh_twin_py.gap.model import Model

STANDS_OUT = 4.5
"""Standard deviations of what tolerances can feign, by which an effect without a commissioning recording typically stands out."""
NEARBY = 0.5
"""Deviations of every parameter, within which sensitivities are not taken anew."""
_BEYOND = 1.0e3  # deviations, beyond every bound


@dataclass(frozen=True)
class Linearised:
    """Sensitivities of a case at one place, without any effect acting.

    Attributes:
        question: that is asked. theta: parameters there, in deviations, (k,). predictions: there, by recording.
        comparisons: by recording. sensitivities: by recording, (rows, k). columns: of the effects.
        taken: parameters at which these were taken, (k,). astray: ways of effects in which runs went astray there.
    """

    question: Question
    theta: np.ndarray
    predictions: list[dict[str, np.ndarray]]
    comparisons: list[Comparison]
    sensitivities: list[np.ndarray]
    columns: list[Column]
    taken: np.ndarray
    astray: frozenset[Way] = frozenset()
    basis: Basis = field(init=False, repr=False)
    evidence: Evidence = field(init=False, repr=False)

    def __post_init__(self) -> None:
        ends = np.full(self.theta.size, _BEYOND)
        basis = Basis(Weighting(self.comparisons), self.sensitivities, self.of_slack(), self.model.within(-ends), self.model.within(ends),
                      self.power)
        shares, values = self._slack_shares(), self.values()
        sums = basis.both_of_slack(shares, values) if np.all(shares) else basis.both(self.of_columns(), values)
        object.__setattr__(self, "basis", basis)
        object.__setattr__(self, "evidence", Evidence(*sums, self.columns, self.question.widths))

    @property
    def model(self) -> Model:
        """See `Question`."""
        return self.question.model

    @property
    def discrepancy(self) -> Discrepancy:
        """See `Question`."""
        return self.question.discrepancy

    @property
    def slack(self) -> float:
        """See `Question`."""
        return self.question.slack

    @property
    def power(self) -> float:
        """See `Question`."""
        return self.question.power

    def of_columns(self) -> list[np.ndarray]:
        """Effects' columns by recording, (rows, m)."""
        return stacked(self.columns, self.comparisons)

    def of_slack(self) -> list[np.ndarray]:
        """The same, as large as the model's laws may be off."""
        shares = self._slack_shares()
        return [rows * shares for rows in self.of_columns()]

    def _slack_shares(self) -> np.ndarray:
        """Share of each column by which it is slack, (m,)."""
        return self.slack * slack_shares(self.columns)

    def values(self) -> list[np.ndarray]:
        """What parameters and effects have to explain: residuals with the parameters' prior centred on the sheet."""
        return [c.residual(p) + j @ self.theta for c, p, j in zip(self.comparisons, self.predictions, self.sensitivities, strict=True)]

    def shared(self, hypothesis: Hypothesis | None) -> np.ndarray:
        """Parameters, in deviations, (k,), where a hypothesis holds, by the linear model."""
        return hypothesis.shared if hypothesis else self.evidence.none.shared

    def left(self, hypothesis: Hypothesis | None) -> list[np.ndarray]:
        """Residuals that a hypothesis leaves, by recording, (rows,)."""
        theta = self.shared(hypothesis)
        out = [v - j @ theta for v, j in zip(self.values(), self.sensitivities, strict=True)]
        if hypothesis:
            out = [o - rows[:, list(hypothesis.columns)] @ hypothesis.departure for o, rows in zip(out, self.of_columns(), strict=True)]
        return out

    def weights(self) -> dict[Ids, tuple[float, Hypothesis | None]]:
        """Log weight and best way of every set of effects, by the linear model; see `hypotheses.weighted`."""
        singles = self.evidence.singles()
        return weighted(singles + self.evidence.pairs(singles), self.columns, len(self.question.effects))

    def standing_out(self) -> Linearised:
        """The same with columns as long as an effect must be to stand out from what the rig's tolerances can feign."""
        told = self.basis.otherwise(1.0, 1.0).sums(self.of_columns(), self.values()).information
        feigned = 1.0 / np.sqrt(np.maximum(np.diagonal(told), 1e-12))
        typical = STANDS_OUT * feigned / (math.sqrt(2.0) * WIDTH)
        return replace(self, columns=[c.longer(max(1.0, float(t))) for c, t in zip(self.columns, typical, strict=True)])

    def with_scatter(self, hypothesis: Hypothesis | None) -> Linearised:
        """The same with classes as uncertain as their bins scatter under a hypothesis; no run is needed."""
        known = self.discrepancy.scatter
        return self.scattering({name: known.get(name, 1.0) * factor for name, factor in self._in_altered(self.left(hypothesis)).items()})

    def scatter_beside(self, predictions: Sequence[dict[str, np.ndarray]]) -> dict[tuple, float]:
        """How much the bins of each class scatter, over their noise, beside runs of every recording."""
        left = [c.residual(p) for c, p in zip(self.comparisons, predictions, strict=True)]
        return self._in_altered(left, self.discrepancy.scatter)

    def scattering(self, scatter: Mapping[tuple, float]) -> Linearised:
        """The same with classes as uncertain as they scatter so, over their noise; no run is needed."""
        return self._with(self.theta, replace(self.discrepancy, scatter={**self.discrepancy.scatter, **scatter}), self.predictions)

    def _in_altered(self, left: Sequence[np.ndarray], widened: Mapping[tuple, float] | None = None) -> dict[tuple, float]:
        """See `scatter_of`; of several recordings in which effects act, their root mean square."""
        found: dict[tuple, list[float]] = {}
        for comparison, rows, altered in zip(self.comparisons, left, self.model.altered, strict=True):
            if altered:
                for name, factor in scatter_of(comparison, rows, widened).items():
                    found.setdefault(name, []).append(factor)
        return {name: float(np.sqrt(np.mean(np.square(factors)))) for name, factors in found.items()}

    def nearby(self, theta: np.ndarray) -> Linearised:
        """The same about parameters (k,) nearby, with the sensitivities as they are: each recording is run once."""
        return self._with(theta, self.discrepancy, self.model.run(theta, ()))

    def held_at(self, theta: np.ndarray) -> Linearised:
        """The same as seen from parameters (k,) that are held there: nothing of the rig is left open. Columns stay what they are here."""
        there = self.nearby(theta)
        return replace(there, theta=self.theta, sensitivities=[np.zeros_like(rows) for rows in there.sensitivities])

    def acting_at(self, theta: np.ndarray, acting: Acting, numbers: Sequence[int], pool: ThreadPoolExecutor) -> Linearised:
        """The same with sensitivities of the recordings ``numbers`` taken at parameters (k,) where effects act; all else stays."""
        beside = list(self.sensitivities)
        slopes = slopes_of(self.model, pool, theta, self.comparisons, numbers, acting=acting, roughly=True)
        for i, rows in zip(numbers, slopes, strict=True):
            beside[i] = without_astray(rows)
        return replace(self, sensitivities=beside)

    def _with(self, theta: np.ndarray, discrepancy: Discrepancy, predictions: list[dict[str, np.ndarray]]) -> Linearised:
        """The same sensitivities in the deviations of another comparison."""
        comparisons = [Comparison(s, p, discrepancy) for s, p in zip(self.model.signals, predictions, strict=True)]
        ratios = [old.spread / new.spread for old, new in zip(self.comparisons, comparisons, strict=True)]
        return replace(self, question=self.question.forgiving(discrepancy), theta=theta, predictions=predictions, comparisons=comparisons,
                       sensitivities=[j * r[:, None] for j, r in zip(self.sensitivities, ratios, strict=True)],
                       columns=[c.stretched(ratios) for c in self.columns])


def linearise(question: Question, theta: np.ndarray, pool: ThreadPoolExecutor, progress: Callable[[float], None] | None = None,
              near: Linearised | None = None, resized: bool = True) -> Linearised:
    """Take all sensitivities at a place.

    Args:
        theta: parameters, in deviations, (k,). progress: told the share done.
        near: taken before: its sensitivities of recordings in which no effect acts are kept, and runs that went astray are tried again.
        resized: whether the sizes of all columns are sought; else those of ``near`` are kept that have still a typical rise.
    """
    model = question.model
    predictions = model.run(theta, ())
    comparisons = [Comparison(s, p, question.discrepancy) for s, p in zip(model.signals, predictions, strict=True)]
    numbers = [i for i, altered in enumerate(model.altered) if altered or near is None]
    told = (lambda share: progress(0.5 * share)) if progress else None
    fresh = {number: without_astray(rows)
             for number, rows in zip(numbers, slopes_of(model, pool, theta, comparisons, numbers, told, roughly=True), strict=True)}
    sensitivities = [fresh[i] if i in fresh else near.sensitivities[i] * (near.comparisons[i].spread / c.spread)[:, None]
                     for i, c in enumerate(comparisons)]
    told = (lambda share: progress(0.5 + 0.5 * share)) if progress else None
    columns, astray = taken_at(question.effects, model, theta, comparisons, pool, told, () if resized else near.columns,
                               near.astray if near else (), keep=False)
    found = Linearised(question, theta, predictions, comparisons, sensitivities, columns, theta, frozenset(astray))
    return found.standing_out() if all(model.altered) else found
