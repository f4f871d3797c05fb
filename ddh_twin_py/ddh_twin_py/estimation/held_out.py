"""How far a rig's free run is off on the part of recordings that no fit has seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_twin_py.estimation.experiment import Experiment
from ddh_twin_py.rig import Rig


def held_out(experiments: Sequence[Experiment], rig: Rig) -> dict[str, tuple[float, int]]:
    """RMS of each signal over the noise of one sample, and how many samples that is, all recordings together.

    Each run starts at the begin of its recording, as the fit's did, and is not put right by what was
    measured but at standstills (see `experiment`). Signals without a sample there are left out.

    Args:
        experiments: recordings of which `Experiment.used_until` says what a fit saw. rig: the fitted rig.
    """
    squares: dict[str, list[np.ndarray]] = {}
    for experiment in experiments:
        predicted = experiment.predict(experiment.parameters(rig))
        for name, signal in experiment.signals.items():
            off = ((signal.measured - predicted[name]) / signal.noise)[signal.time > experiment.used_until]
            squares.setdefault(name, []).append(off[np.isfinite(off)] ** 2)
    joined = {name: np.concatenate(parts) for name, parts in squares.items()}
    return {name: (float(np.sqrt(square.mean())), square.size) for name, square in joined.items() if square.size}
