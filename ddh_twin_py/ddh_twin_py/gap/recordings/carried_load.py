"""What a recording's pressures say that the rod carries, held against the payload that the recording declares.

Lifting, the seal's friction adds to the load; lowering, it takes from it: their mean is the load alone. That is no measurement of a
mass, as a transducer may err, but one recording that is odd beside the others of its rig likely had another payload than it says.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ddh_twin_py.physics.cylinder import load_force, piston_area, rod_side_area
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording

_MOVING = 0.01  # m/s, a rod that moves
_LEAST = 100  # samples either way
_ODD, _ODD_SHARE = 20.0, 0.2  # kg, and share of what is declared, by which one recording is odd beside others


def carried(recording: Recording, rig: Rig) -> float:
    """Payload, kg, that would make the pressures of a recording as large as they are; NaN where too little moves or is read."""
    stream = recording.hydraulic
    if stream is None:
        return math.nan
    names = ("pressure_piston_side", "pressure_rod_side", "rod_velocity", "rod_position")
    piston, rod, velocity, position = map(stream.column, names)
    known = np.isfinite(piston) & np.isfinite(rod) & np.isfinite(position)
    ways = [known & (sign * velocity > _MOVING) for sign in (1.0, -1.0)]
    if min(int(way.sum()) for way in ways) < _LEAST:
        return math.nan
    record = rig.parameters[0]
    force = piston * float(piston_area(record)) - rod * float(rod_side_area(record))
    beyond = [float(force[way].mean() - load_force(position[way].mean(), record)) for way in ways]
    return rig["load.payload_mass"] + float(np.mean(beyond)) / (rig["load.payload_ratio"] * rig["load.gravity"])


def undeclared_loads(field: Sequence[Recording], commissioning: Sequence[Recording], validation: Sequence[Recording],
                     rig: Rig) -> list[str]:
    """One sentence for each recording beside the field's that alone carries something else than it declares.

    What the field carries otherwise than declared may be the effect, which the validation carries, too, and the commissioning does not:
    of this nothing is said then.
    """
    asked = [off for recording in field if math.isfinite(off := _off(recording, rig))]
    if not asked:
        return []
    usual, said = float(np.median(asked)), []
    for recording, built in [*((r, True) for r in commissioning), *((r, False) for r in validation)]:
        own, declared = _off(recording, rig), _declared(recording, rig)
        limit = max(_ODD, _ODD_SHARE * declared)
        if abs(own - usual) > limit and not (built and abs(usual) > 0.5 * limit):
            said.append(f"{recording.path}: by its pressures the rod carries about {declared + own:.0f} kg, but {recording.namespace}/rig "
                        f"payload_mass declares {declared:g} kg; the field recording carries {_beside(usual)} what it declares. Was this "
                        "recording made with another payload?")
    return said


def _beside(usual: float) -> str:
    """How far what is carried is from what is declared, in words."""
    return "about" if abs(usual) < 1.0 else f"{abs(usual):.0f} kg {'more' if usual > 0.0 else 'less'} than"


def _declared(recording: Recording, rig: Rig) -> float:
    """kg that the twin takes."""
    return float(rig.declaring(recording.rig.payload_mass if recording.rig is not None else None)["load.payload_mass"])


def _off(recording: Recording, rig: Rig) -> float:
    """kg carried beyond what is declared, NaN where the pressures do not tell."""
    return carried(recording, rig) - _declared(recording, rig)
