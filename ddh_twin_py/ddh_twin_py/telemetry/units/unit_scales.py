"""What a rig's file tells of the size of readings: the load on the piston's areas, torque and copper loss per current, full scales."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.physics.cylinder import load_force, piston_area, rod_side_area
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording


@dataclass(frozen=True)
class UnitScales:
    """`piston_area`, `rod_side_area` in m2; `load`, N, against extension at mid stroke; `phase_resistance`, ohm, at 20 degC;
    `torque_constant`, N*m/A; `rated_torque`, N*m; `current_limit` of the drive, A;
    `full_scale` of sensors that tell one, by the keys of the sheet, SI (temperatures K)."""

    piston_area: float
    rod_side_area: float
    load: float
    phase_resistance: float
    torque_constant: float
    rated_torque: float
    current_limit: float
    full_scale: Mapping[str, float] = field(default_factory=dict)

    def force(self, piston_side: np.ndarray | float, rod_side: np.ndarray | float) -> np.ndarray | float:
        """N, against the load, of the pressures of both sides, Pa."""
        return piston_side * self.piston_area - rod_side * self.rod_side_area

    @classmethod
    def of(cls, rig: Rig, recording: Recording | None = None) -> UnitScales:
        """Of a rig, with the payload that a recording declares where there is one."""
        declared = recording.rig.payload_mass if recording is not None and recording.rig is not None else None
        record = rig.declaring(declared).parameters[0]
        return cls(float(piston_area(record)), float(rod_side_area(record)), float(load_force(0.5 * rig["cylinder.stroke"], record)),
                   float(rig["motor.phase_resistance_20C"]), float(rig["motor.torque_constant"]), float(rig["motor.rated_torque"]),
                   float(rig["motor.current_limit"]),
                   {name: spec.full_scale for name, spec in rig.sensors.items() if spec.full_scale is not None})
