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
        gained = [self._freed(one, own, fitted) for one, own in asked.items()]
        ahead = max(full[one] + own[one] for one, own in zip(asked, gained, strict=True)) - full[best]
        return {ids: max(0.0, ahead - own[ids]) for one, own in zip(asked, gained, strict=True) for ids in asked[one]}

    def _square(self, ids: Ids, fitted: Mapping[Ids, Refitted]) -> float:
        """The share by which a law is off, squared, of what an effect of a pair explains by itself, the larger of the two."""
        none = fitted[()].log_evidence
        own = [self._law_error[name] ** 2 * (fitted[(name,)].log_evidence - none) for name in ids if (name,) in fitted]
        return max([0.0, *own])

    def _freed(self, one: Ids, pairs: Sequence[Ids], fitted: Mapping[Ids, Refitted]) -> dict[Ids, float]:
        """Log evidence that a single effect, and pairs of which it is the first, gain where its law is free."""
        first, asked = fitted[one], []
        for ids in (one, *pairs):
            known = self._by_freedom.get((one, ids))
            if known is None or known[0] is not first or known[1] is not fitted[ids]:
                asked.append(ids)
        if asked:
            freedom = LawFreedom(self._linearised, first, {one[0]: self._law_error[one[0]]})
            fits = [fitted[ids] for ids in asked]
            for ids, fit, log in zip(asked, fits, self._pool.map(freedom.log_evidence, fits), strict=True):
                self._by_freedom[one, ids] = first, fit, log - fit.log_evidence
        return {ids: self._by_freedom[one, ids][2] for ids in (one, *pairs)}
