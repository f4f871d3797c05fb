"""The duty's control, compiled: from where the rod is to the next speed command."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.compiled import kernel

KINDS = ("lift", "lower", "position", "speed", "dwell")
_LIFT, _LOWER, _POSITION, _SPEED, _DWELL = range(5)
PROGRAM = ("segment", "elapsed", "command", "cycles")
"""State of a duty that is being done: number of the segment, s in it, rad/s commanded, cycles completed."""
SEGMENT, ELAPSED, COMMAND, CYCLES = range(4)


def new_program() -> np.ndarray:
    """State before the first period, shape (4,), see `PROGRAM`."""
    return np.zeros(len(PROGRAM))


@kernel
def next_command(segments, ramp, lowest, highest, program, position, rod_speed_per_rad, period):
    """Command for the next control period, rad/s; ``program`` (`PROGRAM`) moves on in place.

    Args:
        segments: kind (index in `KINDS`), speed (rad/s), goal (m), duration or time-out (s), shape (k, 4).
        ramp: rad/s2, how fast the command may change.
        lowest, highest: rad/s, beyond which no command goes, as long as the drive or the oil allow no more.
        position: m. rod_speed_per_rad: m of rod per rad of shaft, to brake in time. period: s.
    """
    at = int(program[SEGMENT])
    kind, speed, goal, duration = int(segments[at, 0]), segments[at, 1], segments[at, 2], segments[at, 3]
    command = program[COMMAND]
    program[ELAPSED] += period
    target, done = speed, False
    if kind != _SPEED and kind != _DWELL:
        distance = goal - position
        braking = 0.5 * command * command / ramp * rod_speed_per_rad
        passed = (kind == _LIFT and distance <= 0.0) or (kind == _LOWER and distance >= 0.0)
        if passed or abs(distance) <= braking + 5e-4:
            target, done = 0.0, abs(command) < 1e-9
        elif distance < 0.0:
            target = -speed
    target = min(max(target, lowest), highest)
    if done or program[ELAPSED] >= duration - 1e-9:
        program[ELAPSED] = 0.0
        program[SEGMENT] += 1.0
        if int(program[SEGMENT]) == segments.shape[0]:
            program[SEGMENT] = 0.0
            program[CYCLES] += 1.0
    most = ramp * period
    program[COMMAND] = command + min(max(target - command, -most), most)
    return program[COMMAND]
