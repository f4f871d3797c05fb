"""What a test would tell before it is made: which effects it detects, and which pairs of them it tells apart.

A duty is rehearsed with the rig as its sheet says, and the diagnosis' own sensitivities are taken
on it. With the information I of a column (the rig's parameters and the slack of the model's laws
integrated out) a departure x of it gives the score I x, and from there on detection is asked as the
diagnosis itself asks (`hypotheses.weigh`), and what else might explain it as `classes.separation` does.

Lindley, On a measure of the information provided by an experiment, Ann. Math. Stat. 27 (1956).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.comparison import Discrepancy
from ddh_twin_py.estimation.experiment import Experiment
from ddh_twin_py.gap.classes import TELLS_APART
from ddh_twin_py.gap.direct_drive import DirectDrive
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.hypotheses import LEAST, POWER, POWER_WITHOUT_COMMISSIONING, SLACK, WIDTH, weigh
from ddh_twin_py.gap.linearised import Linearised, linearise
from ddh_twin_py.rig import Rig

DETECTED = math.log(20.0)
"""Expected gain of log evidence over no effect from which an effect counts as detected."""
SIZES = {"faint": 2.2, "moderate": 5.0, "clear": 11.0}
"""Sizes by the rise of the worst signal, in multiples of its noise."""
_SMALLEST, _LARGEST = 1e-3, 1e3  # multiples of a column between which the smallest departure is looked for


@dataclass(frozen=True)
class Detection:
    """How one effect shows in a test, by the way of it that shows least.

    Attributes:
        effect: id. unit: of the departures.
        smallest: departure that is detected, None where its bounds allow none.
        rise: of the worst signal there, in multiples of its noise. worst: that signal, empty where the effect moves none.
        gain: size (`SIZES`) to expected log evidence over no effect; None where the effect's bounds do not allow that size.
    """

    effect: str
    unit: str
    smallest: float | None
    rise: float | None
    worst: str
    gain: dict[str, float | None]

    def detects(self, size: str) -> bool | None:
        """Whether a size is detected, None where it is not possible."""
        return None if self.gain[size] is None else self.gain[size] >= DETECTED


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
    power = POWER_WITHOUT_COMMISSIONING if commissioning is None else POWER
    linearised = linearise(model, effects, np.zeros(model.size), Discrepancy(), SLACK, power, pool, progress)
    detections = [detection(linearised, effect) for effect in effects]
    names, separation = separations(linearised)
    seen = {d.effect for d in detections if d.detects("moderate")}
    return Design(
        duration=float(field.duration), commissioning=0.0 if commissioning is None else float(commissioning.duration),
        sensors=tuple(field.sensors), pressures=any(name.startswith("pressure_") for name in field.signals),
        detections=detections, names=names, separation=separation, classes=classes(names, separation, seen))


def detection(linearised: Linearised, effect: Effect) -> Detection:
    """How an effect shows in a case, by the way of it that shows least."""
    ways = _ways(linearised, effect.id)
    if not ways:
        return Detection(effect.id, effect.unit, None, None, "", dict.fromkeys(SIZES))
    smallest = {i: _smallest(linearised, i) for i in ways}
    within = [i for i in ways if smallest[i] is not None] or ways
    hardest = max(within, key=lambda i: (smallest[i] or 0.0) * linearised.columns[i].rise)
    column, found = linearised.columns[hardest], smallest[hardest]
    gain: dict[str, float | None] = {}
    for name, rise in SIZES.items():
        possible = [i for i in ways if rise <= linearised.columns[i].rise * linearised.columns[i].room]
        gain[name] = min((_gain(linearised, i, rise / linearised.columns[i].rise) for i in possible), default=None)
    return Detection(effect.id, effect.unit, None if found is None else found * column.x, None if found is None else found * column.rise,
                     column.worst, gain)


def separations(linearised: Linearised) -> tuple[list[str], np.ndarray]:
    """Effects that move a signal, (m,), and how far each, at the moderate size, is told from each other one, (m, m); see `Design`."""
    columns, information = linearised.columns, linearised.evidence.sums.information
    names = list(dict.fromkeys(column.effect.id for column in columns))
    departure = np.array([min(SIZES["moderate"] / column.rise, column.room) for column in columns])
    own = np.diagonal(information)
    taken = np.maximum(information, 0.0) ** 2 / (own + WIDTH**-2)  # a column acts in its own direction alone
    apart = 0.5 * departure[:, None] ** 2 * (own[:, None] - taken)
    out = np.zeros((len(names), len(names)))
    ways = {name: _ways(linearised, name) for name in names}
    for i, one in enumerate(names):
        for j, other in enumerate(names):
            if i != j:
                out[i, j] = max(0.0, float(apart[np.ix_(ways[one], ways[other])].min()))
    return names, out


def classes(names: Sequence[str], separation: np.ndarray, among: set[str], least: float = TELLS_APART) -> list[list[str]]:
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
        if distance >= least:
            break
        groups[a] += groups.pop(b)
    return sorted(([names[i] for i in sorted(group)] for group in groups if len(group) > 1), key=lambda group: -len(group))


def _ways(linearised: Linearised, effect: str) -> list[int]:
    """Columns of an effect that its bounds let stand out; all of them where none does."""
    every = [i for i, column in enumerate(linearised.columns) if column.effect.id == effect]
    possible = [i for i in every if linearised.columns[i].rise * linearised.columns[i].room >= SIZES["faint"]]
    return possible or every


def _gain(linearised: Linearised, column: int, departure: float) -> float:
    """Expected log evidence of a column that departs by so many multiples of it."""
    own = float(linearised.evidence.sums.information[column, column])
    return weigh(np.array([[own]]), np.array([own * departure]), np.array([linearised.columns[column].room]))[0]


def _smallest(linearised: Linearised, column: int) -> float | None:
    """Smallest departure, in multiples of a column, that is detected; None where none that is allowed is."""
    room = min(linearised.columns[column].room, _LARGEST)
    low, high = min(_SMALLEST, LEAST), room
    if _gain(linearised, column, high) < DETECTED:
        return None
    for _ in range(50):
        middle = math.sqrt(low * high)
        if _gain(linearised, column, middle) < DETECTED:
            low = middle
        else:
            high = middle
    return high
