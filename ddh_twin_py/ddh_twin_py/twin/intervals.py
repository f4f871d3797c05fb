"""From samples to intervals: the means of each interval, the command at its edges."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.compiled import inlined, kernel
from ddh_twin_py.physics.free_run import COMMAND_PARTS

INTERVAL = 0.05
"""s, the tick of the twin: outputs come at 20 Hz of measurement time."""
HOLD = 0.5
"""s for which a stream that stopped is held; beyond it the twin says that it does not know."""
STANDSTILL = 0.3
"""s of zero command after which the rod counts as standing."""
_ZERO_COMMAND = 1e-3  # rad/s

# carry: last value of each column and its age, time at standstill, the newest command sample before the edge
_DRIVE, _HYDRAULIC = 6, 4
_COLUMNS = _DRIVE + _HYDRAULIC
_AGE = _COLUMNS
CARRY = 2 * _COLUMNS + 4
_STILL, _COMMAND_TIME, _COMMAND, _EDGE_COMMAND = range(2 * _COLUMNS, CARRY)


def command_size(n: int) -> int:
    """How many values of the command belong to n intervals."""
    return n * COMMAND_PARTS + 1


def new_carry() -> np.ndarray:
    """What passes from one call of `reduce_intervals` to the next, before anything was measured; shape (CARRY,)."""
    carry = np.full(CARRY, np.nan)
    carry[_AGE: _AGE + _COLUMNS] = np.inf
    carry[_STILL] = 0.0
    return carry


@inlined
def _held(carry, column):
    """The last value of a column, NaN once it is older than `HOLD`."""
    return carry[column] if carry[_AGE + column] <= HOLD else np.nan


@kernel
def reduce_intervals(first_edge, interval, drive_time, drive, drive_stop, hydraulic_time, hydraulic, hydraulic_stop, carry,
                     measured, command):
    """Means of each interval.

    Args:
        first_edge: s, start of the first interval. interval: s.
        drive_time, drive: s and (n, 6): speed_command, speed, torque, current, voltage,
            electrical_power, sorted by time, from the first sample after ``first_edge`` on and
            beyond the last edge if known (the command at an edge is interpolated).
        drive_stop: for each interval, index of its first sample after its end, shape (n,).
        hydraulic_time, hydraulic, hydraulic_stop: the same with pressure_piston_side,
            pressure_rod_side, rod_position, rod_velocity.
        carry: in and out, see `new_carry`.
        measured: out, shape (n,), `soft_sensor.MEASURED_DTYPE`; NaN where nothing was
            measured for longer than `HOLD`.
        command: out, rad/s at the edges of the parts of the intervals, shape (`command_size` (n),);
            NaN once the last sample is older than `HOLD`.
    """
    drive_start, hydraulic_start, ahead = 0, 0, 0
    total = np.empty(_COLUMNS)
    count = np.empty(_COLUMNS)
    command[0] = carry[_EDGE_COMMAND]
    for k in range(measured.shape[0]):
        end = first_edge + (k + 1) * interval
        total[:] = 0.0
        count[:] = 0.0
        square, square_count = 0.0, 0
        for j in range(_COLUMNS):
            carry[_AGE + j] += interval
        for i in range(drive_start, drive_stop[k]):
            for j in range(_DRIVE):
                if np.isfinite(drive[i, j]):
                    total[j] += drive[i, j]
                    count[j] += 1.0
                    carry[_AGE + j] = max(0.0, end - drive_time[i])
            if np.isfinite(drive[i, 3]):
                square += drive[i, 3] * drive[i, 3]
                square_count += 1
        for i in range(hydraulic_start, hydraulic_stop[k]):
            for j in range(_HYDRAULIC):
                if np.isfinite(hydraulic[i, j]):
                    total[_DRIVE + j] += hydraulic[i, j]
                    count[_DRIVE + j] += 1.0
                    carry[_AGE + _DRIVE + j] = max(0.0, end - hydraulic_time[i])
        for j in range(_COLUMNS):
            if count[j] > 0.0:
                carry[j] = total[j] / count[j]

        for part in range(1, COMMAND_PARTS + 1):
            edge = end - (COMMAND_PARTS - part) * interval / COMMAND_PARTS
            while ahead < drive_time.shape[0] and (drive_time[ahead] <= edge or not np.isfinite(drive[ahead, 0])):
                if np.isfinite(drive[ahead, 0]):
                    carry[_COMMAND_TIME] = drive_time[ahead]
                    carry[_COMMAND] = drive[ahead, 0]
                ahead += 1
            edge_command = carry[_COMMAND] if edge - carry[_COMMAND_TIME] <= HOLD else np.nan
            if ahead < drive_time.shape[0]:
                span = drive_time[ahead] - carry[_COMMAND_TIME]
                if 0.0 < span < HOLD:
                    edge_command += (drive[ahead, 0] - carry[_COMMAND]) * (edge - carry[_COMMAND_TIME]) / span
            command[k * COMMAND_PARTS + part] = edge_command
        before = carry[_EDGE_COMMAND]
        if not np.isfinite(before):
            before = edge_command
            if k == 0:
                command[0] = edge_command
        carry[_EDGE_COMMAND] = edge_command
        if abs(before) < _ZERO_COMMAND and abs(edge_command) < _ZERO_COMMAND:
            carry[_STILL] += interval
        else:
            carry[_STILL] = 0.0

        m = measured[k]
        m.speed_command = _held(carry, 0)
        m.speed = _held(carry, 1)
        m.torque = _held(carry, 2)
        m.current = _held(carry, 3)
        m.current_square = square / square_count if square_count > 0 else m.current * m.current
        m.voltage = _held(carry, 4)
        m.electrical_power = _held(carry, 5)
        m.pressure_piston_side = _held(carry, 6)
        m.pressure_rod_side = _held(carry, 7)
        m.rod_position = _held(carry, 8)
        m.rod_velocity = _held(carry, 9)
        m.acceleration = (edge_command - before) / interval
        m.drive_age = min(carry[_AGE + 1], carry[_AGE + 3])
        m.hydraulic_age = np.min(carry[_AGE + _DRIVE: _AGE + _COLUMNS])
        m.standstill = carry[_STILL]
        drive_start, hydraulic_start = drive_stop[k], hydraulic_stop[k]
