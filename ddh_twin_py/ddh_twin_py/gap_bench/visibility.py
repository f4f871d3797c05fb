"""How well an effect is seen on a duty: against the sensors' noise, and against what the sheet's tolerances can feign."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.gap_bench.duties import Duty
from ddh_twin_py.plant.fault import Fault
from ddh_twin_py.plant.machine import Course, Machine
from ddh_twin_py.plant.sensors import Instruments, ideal
from ddh_twin_py.rig import Rig

_SETTLING = 5.0  # s
_EXACT = 0.5  # of a sample's noise: how exactly a mean is known, flaws of any model included
_MOVING = 0.002  # m/s
_UNSEEN = ("temperature/motor_winding", "temperature/ambient", "torque", "speed_command", "rod_position")


@dataclass(frozen=True)
class Scene:
    """A machine on a duty without effects: the commands that all others follow, and its readings.

    Attributes:
        sensors: temperature sensors that exist. when: s, of the temperatures that are compared.
    """

    machine: Machine
    instruments: Instruments
    duty: Duty
    sensors: tuple[str, ...]
    when: np.ndarray
    course: Course
    readings: Mapping[str, np.ndarray]

    def readings_with(self, faults: Sequence[tuple[Fault, float]], machine: Machine | None = None) -> dict[str, np.ndarray]:
        """Readings of the same commands with faults, or of another machine; without noise."""
        course = (machine or self.machine).run(self.duty.exercise, faults, self.duty.drive_time, self.duty.hydraulic_time, self.course)
        return self._read(course)

    def _read(self, course: Course) -> dict[str, np.ndarray]:
        out = ideal(course, self.instruments, self.duty.exercise.ambient, self.when)
        skew = float(course.condition["skew"][0])
        if skew:
            for name in ("pressure_piston_side", "pressure_rod_side", "rod_velocity"):
                out[name] = np.interp(self.duty.hydraulic_time, self.duty.hydraulic_time + skew, out[name])
        return out

    def strokes(self, readings: Mapping[str, np.ndarray]) -> np.ndarray:
        """Length of each stroke as read, m."""
        begun = self.course.start.size
        brake = self.course.brake[np.isfinite(self.course.brake)]
        program = self.duty.exercise.program
        ended = brake + np.abs(program[: brake.size, 0]) / self.duty.exercise.ramp
        into = np.minimum(0.4, 0.5 * program[: brake.size, 2])
        begins = np.concatenate([[2.9], (ended + program[: brake.size, 2])[:-1] - 0.05])[:begun]
        at = self.duty.hydraulic_time
        position = readings["rod_position"]
        usable = ended + into < at[-1]
        return np.interp((ended + into)[usable], at, position) - np.interp(begins[usable], at, position)


def scene(machine: Machine, instruments: Instruments, duty: Duty, sensors: Sequence[str]) -> Scene:
    """Run a machine without effects."""
    course = machine.run(duty.exercise, [], duty.drive_time, duty.hydraulic_time)
    when = np.arange(10.0, duty.exercise.duration - 5.0, 5.0)
    empty = Scene(machine, instruments, duty, tuple(sensors), when, course, {})
    return Scene(machine, instruments, duty, tuple(sensors), when, course, empty._read(course))


def rises(view: Scene, other: Mapping[str, np.ndarray]) -> dict[str, float]:
    """RMS of the difference over the noise, per signal that is recorded; strokes as ``rod_position``."""
    noise = view.instruments.noise
    out = {}
    for name, values in view.readings.items():
        if name in _UNSEEN or (name.startswith("temperature/") and name.split("/")[1] not in view.sensors):
            continue
        difference = other[name] - values
        if not name.startswith("temperature/"):
            time = view.duty.drive_time if values.size == view.duty.drive_time.size and not _fluid(name) else view.duty.hydraulic_time
            difference = difference[time > _SETTLING]
        out[name] = float(np.sqrt(np.mean(difference**2))) / noise[_kind(name)]
    strokes = view.strokes(other) - view.strokes(view.readings)
    if strokes.size:
        out["rod_position"] = float(np.sqrt(np.mean(strokes**2))) / noise["rod_position"]
    return out


def _fluid(name: str) -> bool:
    return name.startswith(("pressure_", "rod_"))


def _kind(name: str) -> str:
    return "pressure" if name.startswith("pressure_") else name.split("/")[0]


def features(view: Scene, readings: Mapping[str, np.ndarray]) -> np.ndarray:
    """Means that a recording gives, over `_EXACT` of the noise: fast signals by phase, temperatures by thirds, strokes."""
    noise = view.instruments.noise
    velocity = view.readings["rod_velocity"]
    at_drive = np.interp(view.duty.drive_time, view.duty.hydraulic_time, velocity)
    parts = []
    for name, values in readings.items():
        if name in _UNSEEN or (name.startswith("temperature/") and name.split("/")[1] not in view.sensors):
            continue
        if name.startswith("temperature/"):
            means = [float(np.mean(third)) for third in np.array_split(values, 3)]
        else:
            speed = velocity if _fluid(name) else at_drive
            masks = (speed > _MOVING, speed < -_MOVING, np.abs(speed) <= _MOVING)
            means = [float(np.mean(values[mask])) if mask.any() else 0.0 for mask in masks]
        parts += [mean / (_EXACT * noise[_kind(name)]) for mean in means]
    strokes = view.strokes(readings)
    parts += [float(np.mean(s)) / (_EXACT * noise["rod_position"]) if s.size else 0.0 for s in (strokes[::2], strokes[1::2])]
    return np.array(parts)


class Feigned:
    """What machines within the sheet's tolerances can look like on a duty.

    The response to one standard deviation of each toleranced quantity, taken at the scene's machine, and the zeros of the
    sensors: together the covariance of `features`, noise included.
    """

    def __init__(self, sheet: Rig, view: Scene) -> None:
        base = features(view, view.readings)
        columns = []
        for path, quantity in sheet.quantities.items():
            deviation = quantity.standard_deviation
            if deviation <= 0.0 or path.startswith(("sensors.", "motor.speed_loop", "cylinder.stribeck", "motor.inertia")):
                continue
            if path == "load.payload_mass":
                other = Machine(view.machine.rig, view.machine.payload_ratio * (1.0 + quantity.tolerance))
            else:
                built = view.machine.rig.built_as({path: view.machine.rig[path] + deviation}, "feigned")
                other = Machine(built, view.machine.payload_ratio)
            columns.append(features(view, view.readings_with([], other)) - base)
        for name in view.readings:
            zero = sheet.sensors["pressure" if name.startswith("pressure_") else "temperature"].offset_tolerance
            if name.startswith(("pressure_", "temperature/")) and name not in _UNSEEN:
                shifted = dict(view.readings)
                shifted[name] = shifted[name] + zero
                columns.append(features(view, shifted) - base)
        response = np.array(columns).T
        self._base = base
        self._covariance = response @ response.T + np.eye(base.size)

    def distance(self, view: Scene, readings: Mapping[str, np.ndarray]) -> float:
        """Standard deviations between readings and everything that the tolerances can feign."""
        away = features(view, readings) - self._base
        return float(np.sqrt(away @ np.linalg.solve(self._covariance, away)))
