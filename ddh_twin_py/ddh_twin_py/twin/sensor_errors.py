"""What a rig file knows of how its sensors err, taken off what they read before it is compared with the model.

A calibration writes it as ``measurement.*``; a rig file without these entries changes nothing. A sensor
that touches a surface badly reads (1 - c) x + c a + z where one that touches well reads x + z; a the air around the unit.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.signals import HYDRAULIC_TOPIC
from ddh_twin_py.twin.temperature_sensors import INNER_SENSORS, SENSORS

_INNER = np.array([sensor in INNER_SENSORS for sensor in SENSORS])


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


def sensor_lags(rig: Rig) -> np.ndarray:
    """Time constant of each of `SENSORS`, s, (m,)."""
    return rig["sensors.temperature.time_constant"] * np.where(_INNER, 1.0, rig["measurement.surface_lag_ratio"])


def air_shares(rig: Rig) -> np.ndarray:
    """How far each of `SENSORS` reads the air instead of its surface, 1, (m,)."""
    return np.where(_INNER, 0.0, rig["measurement.surface_contact"])


def take_off_air(reading: np.ndarray, sensor: np.ndarray | int, air: np.ndarray | float, rig: Rig) -> np.ndarray:
    """What sensors would read if they touched their surfaces well, K, (r,); noise and zero errors are larger by 1/(1 - c) then.

    Args:
        reading: K, (r,). sensor: of each, index into `SENSORS`. air: K, that a sensor of the air reads at the time.
    """
    share = air_shares(rig)[sensor]
    return (reading - share * (air + rig["surroundings.enclosure_rise"])) / (1.0 - share)


def temperature_noise(rig: Rig) -> np.ndarray:
    """Noise of what `take_off_air` makes of a reading of each of `SENSORS`, K, (m,)."""
    return rig.sensors["temperature"].noise / (1.0 - air_shares(rig))


def temperature_zero_errors(rig: Rig) -> tuple[np.ndarray, np.ndarray]:
    """Mean zero error of what `take_off_air` makes of the readings of `SENSORS`, and its standard deviation, K, both (m,)."""
    mean, spread = np.array([rig.zero_error(sensor) for sensor in SENSORS]).T
    return mean / (1.0 - air_shares(rig)), spread / (1.0 - air_shares(rig))
