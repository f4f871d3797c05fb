"""A quantity that stays at one of a few levels and jumps between them, on a base that drifts: how sure is each cycle's level?

    y_t = s_{k(t)} + b_t + x_t' beta + e_t         s_1 = 0 the best condition, further ones on one side of it
    b_t = b_{t-1} + N(0, q_t^2)                    what the model does not know: wear-in, air, gas that escapes
    k(t) = k(t-1) with probability STAY            else any other level

e is normal, now and then an outlier. Levels and base are tracked together on a grid (a hidden Markov model, forward and backward exact);
shifts, coefficients and noise by expectation maximisation from several starts. Cycles whose condition is known hold the best level
there. How many levels there are is taken from the evidence (BIC) among those that lie apart by more than a given least distance; sets of
levels that explain the values nearly as well are averaged, their likelihood raised to the power that the gap engine takes for laws that
are a little wrong.

Rabiner, A tutorial on hidden Markov models, Proc. IEEE 77 (1989) 257; Schwarz, Annals of Statistics 6 (1978) 461.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.gap.evidence.hypotheses import POWER
from ddh_twin_py.real_rigs.zema.tracking import track

STAY = 0.95
"""Probability that a condition stays from one cycle to the next."""
KNOWN = 7.0
"""Log likelihood of the best level over any other in cycles that are known to have it."""
_OUTLIER = 0.01
_ITERATIONS, _TRIED = 60, 8  # of a promising start, of any
_PROMISING = 5
_ALIKE = 0.2  # of the least distance of levels, within which two sets of them are one
_WIDE = 0.15  # noise at the start, of the distance of levels: levels that start in the wrong place find theirs
_SETTLED = 0.05  # of log likelihood
_STARTS = (0.15, 0.3, 0.5, 0.75, 1.0, 1.3)  # of the spread of the values, for the farthest level
_LAG, _REWEIGHTED = 5, 30  # cycles over which a change is taken; steps of the least absolute deviations
_BENDS = (1.0, 1.5, 0.7)  # of the ladder of levels: evenly spaced, wider away from the best, narrower
_STRETCH, _PARTS = 3, 4  # cycles that are left out together; one stretch of so many is
_CELLS = 600  # of the grid at most


@dataclass(frozen=True)
class Series:
    """Values of consecutive cycles.

    Attributes:
        value: (n,), NaN where a cycle says nothing. noise: of one value. drift: standard deviation of the base's step into each cycle,
            (n,). favour: log likelihood of the best level over any other from elsewhere, (n,), 0 where nothing is known.
        columns, widths: of what the value may depend on besides, (n, m), and the standard
            deviations of their coefficients, (m,). least: distance of two levels below which they are one.
    """

    value: np.ndarray
    noise: float
    drift: np.ndarray
    favour: np.ndarray
    columns: np.ndarray
    widths: np.ndarray
    least: float


@dataclass(frozen=True)
class Levels:
    """What was found.

    Attributes:
        shift: of each level from the best, (k,), from 0 away. probability: of each level in each cycle, (n, k).
        base: drifting base with the columns' part, (n,). explained: the columns' part, (n,). coefficients: (m,). noise: of a value.
        log_likelihood, criterion: the latter BIC, smaller is better.
        worse, expected: of each cycle, probability that it is not at its best level and expected shift, (n,); where several sets of levels
            explain the values nearly as well, their average.
    """

    shift: np.ndarray
    probability: np.ndarray
    base: np.ndarray
    explained: np.ndarray
    coefficients: np.ndarray
    noise: float
    log_likelihood: float
    criterion: float
    worse: np.ndarray
    expected: np.ndarray


def _maximised(series: Series, shift: np.ndarray, beta: np.ndarray, noise: float, iterations: int) -> Levels:
    """Expectation maximisation from a start."""
    n, m = series.value.size, series.columns.shape[1]
    last = -np.inf
    sign = np.sign(shift[-1]) if shift.size > 1 else 1.0
    for _ in range(iterations):
        rest = series.value - series.columns @ beta
        lowest, highest = np.nanmin(rest), np.nanmax(rest)
        step = max(noise / 2.0, max(float(highest - lowest), 10.0 * noise) / _CELLS)
        grid = np.arange(lowest - max(shift.max(), 0.0), highest - min(shift.min(), 0.0) + step, step)
        drift = np.maximum(series.drift, 0.3 * step)
        total, probability, inlier, mean, square, base = track(rest, shift, grid, noise, drift, series.favour, STAY, _OUTLIER)
        total -= 0.5 * float(np.sum((beta / series.widths) ** 2))
        found = Levels(shift.copy(), probability, base + series.columns @ beta, series.columns @ beta, beta.copy(), noise, total,
                       2.0 * (2 * shift.size + m) * 0.5 * math.log(n) - 2.0 * total, 1.0 - probability[:, 0], probability @ shift)
        if total - last < _SETTLED:
            break
        last = total
        count = np.maximum(inlier.sum(axis=0), 1e-9)
        moved = mean.sum(axis=0) / count
        left = mean - inlier * np.concatenate([[0.0], moved[1:]])
        shift = shift + np.concatenate([[0.0], moved[1:]])
        shift = sign * np.maximum(sign * shift, 0.0)
        noise = max(math.sqrt(float(square.sum() / inlier.sum())), 0.5 * series.noise)
        if m:
            weighted = series.columns / noise**2
            normal = series.columns.T @ (weighted * inlier.sum(axis=1)[:, None]) + np.diag(series.widths**-2)
            beta = beta + np.linalg.solve(normal, weighted.T @ left.sum(axis=1) - beta * series.widths**-2)
    return found


def _apart(shift: np.ndarray, least: float) -> bool:
    return shift.size == 1 or bool(np.min(np.abs(np.diff(np.sort(shift)))) >= least)


def _tilts(series: Series) -> list[np.ndarray]:
    """Coefficients from which to begin, (m,) each: those of the changes over a few cycles, in which levels seldom jump, and none."""
    nothing = np.zeros(series.columns.shape[1])
    if not nothing.size:
        return [nothing]
    change, columns = series.value[_LAG:] - series.value[:-_LAG], series.columns[_LAG:] - series.columns[:-_LAG]
    there = np.isfinite(change)
    change, columns = change[there], columns[there]
    beta = nothing
    for _ in range(_REWEIGHTED):  # least absolute deviations: jumps count no more than they are many
        weight = 1.0 / np.maximum(np.abs(change - columns @ beta), series.noise)
        beta = np.linalg.solve((columns * weight[:, None]).T @ columns + np.diag(series.noise * series.widths**-2),
                               columns.T @ (weight * change))
    return [beta, nothing] + [sign * series.widths * (np.arange(nothing.size) == 0) for sign in (1.0, -1.0)]


def none(series: Series) -> Levels:
    """One level on the drifting base."""
    found = (_maximised(series, np.zeros(1), tilt, 2.0 * series.noise, _ITERATIONS) for tilt in _tilts(series))
    return min(found, key=lambda f: f.criterion)


def left_out(series: Series, found: Levels) -> tuple[np.ndarray, np.ndarray]:
    """What is left of cycles that take no part, in multiples of the noise, (m,) each: on the base alone, and with the levels found.

    One stretch of `_STRETCH` cycles in `_PARTS` takes no part; levels and base there are what the cycles around it say.
    """
    away = (np.arange(series.value.size) // _STRETCH) % _PARTS == 0
    rest = replace(series, value=np.where(away, np.nan, series.value))
    there = away & np.isfinite(series.value)
    again = _maximised(rest, found.shift, found.coefficients, found.noise, _ITERATIONS)
    return tuple((series.value - one.base - one.expected)[there] / series.noise for one in (none(rest), again))


def find(series: Series, counts: Sequence[int], signs: Sequence[float]) -> Levels:
    """The levels that the values speak for.

    Args:
        counts: numbers of levels to try beside one, 2 or more. signs: sides of the best level on which worse ones may lie.
    """
    tilts = [(tilt, float(np.subtract(*np.nanpercentile(series.value - series.columns @ tilt, [98.0, 2.0])))) for tilt in _tilts(series)]
    found = [none(series)]
    for count in counts:
        ladder = np.arange(count) / (count - 1)
        starts = [(sign * share * spread * ladder**bend, tilt) for sign in signs for share in _STARTS for bend in _BENDS
                  for tilt, spread in tilts]
        tried = sorted((_maximised(series, start, tilt, max(2.0 * series.noise, _WIDE * abs(start[-1]) / (count - 1)), _TRIED)
                        for start, tilt in starts), key=lambda f: f.criterion)
        refined = (_maximised(series, f.shift, f.coefficients, f.noise, _ITERATIONS) for f in _distinct(tried, series.least)[:_PROMISING])
        found += [f for f in refined if _apart(f.shift, series.least)]
    found = _distinct(sorted(found, key=lambda f: f.criterion), series.least)
    best = found[0]
    order = np.argsort(np.abs(best.shift), kind="stable")
    weight = np.exp(-0.5 * POWER * (np.array([f.criterion for f in found]) - best.criterion))
    weight /= weight.sum()
    return replace(best, shift=best.shift[order], probability=best.probability[:, order],
                   worse=np.clip(sum(w * f.worse for w, f in zip(weight, found, strict=True)), 0.0, 1.0),
                   expected=sum(w * f.expected for w, f in zip(weight, found, strict=True)))


def _distinct(found: Sequence[Levels], least: float) -> list[Levels]:
    """The first of those whose shifts are alike."""
    out: list[Levels] = []
    for one in found:
        if not any(one.shift.size == other.shift.size and np.max(np.abs(one.shift - other.shift)) < _ALIKE * least for other in out):
            out.append(one)
    return out
