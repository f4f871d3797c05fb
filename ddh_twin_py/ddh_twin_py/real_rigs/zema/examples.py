"""Runs of cycles on which the gap engine itself is asked: one for each component, where it is farthest from its best condition."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.real_rigs.diagnose import Outcome, rounds
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.zema.catalogue import DESCRIPTION
from ddh_twin_py.real_rigs.zema.conditions import Conditions
from ddh_twin_py.real_rigs.zema.model import Cycles
from ddh_twin_py.real_rigs.zema.recordings import Record

_MOST = 12  # cycles of a run
_LEAST = 8
_SURE = 0.9
_HELD = 3  # one cycle of so many takes no part in finding


@dataclass(frozen=True)
class Example:
    """A run of cycles with what the levels say of it and what the engine's rounds say.

    Attributes:
        cycles: of the run. levels: components that are not at their best level, with their level counted from 0.
        outcomes: of the engine, each with the effects before it built in.
    """

    cycles: slice
    levels: dict[str, int]
    outcomes: list[Outcome]


def runs_of(conditions: Conditions, known: np.ndarray) -> list[tuple[slice, dict[str, int]]]:
    """Runs of cycles at one level of every component, all of them sure; those of known condition are left out."""
    level = np.stack([one.probability.argmax(axis=1) for one in conditions.found.values()], axis=1)
    sure = np.min([one.probability.max(axis=1) for one in conditions.found.values()], axis=0) > _SURE
    out, begin = [], 0
    for t in range(1, level.shape[0] + 1):
        if t == level.shape[0] or np.any(level[t] != level[begin]) or known[t] != known[begin] or sure[t] != sure[begin]:
            if t - begin >= _LEAST and sure[begin] and not known[begin]:
                there = {c: int(k) for c, k in zip(conditions.found, level[begin], strict=True) if k > 0}
                out.append((slice(begin, min(t, begin + _MOST)), there))
            begin = t
    return out


def chosen(conditions: Conditions, known: np.ndarray) -> list[tuple[slice, dict[str, int]]]:
    """For each component the first run in which it is farthest from its best among the runs with fewest others; and one with none."""
    runs = runs_of(conditions, known)
    out = [run for run in runs if not run[1]][:1]
    for component, one in conditions.found.items():
        there = [run for run in runs if component in run[1]]
        if one.shift.size > 1 and there:
            best = min(there, key=lambda run: (len(run[1]), -run[1][component], run[0].start))
            if best not in out:
                out.append(best)
    most = max(runs, key=lambda run: (len(run[1]), sum(run[1].values())), default=None)
    return out if most is None or most in out else [*out, most]


def ask(record: Record, conditions: Conditions, known: np.ndarray, progress: Callable[[float], None]) -> list[Example]:
    """Diagnose the chosen runs with the known cycles as the rig in its best condition."""
    commissioning = [Cycles(record, block) for block in record.blocks()]
    out = []
    wanted = chosen(conditions, known)
    for number, (cycles, levels) in enumerate(wanted):
        held = (cycles.stop - cycles.start) // _HELD
        out.append(Example(cycles, levels, rounds(RigModel(DESCRIPTION, [Cycles(record, cycles, held)], commissioning=commissioning))))
        progress((number + 1) / len(wanted))
    return out
