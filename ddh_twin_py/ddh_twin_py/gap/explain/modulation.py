"""Forms that what moves one signal may take over a recording, of which no law is asked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ddh_twin_py.estimation.fitting.binning import PHASES
from ddh_twin_py.estimation.fitting.comparison import Block

_DEGREES = 4  # of a temperature's slow curve: constant to cubic


def modulations(block: Block, variables: Mapping[str, np.ndarray],
                phases: Sequence[str] = PHASES) -> tuple[list[tuple[str, str]], np.ndarray]:
    """Forms of one signal: by phase, growing with the oil's warmth and with speed; of a temperature slow curves.

    A signal none of whose bins lies in a phase, as of a rig that has no cycle, has its forms over the whole recording.

    Args:
        block: of the signal, b bins. variables: on what it may depend, name to values at all bins of the recording, (rows,).
        phases: of the cycle that have forms of their own.

    Returns:
        (phase, variable) of each form; values within about -1 to 1, (b, m).
    """
    time = block.binning.time
    if block.curves is not None:
        span = max(float(time[-1] - time[0]), 1.0) if time.size else 1.0
        place = 2.0 * (time - time[0]) / span - 1.0 if time.size else time
        return ([("all", "time" if degree else "phase") for degree in range(_DEGREES)],
                np.column_stack([np.polynomial.legendre.legval(place, [0.0] * degree + [1.0]) for degree in range(_DEGREES)]))
    grown = {key: centred(values[block.rows]) for key, values in variables.items()}
    without_phases = bool(time.size) and not np.any(block.binning.phase >= 0)
    if block.per_stroke or without_phases:
        kept = {key: values for key, values in grown.items() if without_phases or key == "oil temperature"}
        return [("all", "phase"), *(("all", key) for key in kept)], np.column_stack([np.ones(time.size), *kept.values()])
    kinds, forms = [], []
    for phase in phases:
        here = (block.binning.phase == PHASES.index(phase)).astype(float)
        kinds += [(phase, "phase"), *((phase, key) for key in grown)]
        forms += [here, *(here * values for values in grown.values())]
    return kinds, np.column_stack(forms)


def centred(values: np.ndarray) -> np.ndarray:
    """Values brought to mean 0 and largest size 1."""
    around = values - values.mean()
    return around / max(float(np.abs(around).max(initial=0.0)), 1e-9)
