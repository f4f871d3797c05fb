"""What a rig file knows of its sensors' zero errors, taken off what they read.

A calibration writes them as ``measurement.*``; a rig file without these entries changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_twin_py.rig import Rig


def take_off_zero_errors(measured: np.ndarray, rig: Rig) -> None:
    """Correct the pressures of interval means, in place: p = (reading - offset) / gain.

    Args:
        measured: `MEASURED_DTYPE`, (n,). rig: has ``measurement.pressure_*_offset``, Pa.
    """
    measured["pressure_piston_side"] -= rig["measurement.pressure_piston_side_offset"]
    measured["pressure_rod_side"] -= rig["measurement.pressure_rod_side_offset"]
    measured["pressure_rod_side"] /= rig["measurement.pressure_rod_side_gain"]


def temperature_zero_errors(rig: Rig, sensors: Sequence[str]) -> np.ndarray:
    """Mean zero error of temperature sensors, K, in that order."""
    return np.array([rig.zero_error(sensor)[0] for sensor in sensors])
