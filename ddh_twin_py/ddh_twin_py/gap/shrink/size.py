"""How large a gap is: residuals of a free run over the floor of each signal."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

WITHOUT_COMMISSIONING = 1.6
"""Floor of a signal, in multiples of its noise, where no commissioning recording says more."""
BEGINS = 1.2
"""Gap, in multiples of the floor, up to which there is none; below it no closed fraction is stated."""
_DRAWS = 200  # of the bootstrap
_BLOCK, _LEAST_BLOCKS = 30.0, 8  # s that stay together in it, fewer where a recording is short

Mask = Callable[[object], np.ndarray]


def counted(signal) -> np.ndarray:
    """Samples that count: those gathered into bins, (n,)."""
    return signal.binning.bin >= 0


def ratios(signals: Mapping, predictions: Mapping[str, np.ndarray], mask: Mask = counted) -> dict[str, float]:
    """RMS of each signal's residual over the noise of one sample; signals without a sample are left out.

    Where a run went astray and predicts no number, the signal is infinitely off.
    """
    out = {}
    for name, signal in signals.items():
        off = (signal.measured - predictions[name])[mask(signal) & np.isfinite(signal.measured)]
        if off.size:
            rms = float(np.sqrt(np.mean(off**2)))
            out[name] = rms / signal.noise if np.isfinite(rms) else np.inf
    return out


def pooled(recordings: Sequence[tuple[Mapping, Mapping[str, np.ndarray]]], mask: Mask = counted) -> dict[str, float]:
    """The same of several recordings, given as signals and predictions: root mean square of theirs."""
    found: dict[str, list[float]] = {}
    for signals, predictions in recordings:
        for name, ratio in ratios(signals, predictions, mask).items():
            found.setdefault(name, []).append(ratio)
    return {name: float(np.sqrt(np.mean(np.square(values)))) for name, values in found.items()}


def floors(commissioning: Sequence[tuple[Mapping, Mapping[str, np.ndarray]]], names: Sequence[str]) -> dict[str, float]:
    """Floor of each signal in multiples of its noise.

    Args:
        commissioning: signals and predictions of the twin fitted to them; empty where there is none.
        names: signals wanted; one that the commissioning lacks has the floor of a rig without it.
    """
    found = pooled(commissioning)
    return {name: max(1.0, found[name]) if name in found else WITHOUT_COMMISSIONING for name in names}


def gap(ratio: Mapping[str, float], floor: Mapping[str, float]) -> float:
    """Root mean square over signals of residual over floor."""
    return of_all({name: ratio[name] / floor[name] for name in ratio})


def of_all(over: Mapping[str, float]) -> float:
    """The same, of residuals over floors."""
    return float(np.sqrt(np.mean(np.square(list(over.values())))))


def closed(before: float, after: float) -> float | None:
    """Fraction of the gap that is closed, None where there is hardly one; where the run before went astray all, unless that after does."""
    if np.isinf(before):
        return float(np.isfinite(after))
    return None if before < BEGINS else (before - after) / (before - 1.0)


def redrawn(square: np.ndarray, count: np.ndarray, draws: int, rng: np.random.Generator) -> np.ndarray:
    """Mean squares of a record whose blocks are drawn anew, (draws,).

    Künsch, The jackknife and the bootstrap for general stationary observations, Ann. Stat. 17 (1989).

    Args:
        square, count: sum of squares and samples of each block, (b,).
    """
    drawn = rng.integers(0, count.size, (draws, count.size))
    return square[drawn].sum(axis=1) / count[drawn].sum(axis=1)


def interval(recordings: Sequence[tuple[object, np.ndarray]], mask: Mask = counted) -> tuple[float, float]:
    """95 % interval of a residual's RMS, in the signal's unit, by a bootstrap of blocks of at most `_BLOCK` s; NaN where no sample counts.

    Blocks are drawn within each recording, and recordings weigh the same, as in `pooled`.

    Args:
        recordings: one signal in each, and what was predicted of it.
    """
    rng, squares = np.random.default_rng(0), []
    for signal, prediction in recordings:
        off = signal.measured - prediction
        used = mask(signal) & np.isfinite(off)
        time = signal.time[used]
        if not time.size:
            continue
        block = min(_BLOCK, float(np.ptp(time)) / _LEAST_BLOCKS) or _BLOCK
        _, which = np.unique((time / block).astype(np.int64), return_inverse=True)
        square, count = np.bincount(which, off[used] ** 2), np.bincount(which)
        squares.append(redrawn(square, count, _DRAWS, rng))
    if not squares:
        return float("nan"), float("nan")
    low, high = np.percentile(np.sqrt(np.mean(squares, axis=0)), [2.5, 97.5])
    return float(low), float(high)
