"""What sets of effects are worth: those that were fitted by their fits, others by the linear model and by what became of it elsewhere."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ddh_twin_py.gap.evidence.hypotheses import Hypothesis, Ids
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.refit import Refitted


@dataclass(frozen=True)
class Learnt:
    """What the fits of one linearisation tell those of another nearby; it holds no runs and no sensitivities.

    Attributes:
        short: by how much sets with an effect fell short of the linear model at least, log weight, by effect.
        expected: what every set is expected to be worth where the linear model was least wrong of no effect so far.
        off: by how much log evidence it was wrong there.
    """

    short: Mapping[str, float] = field(default_factory=dict)
    expected: Mapping[Ids, float] = field(default_factory=dict)
    off: float = math.inf


class Worth:
    """Log weights of sets of effects on one linearisation.

    Args:
        weights: of every set, by the linear model: log weight and best way; see `hypotheses.weighted`.
        before: of a linearisation nearby.

    Attributes:
        fitted: sets fitted in full. off_elsewhere: by how much log evidence the linear model was wrong of no effect where it was least so.
        beside_first: log weight of pairs that were weighed beside their first effect as it acts.
    """

    def __init__(self, linearised: Linearised, weights: Mapping[Ids, tuple[float, Hypothesis | None]], before: Learnt) -> None:
        self._linearised, self._weights = linearised, weights
        self._learnt, self._elsewhere, self.off_elsewhere = before.short, before.expected, before.off
        self.fitted: dict[Ids, Refitted] = {}
        self.beside_first: dict[Ids, float] = {}

    def gain(self, ids: Ids) -> float:
        """Log evidence over no effect, in full."""
        return self.fitted[ids].log_evidence - self.fitted[()].log_evidence

    def linear(self, ids: Ids) -> float:
        """The same by the linear model."""
        hypothesis = self._weights[ids][1]
        return hypothesis.log_evidence if hypothesis else 0.0

    def bent(self, ids: Ids) -> float:
        """By how much log evidence the linear model is wrong of a set that was fitted, or of no effect where it was not right elsewhere."""
        wrong = abs(self.fitted[ids].log_evidence - self._linearised.evidence.log_of_none - self.linear(ids))
        return wrong if self.off_elsewhere < abs(self.off()) else max(wrong, abs(self.off()), abs(self.gain(ids) - self.linear(ids)))

    def learnt(self) -> Learnt:
        """What these fits tell those of another linearisation."""
        off = abs(self.off())
        known = (self.expected(), off) if off <= self.off_elsewhere else (self._elsewhere, self.off_elsewhere)
        return Learnt(self._short(), *known)

    def off(self) -> float:
        """Log evidence of no effect over what the linear model says; about where effects act it knows little of none."""
        none = self.fitted.get(())
        return none.log_evidence - self._linearised.evidence.log_of_none if none else 0.0

    def full(self, ids: Ids) -> float:
        """Log weight of a set that was fitted."""
        return self._weights[ids][0] - self.linear(ids) + self.gain(ids)

    def _short(self) -> dict[str, float]:
        """By how much sets with an effect fell short of the linear model at least, log weight, by effect."""
        found: dict[str, float] = {}
        for ids in self.fitted:
            if ids in self._weights:
                fell = min(0.0, self.full(ids) - self._weights[ids][0])
                for name in ids:
                    found[name] = max(found.get(name, -math.inf), fell)
        return {**self._learnt, **found}

    def best(self) -> Ids:
        """Of the sets that were fitted the one of largest log weight, () where none was."""
        return max((ids for ids in self.fitted if ids in self._weights), key=self.full, default=())

    def expected(self) -> dict[Ids, float]:
        """Log weight of every set, as far short of the linear one as sets with one of its effects fell at least.

        Where the best that was fitted does better than the linear model said, others with one of its effects are expected to do so too;
        pairs that were weighed beside their first effect as it acts are expected to do as well as there.
        """
        short, best = self._short(), self.best()
        more = max(0.0, self.full(best) - self._weights[best][0]) if best else 0.0
        out = {ids: weight + min((short.get(name, 0.0) for name in ids), default=0.0) + (more if set(ids) & set(best) else 0.0)
               for ids, (weight, _) in self._weights.items()}
        if self.off() > self.off_elsewhere:  # here others mend what no effect lacks at this place alone
            out.update({ids: min(weight, out[ids]) for ids, weight in self._elsewhere.items() if ids in out and not set(ids) & set(best)})
        beside = self.beside_first
        more = max(0.0, self.full(best) - beside[best]) if best in beside else 0.0
        return {**out, **{ids: weight + more for ids, weight in beside.items()}}
