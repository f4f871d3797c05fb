"""How fine the steps of a recording's free runs must be: steep ramps make the oil springs ring."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ddh_twin_py.estimation.fitting.binning import PHASES

_FINER = (2, 4)
_FINEST = 8
_ERROR = 0.35  # noises of a sample by which a run may err by its step
_BETTER = 0.6  # of the error, below which finer steps are worth their time: what sticks by chance does so at any step


def times_finer(signals: Mapping[str, object], run: Callable[[int], Mapping[str, np.ndarray]]) -> int:
    """Fewest times that steps must be finer than asked for errors within `_ERROR` of each fast signal's noise: 1, 2 or 4.

    Args:
        signals: of `experiment.Signal`, by name. run: predictions, by name, with steps so many times finer.
    """
    runs = {1: run(1)}

    def error(finer: int, than: int) -> float:
        for times in (finer, than):
            if times not in runs:
                runs[times] = run(times)
        return max((_off(signal, runs[finer][name] - runs[than][name]) for name, signal in signals.items()), default=0.0)

    if error(1, _FINER[-1]) <= _ERROR:
        return 1
    errors = {finer: error(finer, _FINEST) for finer in (1, *_FINER)}
    enough = [finer for finer in errors if errors[finer] <= _ERROR]
    best = min(enough) if enough else min(errors, key=errors.get)
    return best if errors[best] <= _BETTER * errors[1] else 1


def _off(signal, difference: np.ndarray) -> float:
    """RMS of a difference over the samples that count, in noises of one sample; 0 of a signal without phases."""
    if not np.any((signal.binning.phase >= 0) & (signal.binning.phase < len(PHASES))):
        return 0.0
    used = difference[(signal.binning.bin >= 0) & np.isfinite(signal.measured)]
    return float(np.sqrt(np.mean(used**2))) / signal.noise if used.size else 0.0
