"""Laws that no catalogue lists, held against the best listed hypothesis once a search is over.

Two listed effects can do together what one law does that nobody listed: a pump whose suction starves looks worn, with a stiff hose, and
leaves nothing behind in either duty. One law that explains as much is the likelier, and the answer is then that the cause is not listed,
with a place and a form. A temperature sensor whose zero has moved warms every node that begins as its neighbour, and looks like an oil
or a tank. Each law is asked by itself and never beside listed effects, so that it takes nothing from these.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.evidence.hypotheses import log_prior, weigh
from ddh_twin_py.gap.evidence.sensitivity import Column, columns_of, stacked
from ddh_twin_py.gap.explain.departure import departure_of
from ddh_twin_py.gap.explain.fits import TEMPERED
from ddh_twin_py.gap.explain.refit import Refit, Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.explain.side_by_side import THREADS
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.model import DescribedModel
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.verdict import LIKELY
from ddh_twin_py.rig.reader_units import plus_minus

PRIOR = 0.005
"""Prior probability of each such law: a third of a listed effect's."""
_WORTH, _SHARE = 5.0, 0.2  # log evidence by the linear model, and share of the leader's, from which a law is fitted; a large one bends
_FITTED = 2  # laws fitted in full
_WIDER = 1.1  # times the leader's gap of held-out data from which these speak against a law


@dataclass(frozen=True)
class UnlistedLaw:
    """A law at its optimum: how probable it is instead of the listed hypotheses, and by how much log evidence it leads them."""

    fitted: Refitted
    probability: float
    ahead: float

    @property
    def effect(self) -> Effect:
        """The law."""
        return self.fitted.columns[0].effect


def best_unlisted(model: DescribedModel, found: Found, leader: Refitted, gap: Callable[[Refitted], float]) -> UnlistedLaw | None:
    """The law that explains the recordings best of those that held-out data let stand, None where none comes near the leading hypothesis.

    Args:
        leader: that hypothesis, or no effect. gap: of held-out data under a fit.
    """
    own, none = found.linearised, found.fitted[()]
    laws = model.unlisted_laws()
    if not laws:
        return None
    least = max(_WORTH, _SHARE * (leader.log_evidence - none.log_evidence))
    with ThreadPoolExecutor(max_workers=THREADS) as pool:
        promising = _promising(found, columns_of(laws, model, own.theta, own.comparisons, pool), least)
        refit = Refit(own)
        starts = [(column, theta, departure) for column, departure in promising for theta in (none.theta, leader.theta)]
        fits = list(pool.map(lambda start: refit.of([start[0]], start[1], np.array([start[2]])), starts))

    def stands(law: Refitted) -> bool:
        return bool(np.isfinite(law.log_evidence)) and not law.slight and not gap(law) > _WIDER * max(gap(leader), 1.0)

    best = next(filter(stands, sorted(fits, key=lambda fitted: -fitted.log_evidence)), None)
    if best is None:
        return None
    ahead = best.log_evidence - leader.log_evidence
    odds = ahead / TEMPERED + math.log(PRIOR) - log_prior(leader.effects, len(own.question.effects))
    weight = found.probability.get(leader.effects, 0.0) * math.exp(min(odds, 700.0))
    return UnlistedLaw(best, weight / (1.0 + weight), ahead)


def _promising(found: Found, columns: Sequence[Column], least: float) -> list[tuple[Column, float]]:
    """Ways of laws by which the linear model gains so much at least, each with its departure in multiples of it; the best first."""
    own = found.linearised
    if not columns:
        return []
    changes = stacked(columns, own.comparisons)
    sums = own.basis.sums(changes, own.values())
    told = []
    for i, column in enumerate(columns):
        log, estimate, _ = weigh(sums.information[i : i + 1, i : i + 1], sums.score[i : i + 1], np.array([column.room]),
                                 own.question.widths)
        told.append((log, column, max(0.5, float(estimate[0]))))
    told.sort(key=lambda one: -one[0])
    return [(column, departure) for log, column, departure in told[:_FITTED] if log > least]


def beside_law(unknown: Unknown, law: UnlistedLaw, forms_of_none: Unknown, instead_of: Sequence[str], described: str) -> Unknown:
    """What is unknown where a law competes; it takes the shape of what no effect leaves where the law is as likely as not.

    Args:
        unknown: beside the listed hypotheses. forms_of_none: beside no effect. instead_of: the leading listed hypothesis.
        described: the law's size in words.
    """
    whole = 1.0 - (1.0 - unknown.probability) * (1.0 - law.probability)
    if law.probability < LIKELY:
        return replace(unknown, probability=max(unknown.probability, whole))
    better = f"better than {' and '.join(instead_of)}" if instead_of else "well"
    happens = law.effect.happens(float(law.fitted.x[0])).rstrip(".")
    note = f"a law that no catalogue lists explains the recordings {better}: {happens} ({described})"
    shape = replace(unknown, forms=forms_of_none.forms, size=forms_of_none.size, unit=forms_of_none.unit)
    return shape.raised(max(whole, unknown.probability), note)


def size_of(model: DescribedModel, law: UnlistedLaw) -> str:
    """A law's parameter and its value in words."""
    value, std, unit, _ = departure_of(model, law.fitted, 0)
    return f"{law.effect.parameter.replace('_', ' ')} {plus_minus(value, std, unit)}"


def place_of(law: UnlistedLaw, others: Sequence[FreePlace]) -> list[FreePlace]:
    """The law's place first, as probable as it is, then the others."""
    column, x = law.fitted.columns[0], float(law.fitted.x[0])
    std = float(np.sqrt(max(law.fitted.covariance[0, 0], 0.0)))
    own = FreePlace(law.effect.component, law.effect.domain, law.fitted.log_evidence, law.probability, column, x / column.x, std / abs(x),
                    law.effect.reading)
    rest = [place for place in others if place.component != own.component]
    whole = sum(place.share for place in rest) or 1.0
    return [own, *(replace(place, share=(1.0 - law.probability) * place.share / whole) for place in rest)]
