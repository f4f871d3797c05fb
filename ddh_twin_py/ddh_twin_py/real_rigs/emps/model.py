"""The EMPS as a rigid axis under its known controller, and what it may have that a rigid axis has not.

    M dv/dt = g F(t - d) - Fv v - s Fc h(v) - offset,    s = sign(v), any value in [-1, 1] at rest
    F = gtau kv (kp (qg - q) - dq/dt) + pulses,          |F| at most what 10 V give

The controller takes dq/dt as half the difference of the position over two samples. It runs at the recording's 1 kHz.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.effect import Effect, added, fixed, scaled, value_of
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.real_rigs.description import Description, Parameter
from ddh_twin_py.real_rigs.emps.recordings import SOURCE, STEP, EmpsRecord
from ddh_twin_py.real_rigs.run import Run
from ddh_twin_py.real_rigs.signals import signal

BIN = 0.01
"""s; the published identification keeps samples 10 ms apart."""
SETTLING = 0.25
"""s at the beginning that are left out: what moved before is not known."""
HELD_SHARE = 0.25
"""Last share of the identification record that may refute and takes no part in finding."""
_LIMIT = 10.0  # V
_STEPS = 4  # of the axis in a sample
_CONTACT = 1.0e8  # N/m, of the teeth that meet after backlash
_DAMPING = 0.1  # of a spring's own oscillation

PARAMETERS = (
    Parameter("mass", 100.0, 30.0, "kg", "order of size of the axis, carriage and motor's inertia together", 10.0),
    Parameter("viscous", 200.0, 100.0, "N*s/m", "usual for a ball screw of this size", 0.0),
    Parameter("coulomb", 20.0, 10.0, "N", "usual for a ball screw of this size", 0.0),
)
NEUTRAL = {
    "force_gain": 1.0, "payload": 0.0, "offset": 0.0, "coulomb_difference": 0.0, "viscous_difference": 0.0, "stribeck_rise": 0.0,
    "stribeck_velocity": 0.01, "coulomb_slope": 0.0, "middle": 0.125, "delay": 0.0, "backlash": 0.0, "compliance": 0.0, "motor_share": 0.5,
}
"""Fields that effects change; ``middle`` (m) and ``motor_share`` of the mass are assumptions."""


def _stribeck(velocity: float):
    def apply(record: np.ndarray, x: float) -> None:
        record["stribeck_rise"] += x
        record["stribeck_velocity"] = velocity if x != 0.0 else record["stribeck_velocity"]

    return apply


def _effect(id: str, domain: str, parameter: str, unit: str, laws, step: float, lowest: float, highest: float, about: str, law: str,
            reference=None) -> Effect:
    return Effect(id, id.split(".")[0], domain, parameter, unit, reference or fixed(0.0), laws, step, lowest, highest, about, law)


EFFECTS = (
    _effect("friction.coulomb_direction", "mechanical", "difference", "N", (added("coulomb_difference"),), 1.0, -40.0, 40.0,
            "Dry friction is larger in one direction of motion.", "Fc = Fc0 + d/2 forward, Fc0 - d/2 backward"),
    _effect("friction.viscous_direction", "mechanical", "difference", "N*s/m", (added("viscous_difference"),), 20.0, -400.0, 400.0,
            "Viscous friction is larger in one direction of motion.", "Fv = Fv0 + d/2 forward, Fv0 - d/2 backward"),
    _effect("drive.offset", "electrical", "offset", "N", (added("offset"),), 1.0, -40.0, 40.0,
            "A constant force acts: an offset of the amplifier, or the axis is not level.", "M dv/dt = ... - offset"),
    _effect("friction.stribeck", "mechanical", "rise", "1", (_stribeck(0.005), _stribeck(0.02)), 0.1, -0.9, 3.0,
            "Dry friction falls as motion begins.", "Fc = Fc0 (1 + rise exp(-(v/vs)^2)), vs 5 or 20 mm/s"),
    _effect("friction.position", "mechanical", "slope", "N/m", (added("coulomb_slope"),), 10.0, -150.0, 150.0,
            "Dry friction changes along the stroke.", "Fc = Fc0 + slope (q - middle)"),
    _effect("transmission.backlash", "mechanical", "gap", "m", (added("backlash"),), 2.0e-5, 0.0, 2.0e-3,
            "The carriage does not follow the motor for a gap at each reversal.", "spring force 0 within the gap"),
    _effect("transmission.elasticity", "mechanical", "compliance", "m/N", (added("compliance"),), 1.0e-7, 0.0, 1.0e-5,
            "The screw gives way: motor and carriage oscillate against each other.", "F = (q - q_carriage)/compliance"),
    _effect("drive.delay", "electrical", "delay", "s", (added("delay"),), 5.0e-4, 0.0, 5.0e-3,
            "The motor's force comes later than it is told to.", "F(t - delay)"),
    _effect("motor.gain", "electrical", "gain", "1", (scaled("force_gain"),), 0.05, -0.5, 1.0,
            "The motor gives another force for a volt than its gain says.", "g = 1 + departure", value_of("force_gain")),
    _effect("load.payload", "mechanical", "mass", "kg", (added("payload"),), 5.0, -50.0, 300.0,
            "The carriage carries more than declared.", "M = M0 + payload"),
)
DESCRIPTION = Description("EMPS", SOURCE, PARAMETERS, NEUTRAL, EFFECTS, {"force": ("friction", "mechanical")}, (
    "The controller is the one of the benchmark; recorded command and position agree with it to 4 mV.",
    "Noise of the force is what four repeats of the same motion scatter about their mean.",
    "Recorded pulses are part of the recorded command.",
))


class Axis(Run):
    """One record of the axis, simulated in its closed loop from the reference alone; signal ``force``, N, that the motor is told to give.

    Args:
        record: as read. noise: N, of one sample. held_share: last share of the record that takes no part in finding.
    """

    def __init__(self, record: EmpsRecord, noise: float, held_share: float = 0.0) -> None:
        self.name, self.record = record.path.name, record
        self._velocity = np.gradient(record.reference, STEP)
        kind = 3 * _sign(self._velocity, 1e-3) + _sign(np.gradient(self._velocity, STEP), 0.05) + 4
        end = (1.0 - held_share) * record.time[-1]
        measured = np.where(record.time >= SETTLING, record.force, np.nan)
        self.signals = {"force": signal(record.time, measured, noise, "N", BIN, kind, end, end if held_share else np.inf)}

    def simulate(self, record: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Position, m, and told force, N, (n,) each, of the closed loop that starts as the recording does; a parameter record (1,)."""
        own = self.record
        position, force = np.empty(own.time.size), np.empty(own.time.size)
        start = (own.position[1] - own.position[0]) / STEP
        _closed_loop(record[0], own.reference, own.pulses, own.force_gain, own.position_gain, own.velocity_gain, own.position[0], start,
                     position, force)
        return position, force

    def predict(self, record: np.ndarray) -> dict[str, np.ndarray]:
        return {"force": self.simulate(record)[1]}

    def variables(self, record: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        return {"velocity, m/s": (self.record.time, self._velocity), "position, m": (self.record.time, self.record.reference)}


def friction(record: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Friction and offset that the motor has to overcome while it moves, N, (n,), at positions, m, and velocities, m/s."""
    p = record[0]
    return np.array([_sliding(p, q, v, 1.0 if v > 0.0 else -1.0) for q, v in zip(position, velocity, strict=True)]) + p["offset"]


def _sign(values: np.ndarray, least: float) -> np.ndarray:
    return np.sign(np.where(np.abs(values) < least, 0.0, values)).astype(np.int64)


@kernel
def _sliding(p, q, v, side):
    """Friction force while sliding to a side, N."""
    dry = p["coulomb"] + 0.5 * side * p["coulomb_difference"] + p["coulomb_slope"] * (q - p["middle"])
    dry *= 1.0 + p["stribeck_rise"] * np.exp(-((v / p["stribeck_velocity"]) ** 2))
    return side * max(dry, 0.0) + max(p["viscous"] + 0.5 * side * p["viscous_difference"], 0.0) * v


@kernel
def _closed_loop(p, reference, pulses, gain, kp, kv, start, velocity, position, force):
    """The loop over all samples; friction acts on the motor's side."""
    total = max(p["mass"] + p["payload"], 1.0)
    two = p["compliance"] > 0.0 or p["backlash"] > 0.0
    steps = _STEPS
    stiffness, damping, motor, carriage = 0.0, 0.0, total, 0.0
    if two:
        motor, carriage = p["motor_share"] * total, (1.0 - p["motor_share"]) * total
        stiffness = 1.0 / (p["compliance"] + 1.0 / _CONTACT)
        own = np.sqrt(stiffness * total / (motor * carriage))
        damping = 2.0 * _DAMPING * stiffness / own
        steps = min(max(_STEPS, int(own * STEP / 0.3) + 1), 100)
    h = STEP / steps
    q, v, qc, vc = start, velocity, start, velocity
    before, before_that = start - velocity * STEP, start - 2.0 * velocity * STEP
    late = p["delay"] / STEP
    for k in range(reference.size):
        command = kv * (kp * (reference[k] - q) - (q - before_that) / (2.0 * STEP))
        before_that, before = before, q
        position[k] = q
        force[k] = gain * min(max(command, -_LIMIT), _LIMIT) + pulses[k]
        whole = int(np.floor(k - late))
        part = k - late - whole
        acting = (1.0 - part) * force[max(whole, 0)] + part * force[min(max(whole + 1, 0), k)]
        for _ in range(steps):
            drive = p["force_gain"] * acting - p["offset"]
            if two:
                off = q - qc
                gap = 0.5 * p["backlash"]
                spring = 0.0
                if off > gap:
                    spring = max(stiffness * (off - gap) + damping * (v - vc), 0.0)
                elif off < -gap:
                    spring = min(stiffness * (off + gap) + damping * (v - vc), 0.0)
                drive -= spring
                vc += h * spring / carriage
                qc += h * vc
            free = v + h * drive / motor
            side = 1.0 if free > 0.0 else -1.0
            slow = h * abs(_sliding(p, q, v if v * side > 0.0 else 0.0, side)) / motor
            v = free - side * slow if abs(free) > slow else 0.0
            q += h * v
