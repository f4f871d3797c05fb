"""What a rig file knows of how its sensors err, taken off what they read before it is compared with the model.

A calibration writes it as ``measurement.*``; a rig file without these entries changes nothing. How
surface sensors lag and how far they read the air (``measurement.surface_*``) is not taken off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.signals import HYDRAULIC_TOPIC


def delay_ns(rig: Rig, topic: str) -> int:
    """ns by which samples of a telemetry topic are stamped later than those of the drive for the same instant."""
    return round(1e9 * rig["measurement.time_skew"]) if topic == HYDRAULIC_TOPIC else 0


def take_off_delay(recording: Recording, rig: Rig) -> Recording:
    """The recording with the stamps that its hydraulic samples should have; itself where there is no delay."""
    delay = delay_ns(rig, HYDRAULIC_TOPIC)
    if delay == 0 or recording.hydraulic is None:
        return recording
    return replace(recording, hydraulic=replace(recording.hydraulic, time=recording.hydraulic.time - 1e-9 * delay))


def take_off_sensor_errors(measured: np.ndarray, rig: Rig) -> None:
    """Correct interval means, in place: value = (reading - offset) / gain.

    Args:
        measured: `MEASURED_DTYPE`, (n,). rig: has ``measurement.pressure_*_offset`` in Pa; its gains are of the
            rod-side pressure, of position and velocity, and of the current and with it torque and power.
    """
    measured["pressure_piston_side"] -= rig["measurement.pressure_piston_side_offset"]
    measured["pressure_rod_side"] -= rig["measurement.pressure_rod_side_offset"]
    measured["pressure_rod_side"] /= rig["measurement.pressure_rod_side_gain"]
    for name in ("rod_position", "rod_velocity"):
        measured[name] /= rig["measurement.rod_position_scale"]
    gain = rig["measurement.current_gain"]
    for name in ("current", "torque", "electrical_power"):
        measured[name] /= gain
    measured["current_square"] /= gain * gain


def temperature_zero_errors(rig: Rig, sensors: Sequence[str]) -> np.ndarray:
    """Mean zero error of temperature sensors, K, in that order."""
    return np.array([rig.zero_error(sensor)[0] for sensor in sensors])
