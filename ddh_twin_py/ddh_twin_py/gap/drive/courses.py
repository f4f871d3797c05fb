"""What an effect adds at its place in the direct driven unit, from the free run with and without it."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.estimation.sensors import NODE_INDEX
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.locate.lacking import Course
from ddh_twin_py.physics.thermal_network import (
    EDGES,
    N_EDGES,
    N_SURFACES,
    N_WALLS,
    SURFACES,
    WALLS,
    conductances,
    surface_loss,
)

_FIELDS = {
    ("pump_1", "hydraulic"): ("pump_1_leakage", "m3/s"), ("pump_2", "hydraulic"): ("pump_2_leakage", "m3/s"),
    ("pump_1", "mechanical"): ("pump_1_torque", "N*m"), ("pump_2", "mechanical"): ("pump_2_torque", "N*m"),
    ("motor", "mechanical"): ("loss_motor_friction", "W"), ("motor", "electrical"): ("electrical_power", "W"),
    ("drive", "electrical"): ("electrical_power", "W"), ("drive", "mechanical"): ("speed", "rad/s"),
    ("cylinder", "hydraulic"): ("loss_cylinder", "W"), ("cylinder", "mechanical"): ("friction_force", "N"),
    ("load", "mechanical"): ("cylinder_force", "N"), ("relief_valve", "hydraulic"): ("relief_flow", "m3/s"),
    ("check_valve", "hydraulic"): ("pressure_rod_side", "Pa"), ("line_a", "mechanical"): ("loss_line_a", "W"),
    ("line_b", "mechanical"): ("loss_line_b", "W"),
    ("line_b", "hydraulic"): ("pressure_rod_side", "Pa"), ("oil", "hydraulic"): ("shaft_power", "W"),
}
_ERRS = 0.3  # of the rise of the reading that errs most, from which another one errs as well


def course(effect: Effect, experiment: Experiment, without: np.ndarray, acting: np.ndarray, step: float) -> Course:
    """What the effect adds over a recording's free run.

    Args:
        without, acting: parameter records (1,) without and with the effect. step: s, hydraulic step.
    """
    before, cold = experiment.operating(without, step)
    after, warm = experiment.operating(acting, step)
    phase = experiment.phase_of_intervals()
    oil = 0.5 * (warm[:, NODE_INDEX["tank_oil"]] + cold[:, NODE_INDEX["tank_oil"]])
    regimes = {("speed", "rad/s"): after["speed_absolute"], ("pressure", "Pa"): after["pressure_piston_side"],
               ("oil temperature", "K"): oil, ("rod position", "m"): after["rod_position"]}
    if effect.domain == "thermal":
        heat = _heat(warm, acting, experiment.air) - _heat(warm, without, experiment.air)
        if np.any(heat != 0.0):
            return Course(heat, "W", phase, regimes)
    field = effect.lacked or _FIELDS.get((effect.component, effect.domain))
    if field is None:
        return _reading(effect, experiment, without, acting, step, phase, regimes)
    name, unit = field
    return Course(after[name] - before[name], unit, phase, regimes)


def _heat(temperature: np.ndarray, record: np.ndarray, air: np.ndarray) -> np.ndarray:
    """Heat through all conductances that a record names, W, (n,), at given temperatures, K, (n, N)."""
    p = record[0]
    edge, wall, surface = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3))
    conductances(record, edge, wall, surface)
    around = air + p["surroundings_enclosure_rise"]
    total = np.full(air.size, p["surroundings_solar_load"])
    for (_, one, other), g in zip(EDGES, edge, strict=True):
        total += g * np.abs(temperature[:, one] - temperature[:, other])
    for (_, node), g in zip(WALLS, wall, strict=True):
        total += g * (temperature[:, node] - around)
    for (*_, node), (area, factor, emissivity) in zip(SURFACES, surface, strict=True):
        total += surface_loss(temperature[:, node], around, area, factor, emissivity)
    return total


def _reading(effect: Effect, experiment: Experiment, without, acting, step, phase, regimes) -> Course:
    """Change of the reading that errs, or of the one that changes most for its noise, a temperature where the effect is thermal."""
    before, after = experiment.predict(without, step), experiment.predict(acting, step)
    own = [name for name in experiment.signals if name == effect.reading]
    own = own or [name for name in experiment.signals if effect.domain == "thermal" and name.startswith("temperature/")]
    moved = {name: float(np.sqrt(np.mean((after[name] - before[name]) ** 2))) / experiment.signals[name].noise
             for name in own or experiment.signals}
    worst = max(moved, key=moved.get)
    signal = experiment.signals[worst]
    order = np.argsort(signal.time, kind="stable")
    value = np.interp(experiment.axis, signal.time[order], (after[worst] - before[worst])[order])
    erring = tuple(name for name, rise in moved.items() if rise > _ERRS * moved[worst]) if effect.component == "sensor" else ()
    return Course(value, signal.unit, phase, regimes, erring)
