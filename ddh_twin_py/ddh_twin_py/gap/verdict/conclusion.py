"""From hypotheses that were fitted to a verdict: tolerances and held-out data are heard, and what is unknown is weighed and located."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
from ddh_twin_py.gap.verdict.unknown import UNLISTED, Unknown, drawn, unknown_beside
from ddh_twin_py.gap.verdict.unlisted_laws import UnlistedLaw, beside_law, best_unlisted, place_of, size_of
from ddh_twin_py.gap.verdict.verdict import (
    LIKELY,
    NEARLY,
    NO_HELP,
    Verdict,
    explains_a_signal,
    judge,
    less_believed,
    nothing_to_explain,
    something_acting,
)
from ddh_twin_py.gap.witnesses import Witnesses

_NO_NEARER = 0.99  # share of the gap of held-out data without any effect, from which a hypothesis does not help with it
_NO_NEARER_SAID = "the best listed hypothesis brings held-out data no nearer; it is less believed"
_FARTHER_OFF = "held-out data show nothing beyond the floor, and the best listed hypothesis brings them farther off; it is less believed"
_USUAL_RUNS = 100  # runs of held-out data that take half of the work
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


@dataclass(frozen=True)
class _Case:
    """What rules may ask of a case.

    Attributes:
        model: of the rig. plain: parameters without any hypothesis, (k,). runs: free runs of held-out data.
        drift: from the rig as commissioned, None where nothing showed that. hearing: of held-out data about any hypothesis.
        acts: how probable it is that the rig is not as it was commissioned. why: so.
    """

    model: Locatable
    plain: np.ndarray
    runs: HeldRuns
    drift: Drift | None
    hearing: Hearing
    acts: float
    why: str


@dataclass(frozen=True)
class _Standing:
    """How a case stands between two rules; see `Conclusion` for what it holds."""

    found: Found
    unknown: Unknown
    law: UnlistedLaw | None = None
    crossed: Exchanged | None = None

    @property
    def leader(self) -> Refitted:
        """The leading hypothesis, or no effect."""
        return _leading(self.found)


def _another_believed(case: _Case, standing: _Standing) -> _Standing:
    """Held-out data that speak against the leader may leave a rival of it more probable."""
    found, unknown = next_believed(standing.found, standing.unknown, case.hearing.of)
    return replace(standing, found=found, unknown=unknown)


def _law_unlisted(case: _Case, standing: _Standing) -> _Standing:
    """A law that no catalogue lists may explain more than the leader."""
    model, found, leader = case.model, standing.found, standing.leader
    law = best_unlisted(model, found, leader, case.runs.gap) if case.drift or leader.columns else None
    if law is None:
        return standing
    forms_of_none = unknown_beside(model, found, found.fitted[()])
    unknown = beside_law(standing.unknown, law, forms_of_none, leader.effects, size_of(model, law))
    return replace(standing, unknown=unknown, law=law if law.probability >= LIKELY else None)


def _sensors_exchanged(case: _Case, standing: _Standing) -> _Standing:
    """Two sensors may read each other's places."""
    crossed = exchanged(case.model, case.plain, standing.leader) if case.drift else None
    if crossed is None:
        return standing
    return replace(standing, crossed=crossed, unknown=standing.unknown.raised(PROBABILITY, crossed.said))


def _not_as_commissioned(case: _Case, standing: _Standing) -> _Standing:
    """No effect is less believed where the rig as commissioned would hardly show the recordings; who leads then is heard."""
    found, unknown = something_acting(standing.found, standing.unknown, case.acts, case.why)
    if found.leader != standing.leader.effects:
        unknown = case.hearing.of(_leading(found).effects).as_doubted_as(unknown)
    return replace(standing, found=found, unknown=unknown)


_RULES: Sequence[Callable[[_Case, _Standing], _Standing]] = (_another_believed, _law_unlisted, _sensors_exchanged, _not_as_commissioned)
"""In the order in which they act; each is given how the case stands and gives how it stands then."""


def conclude(model: Locatable, found: Found, plain: np.ndarray, runs: HeldRuns, as_run: Mapping[str, float],
             progress: Callable[[float], None] | None = None) -> Conclusion:
    """Conclude from what a search found: what is no effect, the rules, the verdict, its places.

    Args:
        plain: parameters of the rig without any hypothesis, (k,): as commissioned, or of no effect where nothing showed that.
        runs: free runs of held-out data. as_run: multiples of their noise by which signals of these are off with ``plain``.
        progress: told the share done; how many runs there will be is not known.
    """
    progress = progress or (lambda share: None)
    with_slight = found.fitted.get(found.leader)
    found = without_parameters(model, found)
    drift = None if all(model.altered) else Drift(found.linearised, plain)
    acts, why = _something_acts(model, found, runs, plain, drift) if drift else (0.0, "")
    found, notes = _without_help(found, runs, drift is not None) if acts < LIKELY else (found, [])
    leader = _leading(found).effects
    open_rig = HeldBest(runs.held, runs.floor, model.within, plain, found.linearised.basis.covariance(),
                        lambda ran: progress(ran / (ran + _USUAL_RUNS)))
    hearing = Hearing(model, found, runs, open_rig, plain, as_run, drift, {leader: with_slight})
    case, standing = _Case(model, plain, runs, drift, hearing, acts, why), _Standing(found, hearing.of(leader))
    for rule in _RULES:
        standing = rule(case, standing)
    verdict = _judged(case, standing)
    sought, unknown = standing.found, standing.unknown
    if verdict.word == "unknown":
        sought, unknown = _placed(case, standing)
    if verdict.word == "no_gap" and standing.leader.columns:  # they speak of a hypothesis that the answer does not name
        unknown = replace(unknown, notes=[])
    return Conclusion(standing.found, verdict, standing.leader, unknown, sought, standing.law, standing.crossed,
                      hearing.at_best[standing.leader.effects], notes)


def _leading(found: Found) -> Refitted:
    """The leading hypothesis as it was fitted, or no effect."""
    return found.fitted.get(found.leader) or found.fitted[()]


def _without_help(found: Found, runs: HeldRuns, built: bool) -> tuple[Found, list[str]]:
    """The same with a leader less believed, and a note on it, where it does not help with held-out data.

    Of a gap it must take something. Where there is none, a small effect takes hardly anything of it, and it is held against it only by how
    much it brings these data farther off. Its rivals, no less probable than `UNLISTED`, are each heard for themselves.

    Args:
        built: whether a recording showed the rig as built. Without one parameters take an effect up, and leave nothing beyond the floor.
    """
    leader, none = _leading(found), found.fitted[()]
    gap = runs.gap(none)
    if not leader.columns or (gap <= NEARLY and not built):
        return found, []

    def lost(fitted: Refitted) -> float:
        if gap <= NEARLY:
            return min(NO_HELP, max(0.0, -runs.speaks(fitted, none)))
        return NO_HELP if runs.gap(fitted) > _NO_NEARER * gap else 0.0

    if lost(leader) <= 0.0:
        return found, []
    rivals = [ids for ids, p in found.probability.items() if ids and p >= UNLISTED and ids in found.fitted]
    each = {ids: lost(found.fitted[ids]) for ids in dict.fromkeys([leader.effects, *rivals])}
    return less_believed(found, each), [_FARTHER_OFF if gap <= NEARLY else _NO_NEARER_SAID]


def _judged(case: _Case, standing: _Standing) -> Verdict:
    """The verdict on how a case stands after all rules."""
    found, unknown, leader = standing.found, standing.unknown, standing.leader
    if case.drift is not None:
        return judge(found, unknown)
    bests = case.hearing.at_best[leader.effects] if unknown.probability >= LIKELY else None
    return judge(found, unknown, _nothing_beyond(case.model.witnesses, case.runs, leader, found.fitted[()], bests))


def _placed(case: _Case, standing: _Standing) -> tuple[Found, Unknown]:
    """Hypotheses about which places of what is unknown were sought, and it with its places, its shape and a note on what is listed."""
    model, found, leader, law = case.model, standing.found, standing.leader, standing.law
    held = case.acts >= LIKELY and not leader.columns
    sought = replace(found, linearised=found.linearised.held_at(case.plain)) if held else found
    likely = model.free_places(sought, standing.unknown.forms, standing.unknown.off)
    if standing.crossed:
        likely = first_of_both(standing.crossed, likely)
    elif law:
        likely = place_of(law, likely)
    unknown = located(standing.unknown, sought.linearised, likely)
    unknown = drawn(model, found.linearised, found.fitted[()] if law else leader, unknown)
    named = [f"the best listed hypothesis is {' and '.join(leader.effects)}"] if leader.columns and not law else []
    return sought, replace(unknown, notes=[*unknown.notes, *named])


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
