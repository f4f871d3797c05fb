"""Second effects beside one that acts: how every signal answers to them there, where a large first effect has bent the rig."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Comparison
from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.evidence.hypotheses import Evidence, Hypothesis, Ids
from ddh_twin_py.gap.evidence.linearised import NEARBY, Linearised
from ddh_twin_py.gap.evidence.sensitivity import Column, columns_of
from ddh_twin_py.gap.explain.refit import Refit, Refitted
from ddh_twin_py.gap.model import FreeRuns

_SAME_SIZE = 0.1  # of a first effect's departure, within which others beside it are not run anew

class _Acted:
    """A model in which effects act already; what `sensitivity.columns_of` asks of a model."""

    def __init__(self, model: FreeRuns, acting: Acting) -> None:
        self._model, self._acting = model, tuple(acting)
        self.signals, self.altered, self.witnesses = model.signals, model.altered, model.witnesses

    def run_one(self, number: int, theta: np.ndarray, acting: Acting = (), roughly: bool = False) -> dict[str, np.ndarray]:
        """Free run of one recording with those effects and others."""
        return self._model.run_one(number, theta, (*self._acting, *acting), roughly=roughly)


@dataclass(frozen=True)
class Beside:
    """How every signal answers to second effects where a first one acts.

    Attributes:
        first: that effect, as it was fitted. columns: of the others there. comparisons: by recording, in whose deviations they are.
    """

    first: Refitted
    columns: list[Column]
    comparisons: list[Comparison]

    def holds(self, first: Refitted) -> bool:
        """Whether it is near enough for another fit of that effect."""
        same = [c.way for c in self.first.columns] == [c.way for c in first.columns]
        if not same or np.any(np.abs(first.x - self.first.x) > _SAME_SIZE * np.abs(self.first.x)):
            return False
        moved = np.concatenate([first.theta - self.first.theta, first.beside - self.first.beside])
        return bool(np.abs(moved).max() < NEARBY)

    def of(self, comparisons: Sequence[Comparison]) -> list[Column]:
        """The columns in deviations of other comparisons of the same rows."""
        ratios = [old.spread / new.spread for old, new in zip(self.comparisons, comparisons, strict=True)]
        return [c.stretched(ratios) for c in self.columns]


def beside(linearised: Linearised, first: Refitted, pool: ThreadPoolExecutor) -> Beside:
    """What second effects do beside a first at its optimum; each recording in which effects act is run once for each of their ways."""
    near = [c for c in linearised.columns if c.effect.id != first.columns[0].effect.id]
    effects = {c.effect.id: c.effect for c in near}
    acted = _Acted(linearised.model, first.acting)
    return Beside(first, columns_of(list(effects.values()), acted, first.theta, linearised.comparisons, pool, near=near),
                  linearised.comparisons)


def partners(linearised: Linearised, refit: Refit, first: Refitted, there: Beside) -> dict[Ids, tuple[float, Hypothesis]]:
    """Every second effect beside a first: log evidence, to be compared with that of full fits, and the pair in the case's columns.

    What the linear model promises of the first alone and no step of its fit found, it promises of every pair too; that is taken off.

    Args:
        refit: fits of the case. first: one effect at its optimum. there: what others do beside it.
    """
    own, found = first.columns[0], there.of(linearised.comparisons)
    ways = {c.way: number for number, c in enumerate(linearised.columns)}
    local, values = refit.local(first)
    known = [linearised.columns[ways[c.way]] for c in found]
    columns = [own, *(c.longer(k.x / c.x) for c, k in zip(found, known, strict=True))]
    rows = [np.column_stack([mine, *(c.change[number] for c in columns[1:])]) for number, mine in enumerate(local)]
    evidence = Evidence(*linearised.basis.both(rows, values), columns, linearised.question.widths)
    promised = max(0.0, evidence.of([0]).log_evidence + evidence.log_of_none - first.log_evidence)
    out: dict[Ids, tuple[float, Hypothesis]] = {}
    for number in range(1, len(columns)):
        pair, second = evidence.of([0, number]), columns[number]
        ids, log = tuple(sorted((own.effect.id, second.effect.id))), pair.log_evidence + evidence.log_of_none - promised
        if ids not in out or log > out[ids][0]:
            places = [ways[c.way] for c in (own, second)]
            scale = np.array([1.0, second.x / linearised.columns[places[1]].x])
            order = np.argsort(places)
            out[ids] = log, Hypothesis(tuple(places[i] for i in order), log, (pair.departure * scale)[order], (pair.spread * scale)[order],
                                       pair.shared)
    return out
