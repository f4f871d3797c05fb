"""The hypotheses of one linearisation that are fitted in full, and what that says of those that are not.

The linear model ranks; the full fit decides. Where full fits fall short of what was promised, the next sets by what
is then to be expected of them are fitted too: a set is expected to fall short as its effects did in other sets.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from ddh_twin_py.gap.evidence.hypotheses import Hypothesis, Ids, probabilities
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.feigned import made_good
from ddh_twin_py.gap.explain.law_debt import LawDebt
from ddh_twin_py.gap.explain.partners import Beside, beside, partners
from ddh_twin_py.gap.explain.refit import Refit, Refitted
from ddh_twin_py.gap.explain.taken_up import taken_up
from ddh_twin_py.gap.explain.worth import Learnt, Worth

TEMPERED = 2.0
"""By which log odds between one effect and another in its place are tempered: laws that are not quite the rig's speak for one."""
_AT_ONCE = 6  # sets fitted side by side
_MOST = 12  # sets fitted in full, from which no further round of expected or close ones is begun
_FAR_BEHIND = 12.0  # log weight behind the best beyond which a set is not fitted in full
_RIVAL = 2.0  # log weight behind the best fitted within which a set is fitted before it is judged
_ANOTHER = 4.0  # the same of a set that explains without one of the best's effects: told from it wrongly, it would mislead
_KEPT = 3  # leading sets whose fits the next linearisation begins from
_ALIKE, _ALIKE_SHARE = 25.0, 0.02  # log weight behind the best, and share of what that explains, within which another is a near rival
_SAME_SIGNATURE = 50.0  # the former within which a set is fitted with what the catalogue names as confused with an effect of the best
_BENDS = 20.0  # log evidence of a single effect from which others are looked for beside it as it acts
_MISLED = 0.2  # share of what the best set explains by which the linear model falls short of it, from which every effect is fitted
_LOST = 1000.0  # log evidence of no effect over what the linear model says, from which that is not one of this rig
_JUDGED = 3  # leading pairs held against a free law of their first effect
_SHORT, _SHORT_SHARE = 10.0, 0.05  # log evidence, and share of it, that the linear model promises and no run finds: a fit that lost its way
_SHARPENED = 3  # leading sets that are then, or where they are rivals, fitted with sensitivities of their own
_BEHIND = 0.1  # log weight by which a set that nobody fitted is behind the best at least
_UNFITTED, _ROUNDS = 0.1, 3  # probability that sets may hold together which nobody fitted; rounds of fits that see to it
_POOR = 1.5  # chi-square per row above which the leading hypothesis explains too little to be the last word


@dataclass(frozen=True)
class Start:
    """Where a fit may begin: parameters (k,), departures of the effects in order of their ids and in their own units (m,)."""

    theta: np.ndarray
    x: np.ndarray


class Fits:
    """Full fits of one linearisation.

    Args:
        weights: of every set, by the linear model: log weight and best way; see `hypotheses.weighted`.
        before: of a linearisation nearby. told: called with the number of sets fitted so far.

    Attributes:
        worth: what sets are worth. fitted: sets fitted in full; () is always among them once `again` or `leaders` was called.
    """

    def __init__(self, linearised: Linearised, weights: Mapping[Ids, tuple[float, Hypothesis | None]], pool: ThreadPoolExecutor,
                 before: Learnt | None = None, told: Callable[[int], None] | None = None) -> None:
        self._told, self._count = told, 0
        self._linearised, self._weights, self._pool = linearised, weights, pool
        self.worth = Worth(linearised, weights, before or Learnt())
        self.fitted = self.worth.fitted
        self._refit = Refit(linearised)
        self._owed = LawDebt(linearised, pool)
        self._others: Beside | None = None

    def again(self, known: Mapping[Ids, Start]) -> None:
        """Fit sets from where they stood before."""
        def fit(item: tuple[Ids, Start]) -> Refitted | None:
            ids, start = item
            columns = self._columns(ids)
            if columns is None or len(columns) != len(ids):
                return None
            order = [ids.index(c.effect.id) for c in columns]
            return self._refit.of(columns, start.theta, np.array([start.x[i] / c.x for i, c in zip(order, columns, strict=True)]))

        self._take(fit, known.items())

    def on(self, linearised: Linearised) -> Fits:
        """The leading sets, fitted on from where they stand with other deviations of the same rows, and what is hidden beside their first.

        What is not fitted stays as far behind the best as it is here.
        """
        out = Fits(linearised, self._weights, self._pool, self.worth.learnt(), self._told)
        out._count, out._others = self._count, self._others
        there = {column.way: column for column in linearised.columns}
        least = self.worth.full(self.worth.best()) - _FAR_BEHIND
        leading = [ids for ids in self.fitted if not ids or (ids in self._weights and self.worth.full(ids) > least)]
        out._take(out._refit.again, [replace(f, columns=tuple(there[c.way] for c in f.columns)) for f in map(self.fitted.get, leading)])
        out._beside()
        return out

    def leaders(self) -> None:
        """Fit the leading sets, and further ones for as long as one is expected to be as good as the best that was fitted."""
        promised = self.worth.expected()
        best = max(promised.values())
        ranked = sorted((ids for ids in promised if ids and best - promised[ids] < _FAR_BEHIND), key=lambda ids: -promised[ids])
        single = max((ids for ids in promised if len(ids) == 1), key=lambda ids: promised[ids], default=())
        self._fit(dict.fromkeys([(), *ranked[:_AT_ONCE], single]))
        while len(self.fitted) < _MOST:
            expected, best = self.worth.expected(), self.worth.best()
            least = {ids: self.worth.full(best) - (_RIVAL if set(ids) >= set(best) else _ANOTHER) for ids in expected}
            rest = [ids for ids in expected if ids not in self.fitted and expected[ids] > least[ids]]
            rest.sort(key=lambda ids: -expected[ids])
            rest = rest or self._rivals()
            if not rest:
                break
            self._fit(rest[:_AT_ONCE])
        self._fit(self._alike())
        self._beside()
        self._once_judged()
        best_fit = max(self.fitted.values(), key=lambda f: f.log_evidence)
        if best_fit.columns:
            self._by_parameters(best_fit)

    def _rivals(self) -> list[Ids]:
        """Sets not fitted that the linear model holds for about as good as the best: that they fell short elsewhere is no proof."""
        best = self.worth.best()
        least = self.worth.full(best) - _ANOTHER + (max(0.0, self.worth.off()) if self.worth.off() > self.worth.off_elsewhere else 0.0)
        close = [ids for ids, (weight, _) in self._weights.items() if weight > least and ids not in self.fitted]
        return sorted((ids for ids in close if not best or not set(ids) >= set(best)), key=lambda ids: -self._weights[ids][0])

    def _alike(self) -> list[Ids]:
        """Sets not fitted in which an effect of the best is replaced by one that shows alike in common duties."""
        expected, best = self.worth.expected(), self.worth.best()
        confused = {c.effect.id: c.effect.confused_with for c in self._linearised.columns}
        found = []
        for name in best:
            others = {*confused[name], *(other for other, known in confused.items() if name in known)} - set(best)
            found += [tuple(sorted({*best} - {name} | {other})) for other in others]
        wanted = [ids for ids in dict.fromkeys(found) if ids in expected and ids not in self.fitted]
        least = self.worth.full(best) - max(_SAME_SIGNATURE, self._reach(best))
        wanted = [ids for ids in wanted if max(expected[ids], self._weights[ids][0]) > least]
        return sorted(wanted, key=lambda ids: -expected[ids])[:_AT_ONCE]

    def _beside(self) -> None:
        """Fit pairs that do well beside the best single effect as it acts: the linear model knows none acting."""
        single = max((ids for ids in self.fitted if len(ids) == 1 and ids in self._weights), key=self.worth.full, default=())
        if not single or self.worth.gain(single) < _BENDS:
            return
        first = self.fitted[single]
        if self._others is None or not self._others.holds(first):
            self._others = beside(self._linearised, first, self._pool)
        found = partners(self._linearised, self._refit, first, self._others)
        none, least = self.fitted[()].log_evidence, self.worth.full(self.worth.best()) - _ANOTHER
        weight = {ids: self._weights[ids][0] - self.worth.linear(ids) + log - none
                  for ids, (log, _) in found.items() if ids in self._weights}
        self.worth.beside_first = weight
        known = {ids: self.worth.full(ids) for ids in weight if ids in self.fitted}  # perhaps another way of its effects
        wanted = sorted((ids for ids in weight if weight[ids] > max(least, known.get(ids, least) + _RIVAL)), key=lambda ids: -weight[ids])

        def fit(ids: Ids) -> Refitted:
            pair = found[ids][1]
            return self._refit.of([self._linearised.columns[i] for i in pair.columns], pair.shared, pair.departure)

        self._take(fit, wanted[:_AT_ONCE])

    def _once_judged(self) -> None:
        """Fit sets that are expected to be as good as the best once a law that is off has its due."""
        best, expected = max(self._judged().values()), self.worth.expected()
        promised = {ids: expected[ids] - self._by_law(ids) for ids in expected if ids not in self.fitted}
        wanted = [ids for ids in promised if promised[ids] > best - _RIVAL]
        self._fit(sorted(wanted, key=lambda ids: -promised[ids])[:_AT_ONCE])

    def _by_parameters(self, fitted: Refitted) -> None:
        """Fit no effect from where a hypothesis led the parameters, and what is left of it where they do what some of its effects did."""
        every = range(len(fitted.columns))
        parts = [part for size in range(1, len(every) + 1) for part in itertools.combinations(every, size)]

        def fit(part: tuple[int, ...]) -> Refitted | None:
            if not part:
                return self._refit.of([], fitted.theta, np.zeros(0))
            theta = taken_up(self._linearised.model, fitted.theta, [fitted.acting[i] for i in part])
            rest = [i for i in every if i not in part]
            if theta is None:
                return None
            return self._refit.of([fitted.columns[i] for i in rest], theta, np.array([fitted.x[i] / fitted.columns[i].x for i in rest]))

        self._take(fit, [(), *parts])

    def settle(self) -> None:
        """Fit the likeliest of those sets that were not fitted, where together they hold much of the probability.

        Each is held to be worth less than those that were fitted, but ten of them would outweigh these.
        """
        for _ in range(_ROUNDS):
            rest = {ids: p for ids, p in self.probability().items() if ids not in self.fitted}
            if sum(rest.values()) <= _UNFITTED:
                break
            self._fit(list(rest)[:_AT_ONCE])

    def poor(self) -> bool:
        """Whether even the best leaves much more than noise."""
        rows = sum(c.size for c in self._linearised.comparisons)
        best = max(self.fitted.values(), key=lambda f: f.log_evidence)
        return best.chi_square > _POOR * self._linearised.power * rows

    def misled(self) -> bool:
        """Whether the best set explains so much more than the linear model said that its ranking says little of others."""
        best = self.worth.best()
        if not best:
            return False
        gain = self.worth.gain(best)
        return gain > _BENDS and gain - self.worth.linear(best) > _MISLED * gain

    def lost(self) -> bool:
        """Whether the linear model is so wrong of no effect that it is one of runs that went astray, and says nothing of any."""
        return self.worth.off() > _LOST

    def every_effect(self) -> None:
        """Fit every effect in each of its ways: a large one bends, and no line shows where it leads."""
        def fit(column: Column) -> Refitted:
            hypothesis = self._weights[(column.effect.id,)][1]
            departure = [d for i, d in zip(hypothesis.columns, hypothesis.departure, strict=True) if self._linearised.columns[i] is column]
            return self._refit.of([column], self._linearised.theta, np.array(departure or [1.0]))

        self._take(fit, self._linearised.columns)

    def fell_short(self) -> bool:
        """Whether the linear model promises of the best set what no run has found: a fit may have lost its way.

        Both are held against each other as they are and not over no effect, of which the linear model knows little where others act.
        """
        best = self.worth.best()
        promised = self._linearised.evidence.log_of_none + self.worth.linear(best)
        return bool(best) and promised - self.fitted[best].log_evidence > max(_SHORT, _SHORT_SHARE * self.worth.linear(best))

    def sharpen(self) -> None:
        """Fit the leading sets from where sensitivities lead that are taken with their effects acting, where that may decide.

        Those of the linear model know no effect. A resistance between winding and housing that is grown eightfold turns a motor's heat
        another way, and steps by them creep: of two rivals that stopped on the way neither is known for the better one.
        """
        altered = [i for i, acts in enumerate(self._linearised.model.altered) if acts]
        own = self._linearised
        reached = [Refit(own.acting_at(fitted.theta, fitted.acting, altered, self._pool)).again(fitted)
                   for fitted in (self.fitted[ids] for ids in self._unsettled())]
        self._take(self._refit.again, reached)

    def _unsettled(self) -> list[Ids]:
        """Leading sets of which it is not known which is the best: others instead of the first are near, or a fit lost its way."""
        leading = sorted((ids for ids in self.fitted if ids and ids in self._weights), key=lambda ids: -self.worth.full(ids))
        if self.fell_short():
            return leading[:_SHARPENED]
        if not leading or self.worth.gain(leading[0]) < _BENDS:
            return []
        best, least = set(leading[0]), self.worth.full(leading[0]) - self._reach(leading[0])
        near = [ids for ids in leading[1:] if self.worth.full(ids) > least and not best >= {*ids} and not best <= {*ids}]
        return [leading[0], *near[: _SHARPENED - 1]] if near else []

    def _reach(self, best: Ids) -> float:
        """Log weight behind the best set within which another may turn out to be better."""
        return max(_ALIKE, _ALIKE_SHARE * self.worth.gain(best))

    def probability(self) -> dict[Ids, float]:
        """Full fits stand before linear ones; a set that was not fitted is as good as is expected of it, but not the best."""
        out = self._judged()
        best = max(out, key=out.get)
        for ids in out:
            if len(ids) == len(best) == len({*ids} & {*best}) + 1:
                out[ids] += (1.0 - 1.0 / TEMPERED) * (out[best] - out[ids])
        highest = min(max(out.values()) - _BEHIND, max(min(out.values()), logsumexp(list(out.values())) - 1.0))
        for ids, weight in self.worth.expected().items():
            out.setdefault(ids, min(weight - self._by_law(ids), highest))
        return probabilities(out)

    def _without_slight(self) -> None:
        """Fit what is left of leading sets of which an effect came out too slight to be one: nothing else would stand for it."""
        least = self.worth.full(self.worth.best()) - _FAR_BEHIND
        leading = [ids for ids in self.fitted if ids in self._weights and self.worth.full(ids) > least]

        def rest(fitted: Refitted) -> Ids:
            return tuple(name for name in fitted.effects if name not in fitted.slight)

        def fit(fitted: Refitted) -> Refitted:
            kept = [(c, x) for c, x in zip(fitted.columns, fitted.x, strict=True) if c.effect.id not in fitted.slight]
            return self._refit.of([c for c, _ in kept], fitted.theta, np.array([x / c.x for c, x in kept]))

        self._take(fit, [fitted for fitted in (self.fitted[ids] for ids in leading) if rest(fitted) not in self.fitted])

    def _judged(self) -> dict[Ids, float]:
        """Log weights of the sets that were fitted, less what an effect's law may be to blame for, with what one of the rig makes good."""
        self._without_slight()
        pairs = [ids for ids in self.fitted if len(ids) == 2 and ids in self._weights]
        leading = sorted(pairs, key=lambda ids: -self.worth.full(ids))[:_JUDGED]
        self._fit([one for one in dict.fromkeys(map(self._first_of, leading)) if one not in self.fitted])
        full = {ids: self.worth.full(ids) for ids in self.fitted if ids in self._weights}
        beyond = self._owed.in_full(leading, self.fitted, full)
        owed = {ids: beyond[ids] if ids in beyond else self._by_law(ids) for ids in full}
        by_rig = made_good(self.fitted)
        return {ids: weight - owed[ids] + by_rig.get(ids, 0.0) for ids, weight in full.items()}

    def _by_law(self, ids: Ids) -> float:
        """Log weight that a set may owe to a law that is off; see `LawDebt`."""
        return self._owed.at_most(ids, self.fitted)

    def _first_of(self, pair: Ids) -> Ids:
        """The effect of a pair that is held to explain more by itself; one that nobody fitted would have no law to be off."""
        expected = self.worth.expected()
        ones = [(name,) for name in pair if (name,) in expected]
        return max(ones, key=lambda one: self.worth.full(one) if one in self.fitted else expected[one], default=())

    def starts(self, found) -> dict[Ids, Start]:
        """Where the leading sets stand, for another linearisation."""
        out = {}
        for ids in found.leading(_KEPT):
            fitted = self.fitted[ids]
            x = dict(zip((c.effect.id for c in fitted.columns), fitted.x, strict=True))
            out[ids] = Start(fitted.theta, np.array([x[name] for name in ids]))
        return out

    def _columns(self, ids: Ids) -> list[Column] | None:
        if not ids:
            return []
        entry = self._weights.get(ids)
        return [self._linearised.columns[i] for i in entry[1].columns] if entry else None

    def _fit(self, wanted: Sequence[Ids]) -> None:
        def fit(ids: Ids) -> Refitted:
            hypothesis = self._weights[ids][1]
            departure = hypothesis.departure if hypothesis else np.zeros(0)
            return self._refit.of(self._columns(ids), self._linearised.shared(hypothesis), departure)

        self._take(fit, wanted)

    def _take(self, fit: Callable, items) -> None:
        for found in self._pool.map(fit, items):
            self._count += 1
            if self._told is not None:
                self._told(self._count)
            if found is None or not np.isfinite(found.log_evidence):
                continue
            known = self.fitted.get(found.effects)
            if known is None or found.log_evidence > known.log_evidence:
                self.fitted[found.effects] = found
