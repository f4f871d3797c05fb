"""One cycle of a duty by the free run, closed over the rod's position, in compiled code."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE, OPERATING_FIELDS
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.physics.cylinder import rod_travel
from ddh_twin_py.physics.free_run import COMMAND_PARTS, HYDRAULIC_STEP, free_run
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES, POSITION
from ddh_twin_py.physics.oil import VAPOUR_PRESSURE
from ddh_twin_py.physics.thermal_network import END_WINDING, N, SLOT_WINDING
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.duty import Duty, segment_table
from ddh_twin_py.twin.duty_program import COMMAND, CYCLES, new_program, next_command
from ddh_twin_py.twin.rest import rest_at

PERIOD = 0.02
"""s, control period and interval of the thermal network within a cycle."""
_COLUMNS = OPERATING_DTYPE.itemsize // 8
_CURRENT, _PRESSURE_A, _PRESSURE_B, _PORT_1, _PORT_2 = (
    OPERATING_FIELDS.index(name)
    for name in ("current", "pressure_piston_side", "pressure_rod_side", "pump_1_port_pressure", "pump_2_port_pressure")
)
EXTREMES = ("current", "cavitating", "pressure_piston_side", "pressure_rod_side", "winding")
"""Of the means of a period over a cycle: largest |current|, A; share of the periods in which the
pressure of a chamber or pump port is at or below the vapour pressure; highest pressures, Pa; highest winding temperature, K."""


@kernel
def run_cycle(params, state, temperature, segments, ramp, lowest, highest, rod_speed_per_rad, program, ambient, period, step,
              longest, point, flat, mean, average, extremes, trace, temperatures, commands):
    """Do the duty until its cycle is over, or for ``longest`` periods, in place on state, temperature and program.

    Args:
        segments, ramp, lowest, highest, rod_speed_per_rad, program: see `duty_program.next_command`.
        ambient: K. period: s. step: s, hydraulic step.
        point: scratch, one operating point, and ``flat``, the same memory as numbers, (1, columns).
        mean: out, mean operating point as numbers, (columns,). average: out, mean temperatures, K, (N,).
        extremes: out, see `EXTREMES`, (5,).
        trace, temperatures: out, operating points as numbers (k, columns) and temperatures (k, N)
            of the first k periods. commands: out, rad/s at the end of each of them, (k,).
    Returns:
        periods that it took; heat lost to ambient, J.
    """
    command = np.empty(COMMAND_PARTS + 1)
    air, nowhere, end = np.full(1, ambient), np.full(1, np.nan), np.empty((1, temperature.shape[0]))
    mean[:] = 0.0
    extremes[:] = -np.inf
    extremes[1] = 0.0
    average[:] = 0.0
    before, lost, count = program[CYCLES], 0.0, 0
    while count < longest and program[CYCLES] == before:
        last = program[COMMAND]
        following = next_command(segments, ramp, lowest, highest, program, state[POSITION], rod_speed_per_rad, period)
        for j in range(COMMAND_PARTS + 1):
            command[j] = last + (following - last) * j / COMMAND_PARTS
        lost += free_run(params, state, temperature, command, air, period, step, nowhere, point, end)
        for j in range(mean.shape[0]):
            mean[j] += flat[0, j]
        extremes[0] = max(extremes[0], abs(flat[0, _CURRENT]))
        least = min(min(flat[0, _PRESSURE_A], flat[0, _PRESSURE_B]), min(flat[0, _PORT_1], flat[0, _PORT_2]))
        if least <= VAPOUR_PRESSURE:
            extremes[1] += 1.0
        for j in range(average.shape[0]):
            average[j] += temperature[j]
        extremes[2] = max(extremes[2], flat[0, _PRESSURE_A])
        extremes[3] = max(extremes[3], flat[0, _PRESSURE_B])
        extremes[4] = max(extremes[4], max(temperature[SLOT_WINDING], temperature[END_WINDING]))
        if count < trace.shape[0]:
            trace[count] = flat[0]
            temperatures[count] = temperature
            commands[count] = following
        count += 1
    mean /= max(count, 1)
    average /= max(count, 1)
    extremes[1] /= max(count, 1)
    return count, lost


@dataclass(frozen=True)
class CycleRun:
    """What a cycle was like.

    Attributes:
        duration: s. mean: operating point, means over the cycle, `OPERATING_DTYPE`, shape (1,).
        average: mean temperatures, K, (N,). extremes: see `EXTREMES`. lost: heat lost to ambient, J.
        points, temperatures: of each period, (n,) and (n, N); empty unless they were asked for.
        commands: speed command at the end of each period, rad/s, (n,); the same.
    """

    duration: float
    mean: np.ndarray
    average: np.ndarray
    extremes: dict[str, float]
    lost: float
    points: np.ndarray
    temperatures: np.ndarray
    commands: np.ndarray


class DutyRun:
    """A rig that does a duty from rest, cycle after cycle.

    Args:
        rig: payload and oil are its own. duty: see `duty.Duty`.
        temperature: K at the start, one number or (N,). ambient: K, the whole time.
        patient: strokes have no time-out, for a unit that is too cold to keep to them.

    Attributes:
        temperature: K, (N,), now. time: s of duty done.
    """

    def __init__(self, rig: Rig, duty: Duty, temperature: float | np.ndarray, ambient: float, patient: bool = False,
                 period: float = PERIOD) -> None:
        self.parameters = rig.parameters
        record = self.parameters[0]
        self.temperature = np.full(N, temperature, dtype=float)
        self.ambient = ambient
        self.time = 0.0
        self._period = period
        self._segments = segment_table(duty)
        if patient:
            strokes = [i for i, segment in enumerate(duty.cycle) if segment.kind not in ("speed", "dwell")]
            self._segments[strokes, 3] = np.inf
        self._ramp = duty.ramp
        self._rod_speed_per_rad = rod_travel(record)
        self._state = np.zeros(len(HYDRAULIC_STATES))
        rest_at(self.parameters, self._state, duty.start_position)
        self._program = new_program()
        self._point = np.zeros(1, OPERATING_DTYPE)
        self._flat = self._point.view(np.float64).reshape(1, _COLUMNS)

    def cycle(self, lowest: float = -np.inf, highest: float = np.inf, longest: float = 3600.0, keep: bool = False) -> CycleRun:
        """One cycle; no command beyond ``lowest`` and ``highest``, rad/s; cut off after ``longest`` s."""
        most = int(np.ceil(longest / self._period))
        rows = most if keep else 0
        trace, temperatures, commands = np.empty((rows, _COLUMNS)), np.empty((rows, N)), np.empty(rows)
        mean, average, extremes = np.empty(_COLUMNS), np.empty(N), np.empty(len(EXTREMES))
        count, lost = run_cycle(
            self.parameters, self._state, self.temperature, self._segments, self._ramp, lowest, highest, self._rod_speed_per_rad,
            self._program, self.ambient, self._period, HYDRAULIC_STEP, most, self._point, self._flat, mean, average, extremes,
            trace, temperatures, commands,
        )
        self.time += count * self._period
        return CycleRun(
            count * self._period, mean.view(OPERATING_DTYPE), average, dict(zip(EXTREMES, extremes, strict=True)), lost,
            trace[:count].copy().view(OPERATING_DTYPE)[:, 0] if keep else np.zeros(0, OPERATING_DTYPE), temperatures[:count].copy(),
            commands[:count].copy(),
        )
