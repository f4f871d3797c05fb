"""Two small recordings that share their classes, and the dense matrix of what the model is forgiven in them."""

import numpy as np
from ddh_twin_py.estimation.fitting.binning import Binning, by_time
from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy
from ddh_twin_py.estimation.fitting.experiment import Signal
from ddh_twin_py.estimation.fitting.weighting import STRETCH, VARIANT


def fast(rng, bins, seconds):
    """A signal of three samples per bin in four classes, the last of them transient."""
    time = np.sort(rng.uniform(0.0, seconds, 3 * bins))
    at = time.reshape(bins, 3).mean(axis=1)
    kind = np.sort(rng.integers(0, 4, bins))[rng.permutation(bins)]
    binning = Binning(np.repeat(np.arange(bins), 3), np.full(bins, 3), kind, np.where(kind == 3, 3, 0), at)
    return Signal(time, rng.normal(size=time.size), 0.7, "1", binning)


def slow(rng, seconds):
    time = np.arange(0.0, seconds, 5.0)
    binning = by_time(time, np.ones(time.size, dtype=bool), 20.0)
    return Signal(time, rng.normal(size=time.size), 0.2, "K", binning, start_std=0.3)


def comparisons(seed=0):
    """Of a recording longer than two stretches, and of one that lacks a signal and some classes."""
    rng = np.random.default_rng(seed)
    discrepancy = Discrepancy(scatter={("a", "steady", 1): 1.7})
    recordings = [{"a": fast(rng, 40, 2.5 * STRETCH), "b": fast(rng, 25, 1.5 * STRETCH), "temperature/x": slow(rng, 300.0)},
                  {"a": fast(rng, 12, 0.8 * STRETCH), "temperature/x": slow(rng, 90.0)}]
    return [Comparison(signals, {name: np.zeros(s.time.size) for name, s in signals.items()}, discrepancy) for signals in recordings]


def dense_allowances(made):
    """A of weights (I + A A')^-1, (rows, allowances), column by column from the comparisons' definition."""
    columns: dict[tuple, np.ndarray] = {}
    total = sum(c.size for c in made)
    first = 0
    for number, comparison in enumerate(made):
        for block in comparison.blocks:
            rows = first + np.arange(block.rows.start, block.rows.stop)
            if block.curves is not None:
                for i, curve in enumerate(block.curves.T):
                    columns.setdefault((number, block.signal, i), np.zeros(total))[rows] = curve
                continue
            for row, kind, load, time in zip(rows, block.kind, block.load, block.binning.time, strict=True):
                columns.setdefault(block.names[kind], np.zeros(total))[row] = load
                columns.setdefault((number, block.names[kind], int(time / STRETCH)), np.zeros(total))[row] = VARIANT * load
        first += comparison.size
    return np.column_stack(list(columns.values()))


def split(made, rows):
    """Stacked rows by recording."""
    return np.split(rows, np.cumsum([c.size for c in made])[:-1])
