"""Relative force error of an inverse model, with the preprocessing of the benchmark's authors.

The position is filtered forwards and backwards (Butterworth, order 4, 100 Hz) and differentiated centrally twice; the first 49 samples
are dropped; forces are decimated by 10. Janot, Gautier, Brunot 2019, and the scripts that come with the set.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, decimate, filtfilt

from ddh_twin_py.real_rigs.emps.model import friction
from ddh_twin_py.real_rigs.emps.recordings import STEP, EmpsRecord

_CUT, _ORDER, _BORDER, _EVERY = 100.0, 4, 49, 10


@dataclass(frozen=True)
class Motion:
    """Filtered motion of a record and the force that the motor was told to give: m, m/s, m/s2, N, (n,) each."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray


def motion_of(record: EmpsRecord) -> Motion:
    """The motion of a record."""
    b, a = butter(_ORDER, 2.0 * STEP * _CUT)
    position = filtfilt(b, a, record.position)
    velocity = np.gradient(position, STEP)
    return Motion(*(x[_BORDER:] for x in (position, velocity, np.gradient(velocity, STEP), record.force)))


def force_error(motion: Motion, record: np.ndarray) -> np.ndarray:
    """Decimated force less what a model's parameters (1,) say that the motion needs, N; delay and transmission are left out of it."""
    p = record[0]
    needed = (p["mass"] + p["payload"]) * motion.acceleration + friction(record, motion.position, motion.velocity)
    return _decimated(motion.force) - _decimated(needed / p["force_gain"])


def relative(error: np.ndarray, motion: Motion) -> float:
    """Norm of an error over that of the decimated force, %."""
    return 100.0 * float(np.linalg.norm(error) / np.linalg.norm(_decimated(motion.force)))


def least_squares(motion: Motion, direction: bool) -> np.ndarray:
    """Coefficients of the authors' inverse model: mass, viscous, Coulomb, offset; or with ``direction`` mass, and both of each way."""
    x = _columns(motion, direction)
    return np.linalg.lstsq(x, _decimated(motion.force), rcond=None)[0]


def least_squares_error(motion: Motion, coefficients: np.ndarray, direction: bool) -> np.ndarray:
    """Decimated force less that of the authors' inverse model, N."""
    return _decimated(motion.force) - _columns(motion, direction) @ coefficients


def _columns(motion: Motion, direction: bool) -> np.ndarray:
    sign, v = np.sign(motion.velocity), motion.velocity
    forward, backward = (1.0 + sign) / 2.0, (1.0 - sign) / 2.0
    if direction:
        columns = (motion.acceleration, v * forward, sign * forward, v * backward, sign * backward)
    else:
        columns = (motion.acceleration, v, sign, np.ones(v.size))
    return np.column_stack([_decimated(column) for column in columns])


def _decimated(values: np.ndarray) -> np.ndarray:
    return decimate(values, _EVERY, zero_phase=True)
