"""A described rig diagnosed, and diagnosed again with what was found built in."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.comparison import Discrepancy
from ddh_twin_py.gap import answer
from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.gap.hypotheses import POWER_WITHOUT_COMMISSIONING, SLACK
from ddh_twin_py.gap.linearised import linearise
from ddh_twin_py.gap.refit import Refit, Refitted
from ddh_twin_py.gap.search import Found, search
from ddh_twin_py.gap.suitability import unseen
from ddh_twin_py.real_rigs.rig_model import RigModel

ROUNDS = 3
"""Diagnoses of one rig, each with what was found before it built in."""
_THREADS = 2
_PLACES = 12  # from which a fit is linearised again
_SETTLED = 0.02  # of chi-square that a further place must gain, per row at least 1e-5


@dataclass(frozen=True)
class Outcome:
    """What a diagnosis of a model found.

    Attributes:
        model: that was diagnosed. diagnosis: the whole answer. found: what the search left.
        plain: the model fitted without effects. leader: with the effects that are believed; ``plain`` where there are none.
    """

    model: RigModel
    diagnosis: Diagnosis
    found: Found
    plain: Refitted
    leader: Refitted

    @property
    def verdict(self) -> str:
        """Word of the contract."""
        return self.diagnosis.report["verdict"]

    @property
    def believed(self) -> tuple[str, ...]:
        """Effects that explain the gap; () where the verdict is another."""
        return self.leader.effects if self.verdict == "explained" else ()

    def corrected(self) -> RigModel:
        """The model with the believed effects built in."""
        spread = np.sqrt(np.diagonal(self.leader.covariance))
        return self.model.with_effects(self.leader.theta, self.leader.acting, spread)


def fit(model: RigModel, pool: ThreadPoolExecutor, theta: np.ndarray | None = None, discrepancy: Discrepancy | None = None) -> Refitted:
    """The model's parameters where the recordings and their priors put them, no effect acting.

    Args:
        theta: where to begin, deviations, (k,). discrepancy: what the model is forgiven.
    """
    theta = np.zeros(model.size) if theta is None else theta
    fitted, best = None, np.inf
    for _ in range(_PLACES):
        place = linearise(model, (), theta, discrepancy or Discrepancy(), SLACK, POWER_WITHOUT_COMMISSIONING, pool)
        here = Refit(model, place.comparisons, place.basis, place.sensitivities, theta).of([], place.shared(None), np.zeros(0))
        cost = here.chi_square + float(here.theta @ here.theta)
        if fitted is not None and not cost < best - max(_SETTLED, 1e-5 * best):
            return here if cost < best else fitted
        fitted, best, theta = here, cost, here.theta
    return fitted


def diagnose(model: RigModel, progress: Callable[[float], None] | None = None, discrepancy: Discrepancy | None = None) -> Outcome:
    """Fit, search, answer.

    Args:
        progress: told the share done. discrepancy: what the model is forgiven; the engine's own where None.
    """
    told = progress or (lambda share: None)
    started = time.perf_counter()
    seconds: dict[str, float] = {}
    with ThreadPoolExecutor(max_workers=_THREADS) as pool:
        begun = fit(model, pool, discrepancy=discrepancy)
        seconds["fit of the rig"] = time.perf_counter() - started
        told(0.3)
        found = search(model, model.effects, begun.theta, discrepancy or Discrepancy(), POWER_WITHOUT_COMMISSIONING, pool,
                       lambda done: told(0.3 + 0.6 * done))
        seconds["search"] = time.perf_counter() - started - sum(seconds.values())
        result = answer.diagnosis(model, found, begun.theta, seconds)
    seconds["answer"] = time.perf_counter() - started - sum(seconds.values())
    report = {**result.report, "notes": [*result.report["notes"], *unseen(model.effects, found.linearised.columns)]}
    plain = found.fitted[()]
    word = report["verdict"]
    leading = tuple(report["hypotheses"][0]["effects"]) if word == "explained" else ()
    told(1.0)
    return Outcome(model, replace(result, report=report, seconds=seconds), found, plain, found.fitted.get(leading, plain))


def rounds(model: RigModel, progress: Callable[[float], None] | None = None, most: int = ROUNDS,
           discrepancy: Discrepancy | None = None) -> list[Outcome]:
    """Diagnose; build in what explains the gap; diagnose again, until nothing explains it or held-out data do not shrink.

    Returns:
        outcomes in their order; the last is the one after which nothing more was built in.
    """
    told = progress or (lambda share: None)
    out: list[Outcome] = []
    for number in range(most):
        out.append(diagnose(model, lambda done, n=number: told((n + done) / most), discrepancy))
        gap = out[-1].diagnosis.report["gap"]
        if not out[-1].believed or not gap["after"] < gap["before"]:
            break
        model = out[-1].corrected()
    told(1.0)
    return out


def corrected_by(outcomes: Sequence[Outcome]) -> RigModel:
    """The model with all that rounds found built in; the last round counts where it was explained and shrank held-out data."""
    last = outcomes[-1]
    gap = last.diagnosis.report["gap"]
    return last.corrected() if last.believed and gap["after"] < gap["before"] else last.model
