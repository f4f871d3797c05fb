"""Where something acts that no listed effect explains: the place whose free inputs explain most of the gap.

At each place everything that its balances can be lacking is free at once: every way of every effect that is listed there and terms of
the model that no effect is asked of, each constant or other in each phase, and growing with speed and with the oil's warmth. What a
place lacks is one course in time that moves all signals by the model's own laws; a reading that errs is free in the same way and moves
itself alone. Places are compared on the evidence of these linear models, on the one linearisation of the case.

Kennedy & O'Hagan, Bayesian calibration of computer models, J. R. Statist. Soc. B 63 (2001) 425, on free discrepancies; MacKay,
Information Theory, Inference and Learning Algorithms (2003), chapter 28, on their evidence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fitting.binning import PHASES, STEADY
from ddh_twin_py.estimation.fitting.comparison import Comparison
from ddh_twin_py.estimation.fitting.linear_gaussian import gain
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import TYPICAL, Column
from ddh_twin_py.gap.explain.modulation import centred

_CONSTANT, _VARYING = 3.0, 1.0  # prior standard deviations of an input and of how it varies, in multiples of a column; see `_stacked`
_LEAST = 1e-9  # information below which an input moves nothing
_SOFTNESS = 0.2  # share of the best place's log evidence by which the odds of places are tempered: the inputs are crude
_HARDEST = 2.0  # log evidence by which they are tempered at least
_ALSO = 0.5  # share of what the best place explains of one signal, from which a place explains that signal


@dataclass(frozen=True)
class FreePlace:
    """One place and how much its free inputs explain.

    Attributes:
        component, domain: where. log_evidence: over no input. share: probability among all places.
        column, departure, relative: of its constant inputs the one that explains most, by how many multiples of it, and the standard
            deviation of that over it; None and 0 where there is none, as of a reading.
        signal: the reading that errs, else empty. course: what it is off by, as its inputs are most probable, in features, by recording,
            (rows,); None where no reading errs.
    """

    component: str
    domain: str
    log_evidence: float
    share: float
    column: Column | None
    departure: float = 0.0
    relative: float = 0.0
    signal: str = ""
    course: list[np.ndarray] | None = None


@dataclass(frozen=True)
class _Inputs:
    """Rows by recording of one place's constant inputs, and of further ones that vary; ``columns`` are those of the former."""

    constant: list[list[np.ndarray]]
    further: list[list[np.ndarray]]
    columns: list[Column]
    signal: str = ""


def free_places(linearised: Linearised, columns: Sequence[Column], variables: Sequence[Mapping[str, np.ndarray]],
                reads: Callable[[str], tuple[str, str]], off: str = "") -> list[FreePlace]:
    """Places, the likeliest first; one entry for each component.

    Args:
        linearised: of the case. columns: of effects and of terms that no effect is asked of, taken there.
        variables: with which an input may grow, by recording: name to values at all bins (rows,).
        reads: signal to component and domain that errs where its reading does. off: signal that surely is off; places that explain little
            of it are left out. Empty where none is sure.
    """
    courses = [_courses(c, v) for c, v in zip(linearised.comparisons, variables, strict=True)]
    places: dict[tuple[str, str, str], _Inputs] = {}
    for column in columns:
        own = places.setdefault((column.effect.component, column.effect.domain, ""), _Inputs([], [], []))
        own.constant.append(column.change)
        own.columns.append(column)
    readings = _readings(linearised)
    places |= {(*reads(inputs.signal), inputs.signal): inputs for inputs in readings}
    values, own = linearised.values(), _rows_of(linearised.comparisons, off)
    found, told = [], []
    for key, inputs in places.items():
        stacked, widths = _stacked(inputs, courses)
        told.append(_told_of(linearised, stacked, widths, values, own) if off else 0.0)
        found.append(_explained(linearised, key, inputs, stacked, widths, values, math.log(len(readings)) if inputs.signal else 0.0))
    least = _ALSO * max(told, default=0.0)
    best: dict[str, FreePlace] = {}
    for place in sorted((p for p, t in zip(found, told, strict=True) if p is not None and t >= least), key=lambda p: -p.log_evidence):
        best.setdefault(place.component, place)
    return _shared(list(best.values()))


def _courses(comparison: Comparison, variables: Mapping[str, np.ndarray]) -> list[np.ndarray]:
    """Courses in time with which what is lacking may vary, (rows,) each; of temperatures and strokes, which sum up, none."""
    prompt, phase = np.zeros(comparison.size), np.full(comparison.size, -1)
    for block in comparison.blocks:
        if block.prompt:
            prompt[block.rows], phase[block.rows] = 1.0, block.binning.phase
    return [*((phase == PHASES.index(name)).astype(float) for name in STEADY), *(prompt * centred(v) for v in variables.values())]


def _varied(change: Sequence[np.ndarray], courses: Sequence[Sequence[np.ndarray]]) -> list[list[np.ndarray]]:
    """An input as it would move the signals with each course in time."""
    return [[rows * course for rows, course in zip(change, several, strict=True)] for several in zip(*courses, strict=True)]


def _readings(linearised: Linearised) -> list[_Inputs]:
    """Every reading while effects act, off by a constant, and by what grows with it and with time."""
    altered = linearised.model.altered
    names = dict.fromkeys(b.signal for c, acts in zip(linearised.comparisons, altered, strict=True) if acts for b in c.blocks)
    out = []
    for name in names:
        constant, gained, drifted = ([np.zeros(c.size) for c in linearised.comparisons] for _ in range(3))
        for i, (comparison, prediction) in enumerate(zip(linearised.comparisons, linearised.predictions, strict=True)):
            features = comparison.features(prediction) if altered[i] else None
            for block in comparison.blocks:
                if features is not None and block.signal == name:
                    size = TYPICAL * comparison.noise(name) / block.spread
                    read = features[block.rows] * block.spread
                    constant[i][block.rows] = size
                    gained[i][block.rows] = size * read / max(float(np.abs(read).max(initial=0.0)), 1e-12)
                    drifted[i][block.rows] = size * centred(block.binning.time)
        out.append(_Inputs([constant], [gained, drifted], [], name))
    return out


def _stacked(inputs: _Inputs, courses: Sequence[Sequence[np.ndarray]]) -> tuple[list[np.ndarray], np.ndarray]:
    """All inputs of a place, the constant ones first, by recording, (rows, m), and prior standard deviations of them, (m,).

    An input whose law allows less than such a deviation has that much less of it, and varies by as much less.
    """
    changed = [_varied(change, courses) for change in inputs.constant]
    allowed = [min(1.0, column.room / _CONSTANT) for column in inputs.columns] or [1.0] * len(changed)
    varying = [*inputs.further, *(varied for several in changed for varied in several)]
    widths = [_CONSTANT * share for share in allowed] + [_VARYING] * len(inputs.further)
    widths += [_VARYING * share for share, several in zip(allowed, changed, strict=True) for _ in several]
    return [np.column_stack(rows) for rows in zip(*inputs.constant, *varying, strict=True)], np.array(widths)


def _rows_of(comparisons: Sequence[Comparison], signal: str) -> list[np.ndarray]:
    """1 in the rows of one signal and 0 in all others, by recording, (rows,)."""
    out = [np.zeros(c.size) for c in comparisons]
    for rows, comparison in zip(out, comparisons, strict=True):
        for block in comparison.blocks:
            rows[block.rows] = block.signal == signal
    return out


def _told_of(linearised: Linearised, stacked: Sequence[np.ndarray], widths: np.ndarray, values: Sequence[np.ndarray],
             own: Sequence[np.ndarray]) -> float:
    """What a place's inputs explain in some rows alone: half the chi-square that they take away, as the evidence weighs it."""
    sums = linearised.basis.sums([s * rows[:, None] for s, rows in zip(stacked, own, strict=True)],
                                 [v * rows for v, rows in zip(values, own, strict=True)])
    seen = np.flatnonzero(np.diagonal(sums.information) > _LEAST)
    _, estimate, _ = gain(sums.information[np.ix_(seen, seen)], sums.score[seen], widths[seen])
    return 0.5 * float(sums.score[seen] @ estimate)


def _explained(linearised: Linearised, key: tuple[str, str, str], inputs: _Inputs, stacked: Sequence[np.ndarray], widths: np.ndarray,
               values: Sequence[np.ndarray], penalty: float) -> FreePlace | None:
    """A place by its constant inputs, or by these and how they vary, whichever has more evidence; None where nothing is moved."""
    sums = linearised.basis.sums(stacked, values)
    seen = np.flatnonzero(np.diagonal(sums.information) > _LEAST)
    steady = seen[seen < len(inputs.constant)]
    if not steady.size:
        return None
    log, estimate, taken = max(((*gain(sums.information[np.ix_(some, some)], sums.score[some], widths[some])[:2], some)
                                for some in (steady, seen)), key=lambda found: found[0])
    precision = np.diagonal(sums.information)[steady] + widths[steady] ** -2
    course = [rows[:, taken] @ estimate for rows in stacked] if inputs.signal else None
    place = FreePlace(key[0], key[1], float(log - penalty), 0.0, None, signal=inputs.signal, course=course)
    i = int(np.argmax(np.where(sums.score[steady] > 0.0, sums.score[steady] ** 2 / precision, -1.0)))
    departure = float(sums.score[steady[i]] / precision[i])
    if not inputs.columns or departure <= 0.0:
        return place
    relative = float(1.0 / (departure * math.sqrt(precision[i])))
    return replace(place, column=inputs.columns[steady[i]], departure=departure, relative=relative)


def _shared(places: list[FreePlace]) -> list[FreePlace]:
    """The same with the probability of each."""
    if not places:
        return []
    log = np.array([p.log_evidence for p in places])
    odds = np.exp((log - log[0]) / max(_HARDEST, _SOFTNESS * log[0]))
    return [replace(place, share=float(share)) for place, share in zip(places, odds / odds.sum(), strict=True)]
