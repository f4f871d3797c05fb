"""What a pair of effects may owe to the law of its first effect, which is off: a second one then mends what the law gets wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

from ddh_twin_py.gap.evidence.hypotheses import Ids
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.law_freedom import LawFreedom
from ddh_twin_py.gap.explain.refit import Refitted

_SLIGHT = 1.0  # log evidence that is not worth asking for in full


class LawDebt:
    """Log weight that pairs may owe, asked in full of a few and bounded for all others.

    Args:
        linearised: gives the law errors of effects, and what a free law does to the signals.
    """

    def __init__(self, linearised: Linearised, pool: ThreadPoolExecutor) -> None:
        self._linearised, self._pool = linearised, pool
        self._law_error = {column.effect.id: column.effect.law_error for column in linearised.columns}
        self._by_freedom: dict[tuple[Ids, Ids], tuple[Refitted, Refitted, float]] = {}
        self._least = 0.0

    def at_most(self, ids: Ids, fitted: Mapping[Ids, Refitted]) -> float:
        """That of a set that was not asked in full: the square of the law's share of what its first effect explains by itself.

        It is no less than what pairs lose of which it was asked in full.
        """
        return max(self._square(ids, fitted), self._least) if len(ids) > 1 else 0.0

    def in_full(self, pairs: Sequence[Ids], fitted: Mapping[Ids, Refitted], full: Mapping[Ids, float]) -> dict[Ids, float]:
        """That of pairs that were fitted.

        With the law of its first effect free, a pair must be ahead of the best single effect with its law free as far as it is to count
        as ahead of the best single effect. So two pairs are held against each other as they are with free laws, not by how badly the
        first effect of each does alone.

        Args:
            fitted: all sets that were. full: their log weights, of those that are weighed.
        """
        owed = self._asked(pairs, fitted, full)
        self._least = min(owed.values(), default=0.0)
        return owed

    def _asked(self, pairs: Sequence[Ids], fitted: Mapping[Ids, Refitted], full: Mapping[Ids, float]) -> dict[Ids, float]:
        squares = {ids: self._square(ids, fitted) for ids in pairs}
        if not any(square >= _SLIGHT for square in squares.values()):
            return squares
        best = max((ids for ids in full if len(ids) == 1), key=full.__getitem__)
        asked: dict[Ids, list[Ids]] = {best: []}
        for ids in pairs:
            ones = ((name,) for name in ids if (name,) in fitted)
            asked.setdefault(max(ones, key=lambda one: fitted[one].log_evidence, default=best), []).append(ids)
        gained = self._freed(asked, fitted)
        ahead = max(full[one] + gained[one, one] for one in asked) - full[best]
        return {ids: max(0.0, ahead - gained[one, ids]) for one, own in asked.items() for ids in own}

    def _square(self, ids: Ids, fitted: Mapping[Ids, Refitted]) -> float:
        """The share by which a law is off, squared, of what an effect of a pair explains by itself, the larger of the two."""
        none = fitted[()].log_evidence
        own = [self._law_error[name] ** 2 * (fitted[(name,)].log_evidence - none) for name in ids if (name,) in fitted]
        return max([0.0, *own])

    def _freed(self, asked: Mapping[Ids, Sequence[Ids]], fitted: Mapping[Ids, Refitted]) -> dict[tuple[Ids, Ids], float]:
        """Log evidence that single effects, and pairs of which each is the first, gain where its law is free, by both."""
        pairs = [(one, ids) for one, own in asked.items() for ids in (one, *own)]
        wanted = []
        for one, ids in pairs:
            known = self._by_freedom.get((one, ids))
            if known is None or known[0] is not fitted[one] or known[1] is not fitted[ids]:
                wanted.append((one, ids))
        ones = list(dict.fromkeys(one for one, _ in wanted))
        freedom = dict(zip(ones, self._pool.map(lambda one: self._freedom(fitted[one], one[0]), ones), strict=True))
        logs = self._pool.map(lambda pair: freedom[pair[0]].log_evidence(fitted[pair[1]]), wanted)
        for (one, ids), log in zip(wanted, logs, strict=True):
            self._by_freedom[one, ids] = fitted[one], fitted[ids], log - fitted[ids].log_evidence
        return {pair: self._by_freedom[pair][2] for pair in pairs}

    def _freedom(self, fitted: Refitted, name: str) -> LawFreedom:
        return LawFreedom(self._linearised, fitted, {name: self._law_error[name]})
