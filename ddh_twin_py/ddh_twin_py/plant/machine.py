"""One rig of the plant: drawn from the sheet, given a condition, run through an exercise."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.plant import heat
from ddh_twin_py.plant.condition import sound
from ddh_twin_py.plant.fault import Fault
from ddh_twin_py.plant.oil import vogel
from ddh_twin_py.plant.run import FAST, LEDGER, STATES, run
from ddh_twin_py.rig import Rig

TEMPERATURE_GRID = 0.1
"""s between kept temperatures."""


@dataclass(frozen=True)
class Exercise:
    """What a rig is asked to do.

    Attributes:
        program: moves, (k, 3): signed speed (rad/s), goal (m) or NaN, dwell after it (s). ramp: rad/s2.
        duration: s. ambient: K, once per second, (duration + 2,). payload: kg, as declared. position: m, at the start.
        start: K of every node at the start, (heat.N,).
    """

    program: np.ndarray
    ramp: float
    duration: float
    ambient: np.ndarray
    payload: float
    position: float
    start: np.ndarray


@dataclass(frozen=True)
class Course:
    """What happened.

    Attributes:
        drive, hydraulic: samples (n, len(FAST)) at `drive_time`, `hydraulic_time` (s).
        temperatures: K, (m, heat.N), every `TEMPERATURE_GRID`. brake, start: what a replay of the same commands needs, (k,).
        ledger: J, by name. condition, params: as run, (1,).
    """

    drive_time: np.ndarray
    drive: np.ndarray
    hydraulic_time: np.ndarray
    hydraulic: np.ndarray
    temperatures: np.ndarray
    brake: np.ndarray
    start: np.ndarray
    ledger: Mapping[str, float]
    condition: np.ndarray
    params: np.ndarray


@dataclass(frozen=True)
class Machine:
    """A rig as built.

    Attributes:
        rig: drawn quantities. payload_ratio: true over declared payload.
    """

    rig: Rig
    payload_ratio: float

    def run(self, exercise: Exercise, faults: Sequence[tuple[Fault, float]], drive_time: np.ndarray,
            hydraulic_time: np.ndarray, same_commands: Course | None = None) -> Course:
        """Run an exercise with faults, given with their departures; sampled at sorted instants, s.

        Args:
            same_commands: follow this course's commands in time, the rod put back to its place at each standstill.
        """
        params = self.rig.parameters
        params["load_payload_mass"] = exercise.payload * self.payload_ratio
        condition = sound()
        nominal = self.rig.parameters
        for fault, departure in faults:
            fault.apply(params, condition, departure)
        oil = vogel(*(float(params[f][0]) for f in ("oil_walther_a", "oil_walther_b", "oil_density_15C", "oil_thermal_expansion")))
        state = np.zeros(STATES)
        state[8] = exercise.position
        area = 0.25 * math.pi * float(params["cylinder_bore"][0]) ** 2
        state[3] = 0.9 * exercise.payload * 9.81 / area
        moves = exercise.program.shape[0]
        brake, start = np.full(moves, np.nan), np.full(moves, np.nan)
        if same_commands is not None:
            brake, start = same_commands.brake.copy(), same_commands.start.copy()
        every = np.concatenate([drive_time, hydraulic_time])
        order = np.argsort(every, kind="stable")
        samples = np.full((every.size, len(FAST)), np.nan)
        temperatures = np.full((int(exercise.duration / TEMPERATURE_GRID), heat.N), np.nan)
        ledger, t = np.zeros(len(LEDGER)), exercise.start.copy()
        run(params, condition, oil, float(nominal["oil_reference_viscosity"][0]), state, t, exercise.program, brake, start,
            same_commands is not None, exercise.ramp, exercise.duration, exercise.ambient, every[order], samples, temperatures,
            ledger)
        back = np.empty_like(samples)
        back[order] = samples
        n = drive_time.size
        return Course(drive_time, back[:n], hydraulic_time, back[n:], temperatures, brake, start,
                      dict(zip(LEDGER, ledger.tolist(), strict=True)), condition, params)


def build(sheet: Rig, rng: np.random.Generator, widened: float = 1.0) -> Machine:
    """A machine drawn from a sheet's tolerances; ``widened`` draws the same distribution about its outer part."""
    rig = sheet.draw(rng)
    if widened != 1.0:
        rig = sheet.built_as({
            path: sheet[path] + _pushed(rig[path] - sheet[path], q.standard_deviation, widened)
            for path, q in sheet.quantities.items() if q.standard_deviation > 0.0
        }, source="drawn wide within tolerance")
    ratio = 1.0 + float(np.clip(rng.normal(0.0, sheet.quantities["load.payload_mass"].tolerance), -0.025, 0.025))
    return Machine(rig, ratio)


def _pushed(departure: float, deviation: float, factor: float) -> float:
    return float(np.clip(departure * factor, -2.5 * deviation, 2.5 * deviation))


def nominal(sheet: Rig) -> Machine:
    """The machine of the sheet itself."""
    return Machine(sheet, 1.0)


