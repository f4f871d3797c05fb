"""How far a free run is off, as the RMS of each signal over its noise; of a rig, on the part of recordings that no fit has seen."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import Experiment, Signal
from ddh_twin_py.rig import Rig


def rms_over_noise(experiments: Sequence[Experiment], predictions: Sequence[Mapping[str, np.ndarray]],
                   counts: Callable[[Experiment, Signal], np.ndarray]) -> dict[str, tuple[float, int]]:
    """RMS of each signal over the noise of one sample, and how many samples that is, all recordings together.

    Signals without a sample are left out.

    Args:
        predictions: of each recording, signal to values (n,). counts: which samples of a signal count, (n,).
    """
    squares: dict[str, list[np.ndarray]] = {}
    for experiment, predicted in zip(experiments, predictions, strict=True):
        for name, signal in experiment.signals.items():
            off = ((signal.measured - predicted[name]) / signal.noise)[counts(experiment, signal)]
            squares.setdefault(name, []).append(off[np.isfinite(off)] ** 2)
    joined = {name: np.concatenate(parts) for name, parts in squares.items()}
    return {name: (float(np.sqrt(square.mean())), square.size) for name, square in joined.items() if square.size}


def held_out(experiments: Sequence[Experiment], rig: Rig) -> dict[str, tuple[float, int]]:
    """`rms_over_noise` of the part that is held out, from `Experiment.held_from` on.

    Each run starts at the begin of its recording, as the fit's did, and is not put right by what was
    measured but at standstills (see `experiment`); where too little is read to say how it began, its first minutes tell.

    Args:
        rig: the fitted rig.
    """
    predictions = [experiment.predict(experiment.parameters(rig), begin=None) for experiment in experiments]
    return rms_over_noise(experiments, predictions, lambda _, signal: signal.held_back)
