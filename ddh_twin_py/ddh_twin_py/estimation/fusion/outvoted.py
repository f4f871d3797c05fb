"""A sensor that all others beside the oil contradict: at a start any one of them may be wrong, and most of them are not."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.sensors import SENSORS

OUTVOTED = 30.0
"""K by which a sensor must be off the middle of the others to be outvoted, and half as much off each: no oil is so much warmer than all
that it flows through, nor any of that."""
HEARD = 60.0
"""s for which a reading counts beside others: a sensor that has stopped knows nothing of oil that has warmed since."""
_VOTERS = 3  # others that must be read
_ALIKE = 5.0  # K, median deviation of these from their middle: as unlike as they may be
_VOTING = np.array([not sensor.startswith("motor_") for sensor in SENSORS])


def outvoted(reading: np.ndarray) -> np.ndarray:
    """Which sensors are contradicted by all others, bool (m,).

    Args:
        reading: K, newest of each of `SENSORS`, NaN of one that was not read lately, (m,). Those of the motor have no say and are not
            judged: a winding may be far warmer than all else.
    """
    found = np.zeros(reading.size, bool)
    read = np.flatnonzero(_VOTING & np.isfinite(reading))
    if read.size <= _VOTERS or np.ptp(reading[read]) <= OUTVOTED:
        return found
    for k in read:
        others = reading[read[read != k]]
        middle = np.median(others)
        found[k] = (abs(reading[k] - middle) > OUTVOTED and np.abs(reading[k] - others).min() > 0.5 * OUTVOTED
                    and np.median(np.abs(others - middle)) <= _ALIKE)
    return found
