"""Readings of the plant as recordings, for the bag writer."""

from __future__ import annotations

from ddh_twin_py.plant.sensors import Readings
from ddh_twin_py.rig import OIL_GRADE
from ddh_twin_py.telemetry.recording import Recording, RigInfo, drive_stream, hydraulic_stream, temperature_stream


def recording_of(readings: Readings, rig_id: str, payload: float, epoch_ns: int) -> Recording:
    """A recording of a rig with its declared payload, kg, begun at a time in ns."""
    return Recording(
        path=rig_id, epoch_ns=epoch_ns, rig=RigInfo(rig_id, OIL_GRADE, payload), drive=drive_stream(*readings.drive),
        hydraulic=hydraulic_stream(*readings.hydraulic),
        temperatures={name: temperature_stream(time, kelvin) for name, (time, kelvin) in readings.temperatures.items()},
    )
