"""Second effects beside one that acts: how every signal answers to them there, where a large first effect has bent the rig."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.evidence.hypotheses import Evidence, Hypothesis, Ids
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import columns_of
from ddh_twin_py.gap.explain.refit import Refit, Refitted
from ddh_twin_py.gap.model import FreeRuns


class _Acted:
    """A model in which effects act already; what `sensitivity.columns_of` asks of a model."""

    def __init__(self, model: FreeRuns, acting: Acting) -> None:
        self._model, self._acting = model, tuple(acting)
        self.signals, self.altered, self.witnesses = model.signals, model.altered, model.witnesses

    def run_one(self, number: int, theta: np.ndarray, acting: Acting = (), roughly: bool = False) -> dict[str, np.ndarray]:
        """Free run of one recording with those effects and others."""
        return self._model.run_one(number, theta, (*self._acting, *acting), roughly=roughly)


def partners(linearised: Linearised, refit: Refit, first: Refitted, pool: ThreadPoolExecutor) -> dict[Ids, tuple[float, Hypothesis]]:
    """Every second effect beside a first: log evidence, to be compared with that of full fits, and the pair in the case's columns.

    What the linear model promises of the first alone and no step of its fit found, it promises of every pair too; that is taken off.

    Args:
        refit: fits of the case. first: one effect at its optimum.
    """
    own = first.columns[0]
    near = [c for c in linearised.columns if c.effect.id != own.effect.id]
    effects = {c.effect.id: c.effect for c in near}
    acted = _Acted(linearised.model, first.acting)
    found = columns_of(list(effects.values()), acted, first.theta, linearised.comparisons, pool, near=near)
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
