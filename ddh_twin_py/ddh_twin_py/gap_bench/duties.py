"""Duties and surroundings of the sealed cases: lift, dwell, lower, dwell, all of it drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.plant import heat
from ddh_twin_py.plant.machine import Exercise

RPM = math.pi / 30.0
_SLOWEST, _FASTEST = 200.0, 1500.0
_ROD_PER_RAD = 22.8e-6 / (2.0 * math.pi) / (math.pi / 4.0 * 0.06**2)  # m, of the sheet's pump 1 and bore
_MOTOR = heat.NODES[:7]
_WARM_PUMPS = heat.NODES[7:13]
_LINES = heat.NODES[13:19]


@dataclass(frozen=True)
class Duty:
    """An exercise and how it is recorded: instants of both fast streams, s."""

    exercise: Exercise
    drive_time: np.ndarray
    hydraulic_time: np.ndarray

    def shortened(self, duration: float) -> Duty:
        """Its beginning, at most ``duration`` s."""
        if self.exercise.duration <= duration:
            return self
        exercise = replace(self.exercise, duration=duration, ambient=self.exercise.ambient[: int(duration) + 2])
        return Duty(exercise, self.drive_time[self.drive_time < duration - 0.6], self.hydraulic_time[self.hydraulic_time < duration - 0.6])


def drawn(rng: np.random.Generator, duration: float, payload: float, rate: float, warm: bool) -> Duty:
    """A duty of ``duration`` s with a payload (kg, as declared), recorded at ``rate`` Hz; begun warm or at ambient."""
    steady = rng.random() < 0.25  # one speed again and again, or another for each move
    slow, fast = np.sort(rng.uniform(_SLOWEST, 1000.0, 2))
    fast = min(fast + 200.0, _FASTEST)
    one = rng.uniform(300.0, 750.0)
    brisk = rng.random() < 0.3
    dwell = rng.uniform(1.0, 3.0) if brisk else rng.uniform(2.0, 9.0)
    moves, total = [], 0.0
    low = rng.uniform(0.012, 0.03)
    while total < duration:
        for up in (True, False):
            rpm = one if steady else rng.uniform(slow, fast)
            if rng.random() < 0.04 and not steady:
                rpm = rng.uniform(fast, _FASTEST)
            goal = rng.uniform(0.33, 0.385) if up else rng.uniform(low, low + 0.05)
            rest = dwell * rng.uniform(0.6, 1.5)
            if rng.random() < 0.03:
                rest = rng.uniform(20.0, 50.0)
            moves.append((rpm * RPM * (1.0 if up else -1.0), goal, rest))
            total += rest + 0.3 / (rpm * RPM * _ROD_PER_RAD)
    seconds = np.arange(int(duration) + 2, dtype=float)
    level = 296.15 + float(np.clip(rng.normal(0.0, 4.0), -8.0, 8.0))
    drift = rng.normal(0.0, 1.2)
    ambient = level + drift * seconds / duration + rng.uniform(0.1, 0.8) * np.sin(
        2.0 * np.pi * seconds / rng.uniform(600.0, 2400.0) + rng.uniform(0.0, 6.28))
    exercise = Exercise(np.array(moves), rng.uniform(1100.0, 1200.0) * RPM, duration, ambient, payload, float(moves[1][1]),
                        _start(rng, float(ambient[0]), warm))
    shift = rng.uniform(0.0, 1.0 / rate, 2)
    count = int((duration - 1.0) * rate)
    return Duty(exercise, 0.5 + shift[0] + np.arange(count) / rate, 0.5 + shift[1] + np.arange(count) / rate)


def _start(rng: np.random.Generator, ambient: float, warm: bool) -> np.ndarray:
    """Temperatures after a rest: all at ambient, or what an earlier run has left."""
    t = np.full(heat.N, ambient + rng.normal(0.0, 0.15))
    if warm:
        motor, oil = rng.uniform(2.0, 13.0), rng.uniform(1.5, 7.0)
        for k, node in enumerate(heat.NODES):
            if node in _MOTOR:
                t[k] += motor
            elif node in _LINES:
                t[k] += 0.5 * oil
            elif node in _WARM_PUMPS:
                t[k] += 0.9 * oil
            elif node == "tank_wall":
                t[k] += 0.85 * oil
            elif node != "frame":
                t[k] += oil
    return t
