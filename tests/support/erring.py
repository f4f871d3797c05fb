"""A recording as sensors with known errors would have made it."""

from dataclasses import replace

from ddh_twin_py.telemetry.recording import Recording

ERRORS = {"measurement.current_gain": 1.25, "measurement.rod_position_scale": 0.8, "measurement.time_skew": 0.1}
"""Dotted path of the sheet to value; gains 1 and s."""


def erring(recording: Recording) -> Recording:
    """The recording with `ERRORS` in its readings."""
    drive, hydraulic = recording.drive, recording.hydraulic
    values = drive.values.copy()
    for name in ("current", "torque", "electrical_power"):
        values[:, drive.fields.index(name)] *= ERRORS["measurement.current_gain"]
    moved = hydraulic.values.copy()
    for name in ("rod_position", "rod_velocity"):
        moved[:, hydraulic.fields.index(name)] *= ERRORS["measurement.rod_position_scale"]
    return replace(
        recording, drive=replace(drive, values=values),
        hydraulic=replace(hydraulic, values=moved, time=hydraulic.time + ERRORS["measurement.time_skew"]),
    )
