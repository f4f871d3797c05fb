"""A described rig diagnosed, and diagnosed again with what was found built in.

No model of a real rig leaves noise alone, so that the engine mostly adds that something acts which no listed effect explains. What
is believed of the listed effects is therefore judged among them, and built in where it surely shrinks data that took no part; the engine's
own verdict stands beside it and says what is left.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Discrepancy
from ddh_twin_py.gap import answer
from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found, search
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.gap.locate.lacking import ActingEffect, lacks
from ddh_twin_py.gap.recordings.suitability import unseen
from ddh_twin_py.gap.verdict.tolerance import without_parameters
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.verdict import Verdict, judge
from ddh_twin_py.real_rigs.figures import surely_smaller
from ddh_twin_py.real_rigs.fit import by_steps
from ddh_twin_py.real_rigs.next_test import why_none
from ddh_twin_py.real_rigs.rig_model import RigModel

ROUNDS = 3
"""Diagnoses of one rig, each with what was found before it built in."""
_THREADS = 2


_NOTHING_ELSE = Unknown(0.0, [], 0.0, "1")


@dataclass(frozen=True)
class Outcome:
    """What a diagnosis of a model found.

    Attributes:
        model: that was diagnosed. diagnosis: the engine's whole answer. found: what its search left.
        listed: its verdict with what no listed effect explains left aside.
        plain: the model fitted without effects. leader: with those of the most probable listed set.
        shrinks: whether the leader surely shrinks the residuals of data that took no part, see `figures.surely_smaller`.
    """

    model: RigModel
    diagnosis: Diagnosis
    found: Found
    listed: Verdict
    plain: Refitted
    leader: Refitted
    shrinks: bool

    @property
    def verdict(self) -> str:
        """The engine's, a word of the contract."""
        return self.diagnosis.report["verdict"]

    @property
    def believed(self) -> tuple[str, ...]:
        """Listed effects that explain what listed effects can and surely shrink what took no part; () where there are none."""
        return self.leader.effects if self.listed.word == "explained" and self.shrinks else ()

    @property
    def probability(self) -> float:
        """Of the leading listed set, among listed ones."""
        return self.listed.sets.get(self.leader.effects, 0.0)

    def places(self) -> list[Lack]:
        """What the leader's effects add, each on the whole and by regime, whatever no listed effect explains."""
        model, number = self.model, self.model.first
        rows = []
        for i, (effect, _, x) in enumerate(self.leader.acting):
            others = [a for j, a in enumerate(self.leader.acting) if j != i]
            course = model.course(effect, model.record(number, self.leader.theta, others),
                                  model.record(number, self.leader.theta, self.leader.acting))
            std = float(np.sqrt(self.leader.covariance[i, i])) / max(abs(x), 1e-300)
            rows.append(ActingEffect(effect, course, 1.0 / len(self.leader.acting), {"all": 1.0}, std))
        return lacks(rows)

    def why_no_test(self) -> str:
        """Why the report proposes no next test, one sentence."""
        if self.verdict == "no_gap":
            return "There is no gap to explain; no next test is computed."
        return why_none(self.model.tests, without_parameters(self.model, self.found))

    def as_json(self) -> dict:
        """The engine's report, and what was made of it."""
        return {"report": self.diagnosis.report, "listed": {" + ".join(ids) or "none": p for ids, p in list(self.listed.sets.items())[:8]},
                "believed": list(self.believed), "shrinks": self.shrinks}

    def corrected(self) -> RigModel:
        """The model with the leader's effects built in."""
        spread = np.sqrt(np.diagonal(self.leader.covariance))
        return self.model.with_effects(self.leader.theta, self.leader.acting, spread)


def diagnose(model: RigModel, progress: Callable[[float], None] | None = None, discrepancy: Discrepancy | None = None,
             start: Callable[[RigModel], np.ndarray] = by_steps) -> Outcome:
    """Fit, search, answer.

    Args:
        progress: told the share done. discrepancy: what the model is forgiven; the engine's own where None.
        start: gives the place at which the search begins, deviations, (k,).

    Raises:
        ValueError: no sample takes no part in finding and fitting.
    """
    held = model.held_data()
    if not any(held.mask()(signal).any() for signals in held.signals() for signal in signals.values()):
        raise ValueError(f"{', '.join(run.name for run in model.held or model.field)}: nothing is held out, by which an answer could be "
                         "refuted; give the model recordings as `held`, or signals a `held_from` before their end")
    told = progress or (lambda share: None)
    started = time.perf_counter()
    begun = start(model)
    seconds = {"fit of the rig": time.perf_counter() - started}
    told(0.3)
    with ThreadPoolExecutor(max_workers=_THREADS) as pool:
        question = Question(model, model.effects, discrepancy or Discrepancy())
        found = search(question, begun, pool, lambda done: told(0.3 + 0.6 * done))
        seconds["search"] = time.perf_counter() - started - sum(seconds.values())
        result = answer.diagnosis(model, found, begun, unseen(model.effects, found.linearised.columns), seconds,
                                  lambda done: told(0.9 + 0.1 * done))
    seconds["answer"] = time.perf_counter() - started - sum(seconds.values())
    kept = without_parameters(model, found)
    plain = found.fitted[()]
    leader = found.fitted.get(kept.leader, plain)
    told(1.0)
    listed = judge(kept, _NOTHING_ELSE, result.gap("before") <= 1.0)
    return Outcome(model, replace(result, seconds=seconds), found, listed, plain, leader,
                   bool(leader.columns) and _shrinks(model, plain, leader))


def rounds(model: RigModel, progress: Callable[[float], None] | None = None, most: int = ROUNDS,
           discrepancy: Discrepancy | None = None, start: Callable[[RigModel], np.ndarray] = by_steps) -> list[Outcome]:
    """Diagnose; build in what is believed; diagnose again, until nothing more is; see `diagnose` for the arguments.

    Returns:
        outcomes in their order; of the last nothing was built in, unless it is number ``most`` + 1.
    """
    told = progress or (lambda share: None)
    out = [diagnose(model, lambda done: told(done / (most + 1)), discrepancy, start)]
    while out[-1].believed and len(out) <= most:
        begun = len(out)
        out.append(diagnose(out[-1].corrected(), lambda done, n=begun: told((n + done) / (most + 1)), discrepancy, start))
    told(1.0)
    return out


def found_by(outcomes: Sequence[Outcome]) -> list[str]:
    """Effects built in by rounds, in their order."""
    return [b.effect.id for b in outcomes[-1].model.built_in]


def _shrinks(model: RigModel, plain: Refitted, leader: Refitted) -> bool:
    """Whether residuals of held data surely shrink."""
    held = model.held_data()
    mask = held.mask()
    before, after = (held.run(f.theta, f.acting) for f in (plain, leader))
    return surely_smaller(*([_residuals(signals, run, mask) for signals, run in zip(held.signals(), runs, strict=True)]
                            for runs in (before, after)))


def _residuals(signals: Mapping, run: Mapping[str, np.ndarray], mask) -> dict[str, np.ndarray]:
    """By signal, in multiples of its noise."""
    return {name: ((signal.measured - run[name]) / signal.noise)[mask(signal)] for name, signal in signals.items() if mask(signal).any()}
