"""A duty as the twin itself would do it: a recording of a rig that is exactly as a rig file says.

What a test would tell can be asked before it is made. The sensors' zeros are right; their noise
is the sheet's.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import lfilter

from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording, RigInfo, Stream, drive_stream, hydraulic_stream, temperature_stream
from ddh_twin_py.telemetry.signals import HYDRAULIC_FIELDS
from ddh_twin_py.twin.cycle import DutyRun
from ddh_twin_py.twin.duty import Duty, DutyError, check_duration, check_for_rig
from ddh_twin_py.twin.temperature_sensors import SENSORS, sensed

PERIOD = 0.02
"""s between two samples of drive and pressures."""
TEMPERATURE_PERIOD = 1.0
"""s between two samples of a temperature sensor."""
_DRIVE = ("speed", "torque", "current", "voltage", "electrical_power")


def rehearse(rig: Rig, duty: Duty, duration: float | None = None, sensors: Sequence[str] = SENSORS, pressures: bool = True,
             start: np.ndarray | None = None, name: str = "rehearsal") -> Recording:
    """Do a duty with a rig's own model and record it.

    Args:
        rig: taken as it is. duty: see `duty.Duty`; its payload is the declared and the true one.
        duration: s; None: as often as the duty says. sensors: temperature sensors that there are, beside ambient.
        pressures: whether there are pressure transducers. start: temperatures of all nodes, K, (N,); None: ambient.
        name: of the recording.

    Raises:
        DutyError: a duty that goes on for ever without a duration, one of no s, or one that is not within the rig's stroke.
    """
    check_for_rig(duty, rig)
    check_duration(duration, "rehearsal")
    if duration is None and duty.repeat == 0:
        raise DutyError(f"{duty.file}: repeat is 0, for ever; a duration is needed")
    loaded = rig.declaring(duty.payload)
    air = float(np.interp(0.0, duty.ambient_time, duty.ambient))
    run = DutyRun(loaded, duty, air if start is None else start, air, period=PERIOD)
    first = run.temperature[None, :].copy()
    points, commands, temperatures, done, longest = [], [], [first], 0, np.inf if duration is None else duration
    while run.time < longest - 0.5 * PERIOD and (duty.repeat == 0 or done < duty.repeat):
        run.ambient = float(np.interp(run.time, duty.ambient_time, duty.ambient))
        cycle = run.cycle(longest=min(longest - run.time, 3600.0), keep=True)
        points.append(cycle.points)
        commands.append(cycle.commands)
        temperatures.append(cycle.temperatures)
        done += 1
    course, command, temperature = np.concatenate(points), np.concatenate(commands), np.concatenate(temperatures)
    return _recording(loaded, duty, course, command, temperature, sensors, pressures, name)


def _recording(rig: Rig, duty: Duty, points: np.ndarray, commands: np.ndarray, temperatures: np.ndarray, sensors: Sequence[str],
               pressures: bool, name: str) -> Recording:
    rng = np.random.default_rng(0)
    noise = {key: spec.noise for key, spec in rig.sensors.items()}
    n = points.size
    edges = PERIOD * np.arange(1, n + 1)
    middle = edges - 0.5 * PERIOD

    def at_edges(field: str) -> np.ndarray:
        return np.interp(edges, middle, points[field])

    drive = np.column_stack([commands, *(at_edges(field) for field in _DRIVE)])
    current = rng.normal(0.0, noise["current"], n)
    drive[:, 1] += rng.normal(0.0, noise["speed"], n)
    drive[:, 2] = rig["motor.torque_constant"] * (drive[:, 3] + current)
    drive[:, 3] += current
    drive[:, 4] += rng.normal(0.0, noise["voltage"], n)
    drive[:, 5] += rng.normal(0.0, noise["electrical_power"], n)
    hydraulic = np.column_stack([at_edges(field) for field in HYDRAULIC_FIELDS])
    for j, key in enumerate(("pressure", "pressure", "rod_position", "rod_velocity")):
        hydraulic[:, j] += rng.normal(0.0, noise[key], n)
    if not pressures:
        hydraulic[:, :2] = np.nan
    told = RigInfo(rig.rig_id, rig.oil_grade, duty.payload)
    return Recording(name, 0, told, drive_stream(edges, drive), hydraulic_stream(edges, hydraulic),
                     _temperatures(rig, duty, temperatures, sensors, rng))


def _temperatures(rig: Rig, duty: Duty, temperatures: np.ndarray, sensors: Sequence[str], rng) -> dict[str, Stream]:
    """Readings of ambient and of each sensor, behind by its lag."""
    if temperatures.shape[1] != N:
        raise ValueError(f"temperatures have shape {temperatures.shape}, (n, {N}) is needed")
    keep = np.exp(-PERIOD / rig["sensors.temperature.time_constant"])
    noise, every = rig.sensors["temperature"].noise, round(TEMPERATURE_PERIOD / PERIOD)
    time = PERIOD * np.arange(0, temperatures.shape[0], every)
    out = {"ambient": np.interp(time, duty.ambient_time, duty.ambient)}
    for name in sensors:
        node = sensed(temperatures, name, rig["tank.top_share"])
        reading, _ = lfilter([1.0 - keep], [1.0, -keep], node, zi=[keep * node[0]])
        out[name] = reading[::every]
    return {name: temperature_stream(time + 1.0e-3 * (i + 1), value + rng.normal(0.0, noise, value.size))
            for i, (name, value) in enumerate(out.items())}
