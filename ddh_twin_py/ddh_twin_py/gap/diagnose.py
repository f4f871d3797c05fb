"""A diagnosis from recordings to report: fit the rig, search its gap, size it on data that took no part."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Discrepancy, sized
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.estimation.fitting.problem import RESTARTS, Problem
from ddh_twin_py.gap import answer
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.gap.drive.case import DriveCase
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.search import Otherwise, search
from ddh_twin_py.gap.explain.side_by_side import THREADS
from ddh_twin_py.gap.recordings.carried_load import undeclared_loads
from ddh_twin_py.gap.recordings.contradictions import contradictions
from ddh_twin_py.gap.recordings.doubts import at_the_stops, damage, doubts, left_out, of_reference, pauses, undeclared
from ddh_twin_py.gap.recordings.suitability import no_answer, no_twice, one_clock, one_rig, out_of_order, refuse_unfit, unseen
from ddh_twin_py.gap.verdict.unknown import structure_left
from ddh_twin_py.gap.words import careful
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.payload import PAYLOAD
from ddh_twin_py.telemetry.recording import Recording

HELD_SHARE = 0.25
"""Last share of a field recording that takes no part where there is no validation recording."""
_FITTED, _SEARCHED = 0.1, 0.75
"""Shares of the work that are done when the rig is fitted, and when the hypotheses are weighed; in three cases 0.06 to 0.19 and 0.57
to 0.84 of the time."""
_SWEEPS, _SWEEPS_OF_SHEET = 5, 3  # of the first fit, with and without commissioning; the search goes on from there


@dataclass(frozen=True)
class Recordings:
    """Recordings of one rig: in question, as built, and on another duty; the latter two may be missing."""

    field: Sequence[Recording]
    commissioning: Recording | None = None
    validation: Recording | None = None

    def held_against(self, oil_grade: str) -> Recordings:
        """See `Recording.held_against`."""
        one, other = (r if r is None else r.held_against(oil_grade) for r in (self.commissioning, self.validation))
        return Recordings([r.held_against(oil_grade) for r in self.field], one, other)


def stage_of(done: float) -> str:
    """What a diagnosis does when that share of it, 0 to 1, is done."""
    return "fitting the rig" if done < _FITTED else "weighing effects" if done < _SEARCHED else "sizing the gap" if done < 1.0 else "done"


def diagnose(recordings: Recordings, rig: Rig, without: Collection[str] = (), only: Collection[str] | None = None,
             progress: Callable[[float], None] | None = None) -> Diagnosis:
    """Diagnose one case.

    Args:
        recordings: of one rig. rig: its sheet; values and tolerances are the prior.
        without: effects that are not asked about. only: ask about these alone; None asks about all.
        progress: told the share done.

    Raises:
        ExperimentError: a recording that no free run can be compared with, one of several clocks, or recordings of several rigs.
    """
    started = time.perf_counter()
    seconds: dict[str, float] = {}

    def lap(name: str) -> None:
        seconds[name] = time.perf_counter() - started - sum(seconds.values())

    told = progress or (lambda share: None)
    recordings = recordings.held_against(rig.oil_grade)
    given = [r for r in (recordings.commissioning, *recordings.field, recordings.validation) if r is not None]
    one_rig(given)
    one_clock(given)
    share = 1.0 if recordings.validation is not None else 1.0 - HELD_SHARE
    field = [Experiment(recording, rig, used=share) for recording in recordings.field]
    commissioning = [] if recordings.commissioning is None else [Experiment(recordings.commissioning, rig)]
    held = [] if recordings.validation is None else [Experiment(recordings.validation, rig)]
    for experiment, role in [*((e, "commissioning") for e in commissioning), *((e, "validation") for e in held)]:
        refuse_unfit(experiment, role)
    no_twice(given)
    reason = no_answer(field, bool(held))
    model = DriveCase(commissioning, field, rig, held)
    lap("reading")
    effects = [effect for name, effect in EFFECTS.items() if name not in without and (only is None or name in only)]
    read = [e.recording for e in (*field, *commissioning, *held)]
    if reason:
        return _noted(answer.insufficient(model, reason), read, rig, another=model.of_another)
    with ThreadPoolExecutor(max_workers=THREADS) as pool:
        problem = Problem(commissioning or field, model.rig, model.paths, Discrepancy())
        fit = problem.fit(pool, lambda done: told(_FITTED * done), sweeps=_SWEEPS if commissioning else _SWEEPS_OF_SHEET,
                          restarts=RESTARTS if commissioning else 0)
        discrepancy = sized(problem.discrepancy, fit.allowances) if commissioning else Discrepancy()
        fitted = model.of_first(fit.theta)
        sheet = None if commissioning else Otherwise(np.zeros(model.size), functools.partial(structure_left, model))
        lap("fit of the rig")
        question = Question(model, effects, discrepancy)
        found = search(question, fitted, pool, lambda done: told(_FITTED + (_SEARCHED - _FITTED) * done), sheet)
        lap("search")
        result = answer.diagnosis(model, found, fitted, unseen(effects, found.linearised.columns), seconds,
                                  lambda done: told(_SEARCHED + (1.0 - _SEARCHED) * done))
    lap("answer")
    told(1.0)
    late = out_of_order(recordings.field, recordings.commissioning)
    omitted = left_out([*field, *commissioning, *held])
    loads = undeclared_loads(*([e.recording for e in own] for own in (field, commissioning, held)), rig)
    return _noted(replace(result, seconds=seconds), read, rig, [*loads, *late], model.missing(), omitted, model.of_another)


def _noted(result: Diagnosis, recordings: Sequence[Recording], rig: Rig, late: Sequence[str] = (),
           missing: Sequence[str] = (), omitted: Sequence[str] = (), another: Sequence[str] = ()) -> Diagnosis:
    """A diagnosis that says what is wrong with its recordings: what is damaged or contradicts itself at once, what is doubtful last.

    Args:
        late: what does not go together: their order, their loads. missing: signals that there are not. omitted: what is
            not compared. another: that the rig file is of another rig; first of all.
    """
    against = (text for recording in recordings for text in contradictions(recording, rig))
    damaged = [*damage(recordings), *pauses(recordings), *at_the_stops(recordings, rig), *late, *against]
    blamed = result.report["verdict"] == "unknown" or any("load.mass" in h["effects"] for h in result.report["hypotheses"])
    said = [*another, *damaged, *missing, *undeclared(recordings, rig[PAYLOAD], blamed)]
    first = f"{careful(said)}{result.sentence}" if said and said[0] not in result.sentence else result.sentence
    sheet = of_reference(recordings, rig) if result.report["verdict"] == "unknown" else []
    notes = [*said, *sheet, *result.report["notes"], *omitted, *doubts(recordings)]
    return replace(result, report={**result.report, "notes": list(dict.fromkeys(notes))}, sentence=first, damage=damaged)
