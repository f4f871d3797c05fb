"""What a test would tell before it is made: which effects it detects, and which pairs of them it tells apart.

A duty is rehearsed with the rig as its sheet says, and the diagnosis' own sensitivities are taken
on it: `detection` asks what would be found, and what else might explain it is asked as `classes.separation` does.

Lindley, On a measure of the information provided by an experiment, Ann. Math. Stat. 27 (1956).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.gap.drive.direct_drive import DirectDrive
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.evidence.linearised import Linearised, linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.classes import TELLS_APART, separations
from ddh_twin_py.gap.explain.detection import SIZES, Detection, detections, ways_of
from ddh_twin_py.rig import Rig


@dataclass(frozen=True)
class Design:
    """What a test would tell.

    Attributes:
        duration: s of the test. commissioning: s of the commissioning recording, 0 without.
        sensors: temperature sensors beside ambient. pressures: whether there are transducers.
        detections: of every effect, in the catalogue's order.
        names: effects that move any signal, (m,). separation: expected log Bayes factor of the effect of a row, at the
            moderate size (or the largest that its bounds allow), against that of a column, (m, m), 0 on the diagonal.
        classes: effects that are detected at that size and not told apart, largest class first.
    """

    duration: float
    commissioning: float
    sensors: tuple[str, ...]
    pressures: bool
    detections: list[Detection]
    names: list[str]
    separation: np.ndarray
    classes: list[list[str]]


def design(field: Experiment, commissioning: Experiment | None, rig: Rig, effects: Sequence[Effect], pool: ThreadPoolExecutor,
           progress: Callable[[float], None] | None = None) -> Design:
    """Ask what a test would tell.

    Args:
        field: rehearsal of the test. commissioning: rehearsal of a recording of the rig as built, None without.
        rig: that does both. effects: that might act in the test. progress: told the share done.
    """
    model = DirectDrive([] if commissioning is None else [commissioning], [field], rig)
    linearised = linearise(Question(model, effects), np.zeros(model.size), pool, progress)
    shown = detections(linearised, effects, pool)
    names, separation = by_effect(linearised)
    seen = {d.effect for d in shown if d.detects("moderate")}
    return Design(
        duration=float(field.duration), commissioning=0.0 if commissioning is None else float(commissioning.duration),
        sensors=tuple(field.sensors), pressures=any(name.startswith("pressure_") for name in field.signals),
        detections=shown, names=names, separation=separation, classes=classes(names, separation, seen))


def by_effect(linearised: Linearised) -> tuple[list[str], np.ndarray]:
    """Effects that move a signal, (m,), and how far each, at the moderate size, is told from each other one, (m, m); see `Design`."""
    columns, information = linearised.columns, linearised.evidence.sums.information
    names = list(dict.fromkeys(column.effect.id for column in columns))
    departure = np.array([min(SIZES["moderate"] / column.rise, column.room) for column in columns])
    apart = separations(information, departure)
    out = np.zeros((len(names), len(names)))
    ways = {name: ways_of(linearised, name) for name in names}
    for i, one in enumerate(names):
        for j, other in enumerate(names):
            if i != j:
                out[i, j] = max(0.0, float(apart[np.ix_(ways[one], ways[other])].min()))
    return names, out


def classes(names: Sequence[str], separation: np.ndarray, among: set[str]) -> list[list[str]]:
    """Sets of two or more effects of which no pair is told apart, by complete linkage, largest first.

    Args:
        names: (m,). separation: see `Design`, (m, m). among: effects that are asked about.
    """
    apart = np.minimum(separation, separation.T)
    groups = [[i] for i, name in enumerate(names) if name in among]
    while len(groups) > 1:
        farthest = {(a, b): max(apart[i, j] for i in groups[a] for j in groups[b])
                    for a in range(len(groups)) for b in range(a + 1, len(groups))}
        (a, b), distance = min(farthest.items(), key=lambda item: item[1])
        if distance >= TELLS_APART:
            break
        groups[a] += groups.pop(b)
    return sorted(([names[i] for i in sorted(group)] for group in groups if len(group) > 1), key=lambda group: -len(group))
