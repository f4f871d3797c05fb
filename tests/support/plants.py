"""A rig of the independent plant on the paper's cycle."""

import math

import numpy as np
from ddh_twin_py.plant import heat
from ddh_twin_py.plant.machine import Course, Exercise, Machine
from ddh_twin_py.plant.sensors import SENSORS, Instruments

RPM = math.pi / 30.0


def exercise(duration: float = 120.0, payload: float = 149.5, rpm: float = 500.0, ambient: float = 296.15) -> Exercise:
    """Lift, rest, lower, rest from 0.02 to 0.36 m, begun at ambient."""
    program = np.array([(rpm * RPM, 0.36, 3.0), (-rpm * RPM, 0.02, 3.0)] * int(duration))
    air = np.full(int(duration) + 2, ambient)
    return Exercise(program, 1150.0 * RPM, duration, air, payload, 0.02, np.full(heat.N, ambient))


def times(duration: float, rate: float = 50.0) -> np.ndarray:
    return np.arange(0.5, duration - 0.5, 1.0 / rate)


def course(machine: Machine, what: Exercise, faults=(), same_commands: Course | None = None) -> Course:
    when = times(what.duration)
    return machine.run(what, list(faults), when, when, same_commands)


def quiet(sheet) -> Instruments:
    """Sensors without zero errors, with the sheet's lag and noise."""
    lag = sheet["sensors.temperature.time_constant"]
    return Instruments(dict.fromkeys(SENSORS, 0.0), dict.fromkeys(SENSORS, lag), (0.0, 0.0), sheet["motor.torque_constant"],
                       {kind: spec.noise for kind, spec in sheet.sensors.items()})
