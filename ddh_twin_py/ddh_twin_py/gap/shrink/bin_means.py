"""Means of kinematic signals over steady stretches: what one sample's noise hides, the mean of many does not.

A signal that merely follows a command or the geometry, as a speed does or a rod's velocity, is off by nothing but its noise on
a sound rig, even in such means. Pressures are not: laws err in them by more. Over single samples a drive that gives way under
load by half its speed's noise is one tenth above the floor; over means of forty it is three times above it.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fitting.binning import PHASES, STEADY
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.model import DescribedModel
from ddh_twin_py.gap.shrink.held_runs import recorded

AT_NOISE = 1.25
"""Noises of a mean over a steady stretch within which a commissioning recording shows a signal at its noise."""
_FEWEST = 30  # bins of a signal that tell
_LARGEST = 0.02  # share of the bins that are left out, the largest: a few broken readings are no cause
_STEADY = [PHASES.index(phase) for phase in STEADY]


def beyond_noise(model: DescribedModel, fitted: Refitted) -> dict[str, float]:
    """RMS of a kinematic signal's means over steady stretches of recordings in which effects act, beside a fit, in noises of such means.

    Only of signals that the other recordings show at their noise (`AT_NOISE`) beside the same fit; empty where there are none.
    """
    built, since = (_pooled(model, fitted, acts) for acts in (False, True))
    return {name: off for name, off in since.items() if built.get(name, np.inf) <= AT_NOISE and np.isfinite(off)}


def _pooled(model: DescribedModel, fitted: Refitted, acts: bool) -> dict[str, float]:
    squares: dict[str, list[np.ndarray]] = {}
    for signals, prediction in recorded(model, fitted.predictions, acts):
        for name in (name for name in model.kinematic if name in signals):
            squares.setdefault(name, []).append(_squares(signals[name], prediction[name]))
    pooled = {name: np.sort(np.concatenate(values)) for name, values in squares.items()}
    return {name: float(np.sqrt(values[: values.size - int(_LARGEST * values.size)].mean()))
            for name, values in pooled.items() if values.size >= _FEWEST}


def _squares(signal, prediction: np.ndarray) -> np.ndarray:
    """Squared means over steady stretches, in squared noises of a mean, (b,)."""
    binning = signal.binning
    off = binning.mean(np.where(np.isfinite(signal.measured), signal.measured - prediction, 0.0)) / signal.noise
    told = np.isin(binning.phase, _STEADY)
    if signal.follows is not None:
        told &= binning.mean(signal.follows.astype(float)) == 1.0
    return (binning.count * off**2)[told]
