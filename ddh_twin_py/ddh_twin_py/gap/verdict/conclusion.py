"""From hypotheses that were fitted to a verdict: tolerances and held-out data are heard, and what is unknown is weighed and located."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.gap.evidence.hypotheses import Ids
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.locate.locatable import Locatable
from ddh_twin_py.gap.shrink import size
from ddh_twin_py.gap.shrink.as_commissioned import UNSURPRISING, something_acts, surprises
from ddh_twin_py.gap.shrink.held_best import AtBest, HeldBest
from ddh_twin_py.gap.shrink.held_runs import HeldRuns
from ddh_twin_py.gap.verdict.drift import Drift
from ddh_twin_py.gap.verdict.exchanged import PROBABILITY, Exchanged, exchanged, first_of_both
from ddh_twin_py.gap.verdict.hearing import Hearing
from ddh_twin_py.gap.verdict.places import located
from ddh_twin_py.gap.verdict.rivals import next_believed
from ddh_twin_py.gap.verdict.tolerance import without_parameters
from ddh_twin_py.gap.verdict.unknown import Unknown, drawn, unknown_beside
from ddh_twin_py.gap.verdict.unlisted_laws import UnlistedLaw, beside_law, best_unlisted, place_of, size_of
from ddh_twin_py.gap.verdict.verdict import (
    LIKELY,
    NEARLY,
    Verdict,
    explains_a_signal,
    judge,
    less_believed,
    nothing_to_explain,
    something_acting,
)
from ddh_twin_py.gap.witnesses import Witnesses

_NO_NEARER = 0.99  # share of the gap of held-out data without any effect, from which a hypothesis does not help with it
_NO_HELP = "held-out data show nothing beyond the floor, and the best listed hypothesis brings them no nearer; it is less believed"
_HEARD, _USUAL_RUNS = 0.7, 100  # share of the work that is done once hypotheses were heard, and runs of held-out data that take half of it
_OUT_OF_THE_QUESTION = 1e-3  # probability of no effect, below which nothing more is asked of it


@dataclass(frozen=True)
class Conclusion:
    """What is concluded of a case.

    Attributes:
        found: hypotheses with the probabilities that are left to them. verdict: on them. best: the leading one, or no effect.
        unknown: beside it, with its places where something unknown is likely, and without notes where no hypothesis is named.
        sought: hypotheses about which these places were sought. law: that no catalogue lists and that explains more than any listed one;
            None where there is none. crossed: sensors that are likely exchanged, None where none are.
        at_best: held-out data at best, beside `best` and beside no effect.
        notes: why a hypothesis is less believed.
    """

    found: Found
    verdict: Verdict
    best: Refitted
    unknown: Unknown
    sought: Found
    law: UnlistedLaw | None
    crossed: Exchanged | None
    at_best: Mapping[Ids, AtBest]
    notes: list[str]


def conclude(model: Locatable, found: Found, plain: np.ndarray, runs: HeldRuns, as_run: Mapping[str, float],
             progress: Callable[[float], None] | None = None) -> Conclusion:
    """Conclude from what a search found.

    Args:
        plain: parameters of the rig without any hypothesis, (k,): as commissioned, or of no effect where nothing showed that.
        runs: free runs of held-out data. as_run: multiples of their noise by which signals of these are off with ``plain``.
        progress: told the share done; how many runs there will be is not known.
    """
    progress = progress or (lambda share: None)
    with_slight = found.fitted.get(found.leader)
    found = without_parameters(model, found)
    none = found.fitted[()]
    leader = found.fitted.get(found.leader) or none
    drift = None if all(model.altered) else Drift(found.linearised, plain)
    acts, why = _something_acts(model, found, runs, plain, drift) if drift else (0.0, "")
    no_help = runs.gap(none) <= NEARLY and runs.gap(leader) > _NO_NEARER * runs.gap(none)
    notes = []
    if leader.columns and drift and acts < LIKELY and no_help:
        found, notes = less_believed(found), [_NO_HELP]
        leader = leader if found.leader else none
    open_rig = HeldBest(runs.held, runs.floor, model.within, plain, found.linearised.basis.covariance(),
                        lambda ran: progress(_HEARD * ran / (ran + _USUAL_RUNS)))
    hearing = Hearing(model, found, runs, open_rig, plain, as_run, drift, {leader.effects: with_slight})
    found, unknown = next_believed(found, hearing.of(leader.effects), hearing.of)
    leader = found.fitted.get(found.leader) or none
    progress(_HEARD)
    law = best_unlisted(model, found, leader, runs.gap) if drift or leader.columns else None
    if law is not None:
        unknown = beside_law(unknown, law, unknown_beside(model, found, none), leader.effects, size_of(model, law))
        law = law if law.probability >= LIKELY else None
    crossed = exchanged(model, plain, leader) if drift else None
    if crossed is not None:
        unknown = unknown.raised(PROBABILITY, crossed.said)
    found, unknown = something_acting(found, unknown, acts, why)
    if found.leader != leader.effects:  # it leads once no effect is less believed, and was not heard yet
        leader = found.fitted.get(found.leader) or none
        unknown = hearing.of(leader.effects).as_doubted_as(unknown)
    at_best, sought = hearing.at_best[leader.effects], found
    bests = at_best if unknown.probability >= LIKELY else None
    beyond = drift is not None or not _nothing_beyond(model.witnesses, runs, leader, none, bests)
    verdict = judge(found, unknown, not beyond)
    if verdict.word == "unknown":
        if acts >= LIKELY and not leader.columns:
            sought = replace(found, linearised=found.linearised.held_at(plain))
        likely = model.free_places(sought, unknown.forms, unknown.off)
        likely = first_of_both(crossed, likely) if crossed else place_of(law, likely) if law else likely
        unknown = located(unknown, sought.linearised, likely)
        unknown = drawn(model, found.linearised, none if law else leader, unknown)
        named = [f"the best listed hypothesis is {' and '.join(leader.effects)}"] if leader.columns and not law else []
        unknown = replace(unknown, notes=[*unknown.notes, *named])
    if verdict.word == "no_gap" and leader.columns:  # they speak of a hypothesis that the answer does not name
        unknown = replace(unknown, notes=[])
    return Conclusion(found, verdict, leader, unknown, sought, law, crossed, at_best, notes)


def _nothing_beyond(witnesses: Witnesses, runs: HeldRuns, leader: Refitted, none: Refitted,
                    bests: Mapping[Ids, AtBest] | None) -> bool:
    """Whether, without commissioning, held-out data show nothing that is to be explained.

    Args:
        bests: these data at best, beside the leader and beside no effect, where something unknown is likely: what nobody listed is asked
            for only where no rig within tolerance does as well. None elsewhere.
    """
    if explains_a_signal(runs.over(none), runs.over(leader)):
        return False
    gaps = [(runs.gap(none), runs.gap(leader))]
    gaps.append(tuple(size.of_all(witnesses.but_summing(runs.over(one))) for one in (none, leader)))
    if bests is not None:
        gaps.append((bests[()].gap, bests[leader.effects].gap))
    relieved = 0.5 * float(none.theta @ none.theta - leader.theta @ leader.theta) / max(1, len(leader.columns))
    return nothing_to_explain(gaps, leader.log_evidence - none.log_evidence, relieved)


def _something_acts(model: Locatable, found: Found, runs: HeldRuns, plain: np.ndarray, drift: Drift) -> tuple[float, str]:
    """How probable it is that the rig is not as it was commissioned, and why; not asked where no effect is out of the question anyway.

    Args:
        plain: parameters of the rig as commissioned, (k,). drift: from it.
    """
    if found.probability.get((), 0.0) < _OUT_OF_THE_QUESTION or not model.followed:
        return 0.0, ""
    elsewhere = runs.held if "validation" in model.recordings else None
    off = surprises(model, elsewhere, runs.floor, plain, drift.open, UNSURPRISING)
    return something_acts([one for one in off if one.signal in model.followed], elsewhere is None)
