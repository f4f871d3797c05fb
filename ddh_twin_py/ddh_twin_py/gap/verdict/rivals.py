"""What the field recording nearly holds for as good as the leader, where held-out data speak against the leader."""

from __future__ import annotations

from collections.abc import Callable

from ddh_twin_py.gap.evidence.hypotheses import Ids
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.verdict.unknown import UNLISTED, Unknown
from ddh_twin_py.gap.verdict.verdict import LIKELY

_MOST = 2  # rivals that are heard


def rivals_of(found: Found) -> list[Ids]:
    """Sets of effects beside the leader that were fitted and are not less probable than something unlisted, most probable first."""
    others = [ids for ids, p in found.probability.items() if ids and ids != found.leader and ids in found.fitted and p >= UNLISTED]
    return others[:_MOST]


def next_believed(found: Found, unknown: Unknown, hear: Callable[[Ids], Unknown]) -> tuple[Found, Unknown]:
    """The same, led by a rival of the leader that held-out data leave more probable than the leader and than something unknown.

    How probable something unknown is beside a hypothesis says by how much held-out data speak against that one: Bayes' factor is
    (1 - u) / u over what it is where they say nothing, u = `UNLISTED`. What was not heard is not believed more than the leader.

    Args:
        unknown: beside the leader. hear: the same beside a rival.
    """
    if unknown.probability < LIKELY or not found.leader:
        return found, unknown
    heard = {found.leader: unknown} | {ids: hear(ids) for ids in rivals_of(found)}
    speak = {ids: _factor(one.probability) for ids, one in heard.items()}
    weights = {ids: p * speak.get(ids, speak[found.leader]) for ids, p in found.probability.items()}
    best = max(weights, key=weights.get)
    doubt = UNLISTED / (UNLISTED + sum(weights.values()))
    if best == found.leader or best not in heard or max(doubt, heard[best].probability) >= LIKELY:
        return found, unknown
    note = (f"held-out data speak against {' and '.join(found.leader)}, which explains the field recording best; not against "
            f"{' and '.join(best)}, which explains it nearly as well")
    return found.reweighed(weights), heard[best].raised(doubt, note)


def _factor(unknown: float) -> float:
    return min(1.0, (1.0 - unknown) / max(unknown, 1e-12) * UNLISTED / (1.0 - UNLISTED))
