"""How a recording began where too little is read to say it, from what its first minutes show.

Oil of which no sensor reads the warmth is read by pressures and currents, through its viscosity, as soon as the rod moves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ddh_twin_py.rig.sheet import CUT

FIRST = 120.0
"""s of a recording that say how it began; no more than the first `SHARE` of it."""
SHARE = 0.25
_DIFFERENCE = 0.05  # deviations
_STEPS, _SETTLED = 3, 0.01  # Gauss-Newton steps at most; deviations that one must move
_WEIGHT = 10.0  # independent samples that a signal counts for, as laws are a little wrong alike in all of them
_ASTRAY = 1.0e6  # multiples of noise from which a run went astray


def told_begin(signals: Mapping, until: float, ways: int, predict: Callable[[np.ndarray], Mapping[str, np.ndarray]]) -> np.ndarray:
    """Standard deviations of each way in which a recording may begin otherwise than is likely, (ways,), at their most probable.

    Args:
        signals: name to signal with ``time``, ``measured``, ``noise``, ``binning``. until: s, what is sampled later does not count.
        predict: what all samples up to then should have read, given such deviations, (ways,).
    """
    used = {name: np.flatnonzero((s.binning.bin >= 0) & (s.time <= until)) for name, s in signals.items()}
    used = {name: index for name, index in used.items() if index.size}
    if not ways or not used:
        return np.zeros(ways)

    def off(z: np.ndarray) -> np.ndarray:
        predicted = predict(z)
        return np.concatenate([np.sqrt(_WEIGHT / i.size) * (signals[n].measured[i] - predicted[n][i]) / signals[n].noise
                               for n, i in used.items()])

    z, at = np.zeros(ways), off(np.zeros(ways))
    for _ in range(_STEPS):
        slope = np.column_stack([(off(z + _DIFFERENCE * way) - at) / _DIFFERENCE for way in np.eye(ways)])
        if not (np.abs(at) < _ASTRAY).all() or not (np.abs(slope) < _ASTRAY).all():
            return z
        step = np.linalg.solve(slope.T @ slope + np.eye(ways), -slope.T @ at - z)
        moved = np.clip(z + step, -CUT, CUT)
        there = off(moved)
        if not there @ there + moved @ moved < at @ at + z @ z:
            return z
        z, at, step = moved, there, moved - z
        if np.abs(step).max() < _SETTLED:
            break
    return z
