"""What held-out data say against a hypothesis that the field recordings speak for."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping

import numpy as np

from ddh_twin_py.gap.evidence.hypotheses import Ids
from ddh_twin_py.gap.explain.law_freedom import gain_of_freedom
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.locate.locatable import Locatable
from ddh_twin_py.gap.shrink import size
from ddh_twin_py.gap.shrink.bin_means import beyond_noise
from ddh_twin_py.gap.shrink.held_best import AtBest, HeldBest
from ddh_twin_py.gap.shrink.held_runs import HeldRuns, first_of_each, in_fitted
from ddh_twin_py.gap.verdict.drift import Drift
from ddh_twin_py.gap.verdict.held_out_rules import (
    FAR,
    FREEDOM,
    REFUTED,
    REFUTED_AS_RUN,
    RESIZE,
    bent,
    borne_out,
    displaced,
    drifted,
    far_off,
    halfway,
    left_behind,
    off_its_noise,
    refuted,
    resized,
    strained,
    worsened,
)
from ddh_twin_py.gap.verdict.one_witness import doubted_alone
from ddh_twin_py.gap.verdict.outdone import outdone
from ddh_twin_py.gap.verdict.two_effects import doubted, leans, proportioned
from ddh_twin_py.gap.verdict.unknown import Unknown, needed_of, unknown_beside

_SUSPECT = 2.0  # floors that a signal is off beside a hypothesis, from which all is looked at closely before it is doubted


class Hearing:
    """Held-out data, as they are heard about one hypothesis after the other.

    Args:
        found: hypotheses that were fitted. runs: free runs of the data. best: the data with what is open of the rig at its best.
        plain: parameters of the rig as it is known without these hypotheses, (k,). as_run: multiples of their noise by which signals are
            off with them. drift: from the rig as commissioned, None where nothing showed that.
        slight: hypotheses with what is too slight to be an effect, by what is left of them.
    """

    def __init__(self, model: Locatable, found: Found, runs: HeldRuns, best: HeldBest, plain: np.ndarray, as_run: Mapping[str, float],
                 drift: Drift | None, slight: Mapping[Ids, Refitted | None]) -> None:
        self._model, self._found, self._runs, self._best = model, found, runs, best
        self._as_run = {name: ratio / runs.floor[name] for name, ratio in as_run.items()}
        self._gap_as_run = size.of_all(self._as_run)
        self._drift, self._slight = drift, slight
        self._before = functools.cache(lambda closely: best.beside(plain, (), closely))
        self._best_place = functools.cache(lambda: model.best_place(found.linearised))
        self._beside_none = functools.cache(lambda closely: best.beside(found.fitted[()].theta, (), closely))
        self.at_best: dict[Ids, dict[Ids, AtBest]] = {}
        """By hypothesis heard: held-out data at best beside it, and beside no effect."""

    def of(self, ids: Ids) -> Unknown:
        """What is unknown beside a hypothesis."""
        leader, none, linearised = self._found.fitted[ids], self._found.fitted[()], self._found.linearised
        unknown = self._weighed(unknown_beside(self._model, self._found, leader), leader)
        place = self._best_place() if leader.columns and self._drift is not None else None
        if place is not None:
            unknown = outdone(unknown, place, linearised, leader, none)
        if len(leader.columns) != 1:
            return doubted(unknown, linearised, leader)
        with_slight = self._slight.get(ids)
        if with_slight is not None and leans(leader, with_slight, none):  # too slight to be one, and needed all the same
            unknown = doubted(unknown, linearised, with_slight)
        return doubted_alone(unknown, linearised, leader)

    def _weighed(self, unknown: Unknown, leader: Refitted) -> Unknown:
        """What is unknown beside a hypothesis, once held-out data had their say."""
        best, found, runs, drift, witnesses = self._best, self._found, self._runs, self._drift, self._model.witnesses
        floor, none = runs.floor, found.fitted[()]
        unsteady = spread_of_unsteady(leader)
        beside = best.beside(leader.theta, leader.acting, spread=unsteady)
        closely = max(beside.over.values(), default=0.0) > _SUSPECT
        beside = best.beside(leader.theta, leader.acting, closely, unsteady) if closely else beside
        before = self._before(closely)
        beside_none = self._beside_none(closely) if leader.columns else beside
        self.at_best[leader.effects] = {(): beside_none, leader.effects: beside}
        over, shrunk = beside.over, beside.gap
        closed = size.closed(before.gap, shrunk)
        first, built = first_of_each(runs.held), drift is not None
        there = in_fitted(self._model, leader, floor, acts=True)
        unknown = borne_out(unknown, witnesses, lambda signal: needed_of(self._model, signal, leader), runs.over(leader), over, closed,
                            len(leader.columns), built, there)
        if built:
            as_built = witnesses.prompt(in_fitted(self._model, leader, floor, acts=False))
            unknown = strained(unknown, as_built, len(leader.columns))
            unknown = off_its_noise(unknown, beyond_noise(self._model, leader), len(leader.columns))
        followed = {name: over[name] for name in self._model.followed if name in over}
        if built and followed:
            unknown = drifted(unknown, drift.of(leader), len(leader.columns), self._gap_as_run, shrunk)
            unknown = far_off(unknown, over, closed, len(leader.columns))
        if not leader.columns:
            return unknown
        sizes = {n: (floor[n] * first[n].noise, first[n].unit) for n in followed}
        unknown = left_behind(unknown, followed, {n: self._as_run[n] for n in followed}, sizes, built, there)
        if built:  # without a commissioning recording any other duty may ask for other parameters
            unknown = worsened(unknown, witnesses, over, before.over)
        by_bending = gain_of_freedom(found.linearised, leader, FREEDOM)
        unknown = bent(unknown, by_bending, leader.log_evidence - none.log_evidence, len(leader.columns))
        if built:
            unknown = self._elsewhere(unknown, leader, closely)
        if len(leader.columns) > 1:
            unknown = halfway(unknown, shrunk, closed, max(witnesses.slow(over).values(), default=0.0))
        ways = [(beside_none.over, over, REFUTED)]
        if built:
            ways.append((self._as_run, runs.over(leader), REFUTED_AS_RUN))
        return refuted(unknown, witnesses, ways)

    def _elsewhere(self, unknown: Unknown, leader: Refitted, closely: bool) -> Unknown:
        """The same once it is asked whether held-out data want another rig, or other sizes of the effects, than the fitted recordings."""
        def best(free, least):
            return self._best.beside(leader.theta, leader.acting, closely, free, least)

        unsteady = spread_of_unsteady(leader)
        unknown = displaced(unknown, best(unsteady, dict.fromkeys(self._model.witnesses.summing, math.inf)).displaced)
        least = dict.fromkeys(self._model.witnesses.summing, FAR)  # they sum up what another duty lets a law be off by
        spread = spread_elsewhere(leader)
        kept, other = best(unsteady, least), best(spread + unsteady, least)
        asked = [i for i, column in enumerate(leader.columns) if leader.x[i] and not column.effect.unsteady]
        times = {leader.columns[i].effect.id: float(other.departures[i] / leader.x[i]) for i in asked}
        shares = {leader.columns[i].effect.id: float(spread[i] / abs(leader.x[i])) for i in asked}
        return resized(unknown, kept.cost(least) - other.cost(least), times, shares, proportioned(self._found.linearised, leader))


def spread_elsewhere(fitted: Refitted) -> np.ndarray:
    """Standard deviations by which a hypothesis' departures may be others in another duty, (m,)."""
    laws = np.array([RESIZE * c.effect.law_error for c in fitted.columns]) * fitted.x
    asked = np.array([not c.effect.unsteady for c in fitted.columns], bool)
    return asked * np.sqrt(np.maximum(np.diagonal(fitted.covariance), 0.0) + laws**2)


def spread_of_unsteady(fitted: Refitted) -> np.ndarray:
    """Standard deviations of the departures that have another size in every duty, 0 of the others, (m,)."""
    return np.array([c.effect.unsteady for c in fitted.columns]) * np.abs(fitted.x)
