"""The first-order rig with readings that err, linearised, and its places by what their free inputs explain."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.locate.free_places import free_places


def misread(model, name, error):
    """Let one reading of the second recording err by a function of the share of its time that is over."""
    signal = model.signals[1][name]
    model.signals[1] = {**model.signals[1], name: replace(signal, measured=signal.measured + error(signal.time / signal.time[-1]))}


def linearised_with(model, effects):
    with ThreadPoolExecutor(2) as pool:
        return linearise(Question(model, effects), np.zeros(3), pool)


def places_in(linearised, off=""):
    variables = [{"flow rate": np.concatenate([np.abs(c.features(p)[b.rows]) for b in c.blocks])}
                 for c, p in zip(linearised.comparisons, linearised.predictions, strict=True)]
    return free_places(linearised, linearised.columns, variables, lambda signal: (f"{signal} meter", "measurement"), off)
