"""A sensor that all others contradict: at a start any one of them may be wrong, and most of them are not."""

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
_MOTOR = np.array([sensor.startswith("motor_") for sensor in SENSORS])
_VOTING = ~_MOTOR
COLDER = 5.0
"""K by which a motor's sensor must be colder than the air and all others to be outvoted: nothing cools a motor below all that is around it.
A winding lags behind its housing by less, as that warms."""


def colder_than_all(reading: np.ndarray, air: float) -> np.ndarray:
    """By how much each sensor of the motor is colder than the air and whatever else is read, K, (m,), 0 where it is not.

    A motor may be colder than air and oil that warm about it, so that the motor's other sensor must be read, or three others, all of which
    are as warm as the air.

    Args:
        reading: K, newest of each of `SENSORS`, NaN of one that was not read lately, (m,). air: K, NaN where nobody told it.
    """
    colder = np.zeros(reading.size)
    read = np.isfinite(reading)
    for k in np.flatnonzero(_MOTOR & read):
        beside = read & (np.arange(reading.size) != k)
        rests = np.count_nonzero(beside) >= _VOTERS and np.abs(reading[beside] - air).max() <= _ALIKE
        if np.isfinite(air) and (rests or (beside & _MOTOR).any()):
            colder[k] = max(min(air, reading[beside].min()) - reading[k], 0.0)
    return colder


def outvoted(reading: np.ndarray, air: float) -> np.ndarray:
    """Which sensors are contradicted by all others, bool (m,).

    Args:
        reading: K, newest of each of `SENSORS`, NaN of one that was not read lately, (m,). Those of the motor have no say about others
            and are outvoted only as colder than all: a winding may be far warmer.
        air: K, NaN where nobody told it.
    """
    found = colder_than_all(reading, air) > COLDER
    read = np.flatnonzero(_VOTING & np.isfinite(reading))
    if read.size <= _VOTERS or np.ptp(reading[read]) <= OUTVOTED:
        return found
    for k in read:
        others = reading[read[read != k]]
        middle = np.median(others)
        found[k] = (abs(reading[k] - middle) > OUTVOTED and np.abs(reading[k] - others).min() > 0.5 * OUTVOTED
                    and np.median(np.abs(others - middle)) <= _ALIKE)
    return found


def told_outvoted(reading: np.ndarray, air: float) -> list[str]:
    """A line of each sensor that is `outvoted`, with the reason; reading: K, (m,), air: K."""
    colder = colder_than_all(reading, air)
    why = [f"{cold:.1f} K colder than the air and all other sensors, as no motor is" if cold > COLDER else
           f"more than {OUTVOTED:g} K off what all other sensors beside the oil read" for cold in colder.tolist()]
    return [f"{SENSORS[k]}: {why[k]}, not used" for k in np.flatnonzero(outvoted(reading, air))]
