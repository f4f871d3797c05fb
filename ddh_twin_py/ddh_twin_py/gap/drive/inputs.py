"""Unknown inputs of a direct driven unit, from its recordings alone: torque, force, flow and heat that no law of the model gives.

Torque, force and flow are what the soft sensor's balances leave over at measured speed, pressures and motion; heat is what the
smoother of the temperatures adds to each part (`uncertain_parameters.UNKNOWN_HEATS`; its prior of some watts draws it towards zero).
What the commissioning recording leaves over alike is taken off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fusion.uncertain_parameters import UNKNOWN_HEATS
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.replay_result import ReplayResult
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.physics.cylinder import load_force, piston_area
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording

_STEADY = 5.0  # rad/s2: a shaft that accelerates less runs steadily
_MOVING = 3.0  # rad/s: a shaft that turns faster moves the rod
_BLOCK = 20.0  # s, whose means are taken as independent
_LEAST = 3  # blocks that tell a scatter
_HEATED = {"motor_winding": ("motor", "winding"), "motor_housing": ("motor", "housing")}


@dataclass(frozen=True)
class _Left:
    """What is left over: mean and its standard deviation."""

    value: float
    std: float


def unknown_inputs(field: Recording, baseline: Recording | None, rig: Rig) -> list[Lack]:
    """What a recording asks for beyond the model, by place and phase.

    Args:
        field: in question. baseline: of the same rig as built, None where there is none. rig: fitted as far as it was.

    Returns:
        Rows by place; shares by the squares of value over standard deviation. Empty where telemetry tells nothing.
    """
    found = _left_over(field, rig)
    before = _left_over(baseline, rig) if baseline is not None else {}
    rows = []
    for key, left in found.items():
        was = before.get(key, _Left(0.0, 0.0))
        rows.append((*key, left.value - was.value, float(np.hypot(left.std, was.std))))
    weight = [(value / std) ** 2 if std > 0.0 else 0.0 for *_, value, std in rows]
    total = sum(weight) or 1.0
    return [Lack(component, domain, phase, part, value, std, unit, w / total)
            for (component, domain, phase, part, unit, value, std), w in zip(rows, weight, strict=True)]


def _left_over(recording: Recording, rig: Rig) -> dict[tuple[str, str, str, str, str], _Left]:
    """By component, domain, phase, part and unit."""
    result = replay(recording, rig, smooth=True)
    out: dict[tuple[str, str, str, str, str], _Left] = {}
    for phase, here in _phases(result).items():
        for (component, domain, unit), values in _balances(result, rig, phase).items():
            if (left := _mean(result.time[here], values[here])) is not None:
                out[(component, domain, phase, "", unit)] = left
    for i, (name, _, _) in enumerate(UNKNOWN_HEATS):
        component, part = _HEATED.get(name, (name, ""))
        if len(result.smoothed_heat):
            out[(component, "thermal", "all", part, "W")] = _Left(
                float(np.mean(result.smoothed_heat[:, i])), float(np.mean(result.smoothed_heat_std[:, i])))
    return out


def _phases(result: ReplayResult) -> dict[str, np.ndarray]:
    """Intervals of steady lifting and lowering."""
    measured = result.measured
    steady = (np.abs(measured["acceleration"]) < _STEADY) & (np.abs(measured["speed_command"] - measured["speed"]) < _MOVING)
    known = np.isfinite(measured["current"]) & np.isfinite(measured["pressure_piston_side"]) & np.isfinite(measured["rod_velocity"])
    return {"lifting": steady & known & (measured["speed"] > _MOVING), "lowering": steady & known & (measured["speed"] < -_MOVING)}


def _balances(result: ReplayResult, rig: Rig, phase: str) -> dict[tuple[str, str, str], np.ndarray]:
    """Left over of torque at the shaft, of force at the piston and, while no check valve can open, of flow into the piston side, (n,)."""
    soft, measured = result.soft, result.measured
    record = rig.declaring(result.recording.rig.payload_mass if result.recording.rig is not None else None).parameters[0]
    load = load_force(measured["rod_position"], record)
    out = {
        ("motor", "mechanical", "N*m"): rig["motor.torque_constant"] * measured["current"] - soft["torque"],
        ("cylinder", "mechanical", "N"): soft["cylinder_force"] - load - soft["friction_force"],
    }
    if phase == "lifting":
        out[("pump_1", "hydraulic", "m3/s")] = piston_area(record) * measured["rod_velocity"] - soft["pump_1_flow"]
    return out


def _mean(time: np.ndarray, values: np.ndarray) -> _Left | None:
    """Mean of the means of blocks, and its standard deviation by their scatter."""
    good = np.isfinite(values)
    block = np.unique((time[good] // _BLOCK).astype(np.int64), return_inverse=True)[1]
    if not block.size or block.max() + 1 < _LEAST:
        return None
    means = np.bincount(block, values[good]) / np.bincount(block)
    return _Left(float(means.mean()), float(means.std(ddof=1) / np.sqrt(means.size)))
