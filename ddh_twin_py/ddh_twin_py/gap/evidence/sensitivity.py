"""How every signal answers to every effect: one column per way in which an effect may act.

An effect's column is a secant, taken at a size that moves the worst signal by about five times
its noise: what is asked is how the effect looks when it matters, and many laws bend on the way.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Comparison
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.model import FreeRuns
from ddh_twin_py.physics.compiled import kernel

TYPICAL = 5.0
"""Rise of the worst signal, in multiples of its noise, at which a column is taken."""
_AS_TYPICAL = 0.4, 2.5  # of it: within these a rise is typical enough
_FARTHEST = 300.0  # how much larger than the first guess a departure may become
_ATTEMPTS = 7  # to meet the typical rise
ASTRAY = 1.0e9
"""Deviations of a bin, from which a run went astray and says nothing."""
_NOTICEABLE = 0.05  # of the noise: an effect that moves no signal further is not seen at all


Way = tuple[str, int, bool]
"""Effect, index of its law, and whether its departure is positive."""


@dataclass(frozen=True)
class Column:
    """One way of one effect.

    Attributes:
        effect: the effect. law: index into its laws. x: departure that it stands for. taken: departure at which it was taken.
        rise: of the worst signal there, in multiples of its noise. worst: that signal.
        change: of the features of each recording for the departure x, list of (rows,).
    """

    effect: Effect
    law: int
    x: float
    rise: float
    worst: str
    change: list[np.ndarray]
    taken: float = 0.0

    def __post_init__(self) -> None:
        if self.taken == 0.0:
            object.__setattr__(self, "taken", self.x)

    def longer(self, factor: float) -> Column:
        """The same way of an effect, so many times as far, but not beyond what its law allows."""
        factor = min(factor, max(1.0, self.room))
        return replace(self, x=factor * self.x, rise=factor * self.rise, change=[factor * h for h in self.change])

    def stretched(self, ratios: Sequence[np.ndarray]) -> Column:
        """The same with every row of its change so many times as large, by recording, (rows,)."""
        return replace(self, change=[rows * ratio for rows, ratio in zip(self.change, ratios, strict=True)])

    @property
    def way(self) -> Way:
        """Effect, law and direction."""
        return _way(self.effect, self.law, self.x)

    @property
    def room(self) -> float:
        """Largest departure that is allowed in this direction, in multiples of the column."""
        return (self.effect.highest if self.x > 0.0 else self.effect.lowest) / self.x


def acting_of(columns: Sequence[Column], x: np.ndarray) -> list[tuple[Effect, int, float]]:
    """Effects of columns with departures (m,) in their own units, as a model runs them; see `model.Acting`."""
    return [(c.effect, c.law, float(v)) for c, v in zip(columns, x, strict=True)]


def stacked(columns: Sequence[Column], comparisons: Sequence[Comparison]) -> list[np.ndarray]:
    """What columns change, by recording, (rows, m)."""
    return [np.column_stack([np.empty((comparison.size, 0)), *(c.change[number] for c in columns)])
            for number, comparison in enumerate(comparisons)]


def sane(rows: np.ndarray) -> np.ndarray:
    """Which of some features are those of a run that did not go astray."""
    return np.abs(rows) < ASTRAY


def without_astray(columns: np.ndarray) -> np.ndarray:
    """The same, (rows, k), with nothing in each column of which a run went astray."""
    return np.where(sane(columns).all(axis=0), columns, 0.0)


@kernel
def rms_change(bins, changed, base):
    """RMS by which samples (n,) of bins that count changed; infinite, or no number, of a run that went astray."""
    total, count = 0.0, 0
    for i in range(bins.shape[0]):
        if bins[i] >= 0:
            total += (changed[i] - base[i]) ** 2
            count += 1
    return math.sqrt(total / count)


def rise_of(signals: Sequence[dict], with_effect: Sequence[dict], without: Sequence[dict],
            amplified: Collection[str] = ()) -> tuple[float, str]:
    """RMS change of the worst signal over its noise, and which it is; one of those ``amplified`` where no other is moved."""
    rises: dict[str, float] = {}
    for own, changed, base in zip(signals, with_effect, without, strict=True):
        for name, signal in own.items():
            if not np.isfinite(signal.noise) or signal.binning.count.size == 0:
                continue
            rise = rms_change(signal.binning.bin, changed[name], base[name]) / signal.noise
            rises[name] = max(rises.get(name, 0.0), rise if math.isfinite(rise) else math.inf)
    others = {name: rise for name, rise in rises.items() if name not in amplified and not rise <= _NOTICEABLE}
    worst = max(others or rises, key=rises.get, default="")
    return rises.get(worst, 0.0), worst


def typical(rise: float) -> bool:
    """Whether a column of such a rise is about as long as one should be."""
    return _AS_TYPICAL[0] * TYPICAL <= rise <= _AS_TYPICAL[1] * TYPICAL


def reaching(rise_at: Callable[[float], float], limit: Callable[[float], float], x: float) -> float:
    """A departure at which the worst signal rises by about `TYPICAL`, from a first guess; where none is met, the one that comes nearest.

    A law with a threshold, as a valve's that opens, shows nothing for long and much at once: between the two the geometric mean is tried.
    """
    short, beyond, tried = 0.0, 0.0, {}
    for attempt in range(_ATTEMPTS):
        rise = tried[x] = rise_at(x)
        if typical(rise):
            return x
        if rise < TYPICAL:
            short = x
        else:  # or astray
            beyond = x
        if short and beyond:
            further = math.copysign(math.sqrt(short * beyond), x)
        elif np.isfinite(rise):
            further = limit(x * min(TYPICAL / max(rise, 1e-3), _FARTHEST ** (0.5 * (attempt + 1))))
        else:
            further = 0.1 * x
        if further in tried:
            break
        x = further
    return min(tried, key=lambda x: abs(math.log(max(tried[x], 1e-6) / TYPICAL)) if np.isfinite(tried[x]) else math.inf)


def columns_of(effects: Sequence[Effect], model: FreeRuns, theta: np.ndarray, comparisons: Sequence[Comparison], pool: ThreadPoolExecutor,
               near: Sequence[Column] = ()) -> list[Column]:
    """The columns of `taken_at` alone."""
    return taken_at(effects, model, theta, comparisons, pool, near=near)[0]


def taken_at(effects: Sequence[Effect], model: FreeRuns, theta: np.ndarray, comparisons: Sequence[Comparison], pool: ThreadPoolExecutor,
             progress: Callable[[float], None] | None = None, near: Sequence[Column] = (),
             astray: Collection[Way] = (), keep: bool = True) -> tuple[list[Column], set[Way]]:
    """Columns of all effects in every law and direction, and ways in which runs went astray; those that move nothing are left out.

    Args:
        model: of the rig. theta: parameters, in deviations, (k,). comparisons: of the recordings.
        near: columns taken elsewhere, whose departures are taken again; none: all ways are tried. astray: further ways to try.
        keep: whether they are whatever their rise is here; else one that has become too short or too long is sought anew.
    """
    if not effects:
        return [], set()
    altered = [i for i, acts in enumerate(model.altered) if acts]
    signals = [model.signals[i] for i in altered]

    @functools.cache
    def base(roughly: bool) -> tuple[list[dict[str, np.ndarray]], list[np.ndarray]]:
        predicted = [model.run_one(i, theta, (), roughly=roughly) for i in altered]
        return predicted, [comparisons[i].features(p) for i, p in zip(altered, predicted, strict=True)]

    base(True)  # before several threads ask for it; a fine one is hardly ever asked for
    known = {c.way: c.taken for c in near}
    were_typical = {c.way for c in near if typical(c.rise * c.taken / c.x)}
    tasks = [(effect, law, sign) for effect in effects for law in range(len(effect.laws)) for sign in effect.directions]
    if near:
        tasks = [task for task in tasks if _way(*task) in known or _way(*task) in astray]

    def acted(effect: Effect, law: int, x: float, roughly: bool) -> tuple[list[np.ndarray], float, str]:
        without, features = base(roughly)
        predicted = [model.run_one(i, theta, [(effect, law, x)], roughly=roughly) for i in altered]
        change = [np.zeros(c.size) for c in comparisons]
        for i, p, at in zip(altered, predicted, features, strict=True):
            change[i] = comparisons[i].features(p) - at
        return change, *rise_of(signals, predicted, without, model.witnesses.amplified)

    def column(task: tuple[Effect, int, float]) -> Column | Way | None:
        effect, law, sign = task
        way = _way(*task)
        begin = known.get(way, effect.limit(sign * abs(effect.step)))
        for roughly in (True, False):  # a rough run may go astray where a fine one does not
            once = functools.cache(functools.partial(acted, effect, law, roughly=roughly))
            kept = way in known and (keep or way not in were_typical or typical(once(begin)[1]))
            x = begin if kept else reaching(lambda x, once=once: once(x)[1], effect.limit, begin)
            change, rise, worst = once(x)
            if rise <= 10.0 * TYPICAL:
                break
        if not np.isfinite(rise) or not all(sane(rows).all() for rows in change):
            return way
        return None if rise < _NOTICEABLE else Column(effect, law, x, rise, worst, change)

    out, lost = [], set()
    for i, found in enumerate(pool.map(column, tasks)):
        if isinstance(found, Column):
            out.append(found)
        elif found is not None:
            lost.add(found)
        if progress is not None:
            progress((i + 1) / len(tasks))
    return out, lost


def _way(effect: Effect, law: int, sign: float) -> Way:
    return effect.id, law, sign > 0.0
