"""What a duty costs on average: heat, flows and current of a running machine, as measured or as a duty file says.

The thermal network feels a cycle of seconds as its mean; these means drive predictions over minutes and hours.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.free_run import HYDRAULIC_STEP, free_run, settle
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES, POSITION, SPEED
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE, soft_sensor
from ddh_twin_py.physics.thermal_network import N, N_FLOWS
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.duty import Duty, DutyCommand, DutyError
from ddh_twin_py.twin.intervals import command_size

WINDOW = 120.0
"""s of telemetry that count as the present duty."""
_MOST_ROWS = 300  # of the window, evenly taken, that a change of speed is worked out on
_PERIOD = 0.01  # s, of the speed command of a duty
LONGEST_CYCLE = 600.0
"""s of one cycle of a duty that are run to find its means."""
SCALES = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0)
"""Factors on the speed of a duty at which its means are worked out; linear in between."""


@dataclass(frozen=True)
class OperatingPoint:
    """Means over a duty.

    Attributes:
        heat: W into each node, copper loss left out, (N,). flow: m3/s, (N_FLOWS,).
        mean_square_current: A^2. position: m. speed: rad/s, mean of the absolute value.
    """

    heat: np.ndarray
    flow: np.ndarray
    mean_square_current: float
    position: float
    speed: float

    @classmethod
    def rest(cls, position: float = 0.0) -> OperatingPoint:
        """The unit stands."""
        return cls(np.zeros(N), np.zeros(N_FLOWS), 0.0, position, 0.0)

    def with_current(self, rms: float) -> OperatingPoint:
        """The same with another current, A rms."""
        return replace(self, mean_square_current=rms * rms)


class ScaledDuty:
    """A duty at other speeds: means at `SCALES` up to the motor's largest speed, linear in between."""

    def __init__(self, scales: np.ndarray, points: list[OperatingPoint]) -> None:
        self._scales, self._points = scales, points

    @property
    def largest(self) -> float:
        """Factor at which the motor turns as fast as it may."""
        return float(self._scales[-1])

    def at(self, scale: float) -> OperatingPoint:
        """The duty at ``scale`` times its speed."""
        k = int(np.clip(np.searchsorted(self._scales, scale, "right") - 1, 0, len(self._points) - 2))
        share = (scale - self._scales[k]) / (self._scales[k + 1] - self._scales[k])
        low, high = self._points[k], self._points[k + 1]

        def mixed(name: str):
            return getattr(low, name) + share * (getattr(high, name) - getattr(low, name))

        return OperatingPoint(*(mixed(name) for name in ("heat", "flow", "mean_square_current", "position", "speed")))


def _scales(rig: Rig, fastest: float) -> np.ndarray:
    largest = min(max(1.0, rig["motor.maximum_speed"] * RAD_PER_S_OF_RPM / fastest), SCALES[-1])
    return np.array([*(scale for scale in SCALES if scale < largest - 1e-3), largest])


class PresentDuty:
    """The means of the last `WINDOW` seconds of telemetry, and what they would be at another speed.

    Args:
        rig: the rig. interval: s.
    """

    def __init__(self, rig: Rig, interval: float) -> None:
        self._rig = rig
        self._size = max(1, round(WINDOW / interval))
        self.clear()

    def clear(self) -> None:
        """Forget the duty."""
        self._rows: list[tuple[np.ndarray, ...]] = []
        self._count = 0

    def add(self, heat: np.ndarray, flow: np.ndarray, mean_square_current: np.ndarray, measured: np.ndarray) -> None:
        """Intervals in which all telemetry was there: (n, N), (n, N_FLOWS), (n,), `MEASURED_DTYPE` (n,)."""
        if measured.size:
            self._rows.append((heat, flow, mean_square_current, measured))
            self._count += measured.size
        while self._rows and self._count - self._rows[0][3].size >= self._size:
            self._count -= self._rows.pop(0)[3].size

    @property
    def known(self) -> bool:
        """Whether there is any telemetry in the window."""
        return self._count > 0

    def point(self) -> OperatingPoint:
        """The means; at rest where nothing is known."""
        if not self.known:
            return OperatingPoint.rest()
        heat, flow, square, measured = (np.concatenate(column)[-self._size:] for column in zip(*self._rows, strict=True))
        return OperatingPoint(heat.mean(axis=0), flow.mean(axis=0), float(square.mean()), float(measured["rod_position"].mean()),
                              float(np.abs(measured["speed"]).mean()))

    def scaled(self, temperature: np.ndarray) -> ScaledDuty | None:
        """The duty at other speeds, times of motion and rest kept as shares, pressures as measured; None where it stands.

        The change from scale 1 is the soft sensor's, at node temperatures in K (N,).
        """
        if not self.known:
            return None
        point = self.point()
        measured = np.concatenate([rows[3] for rows in self._rows])[-self._size:]
        measured = np.ascontiguousarray(measured[:: max(1, measured.size // _MOST_ROWS)])
        fastest = float(np.abs(measured["speed"]).max())
        if fastest < 1e-2:
            return None
        scales = _scales(self._rig, fastest)
        costs = [self._cost(measured, scale, temperature) for scale in (1.0, *scales)]
        base = costs[0]
        points = [
            OperatingPoint(point.heat + cost[0] - base[0], np.maximum(point.flow + cost[1] - base[1], 0.0),
                           point.mean_square_current * (cost[2] / base[2] if base[2] > 0.0 else 1.0), point.position, scale * point.speed)
            for scale, cost in zip(scales, costs[1:], strict=True)
        ]
        return ScaledDuty(scales, points)

    def _cost(self, measured: np.ndarray, scale: float, temperature: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        changed = measured.copy()
        for name in ("speed", "rod_velocity"):
            changed[name] *= scale
        changed["acceleration"] *= scale * scale
        points, temperatures = np.zeros(changed.size, OPERATING_DTYPE), np.empty((changed.size, N))
        soft_sensor(self._rig.parameters, changed, temperature, True, 1e-3, temperature.copy(), np.full(changed.size, temperature.min()),
                    points, temperatures)
        return points["heat"].mean(axis=0), points["flow"].mean(axis=0), float(np.mean(points["current"] ** 2))


def measured_rows(values: dict[str, np.ndarray], size: int) -> np.ndarray:
    """`MEASURED_DTYPE` (n,) of the columns given by name, the rest 0."""
    rows = np.zeros(size, MEASURED_DTYPE)
    for name, column in values.items():
        rows[name] = column
    return rows


def duty_point(rig: Rig, duty: Duty, temperature: np.ndarray, ambient: float) -> tuple[OperatingPoint, float]:
    """Means over one cycle of a duty by the free run, and the length of the cycle, s.

    Args:
        temperature: K, (N,), held over the cycle. ambient: K.

    Raises:
        DutyError: where a cycle takes longer than `LONGEST_CYCLE`.
    """
    parameters = rig.parameters
    record = parameters[0]
    record["load_payload_mass"] = duty.payload
    area = 0.25 * np.pi * record["cylinder_bore"] ** 2
    per_rad = float(record["pump_1_displacement"] / (2.0 * np.pi) / area)
    state = np.zeros(len(HYDRAULIC_STATES))
    settle(parameters, state, duty.start_position, 0.8 * duty.payload * record["load_gravity"] / area, 0.0)
    program = DutyCommand(replace(duty, repeat=1))
    points, temperatures = np.zeros(1, OPERATING_DTYPE), np.empty((1, N))
    air, nowhere, edges = np.full(1, ambient), np.full(1, np.nan), np.zeros(command_size(1))
    heat, flow, square, position, speed = np.zeros(N), np.zeros(N_FLOWS), 0.0, 0.0, 0.0
    count, held = 0, np.array(temperature, dtype=float)
    while not program.finished:
        edges[:] = program.step(float(state[POSITION]), per_rad, _PERIOD)
        free_run(parameters, state, held.copy(), edges, air, _PERIOD, HYDRAULIC_STEP, nowhere, points, temperatures)
        point = points[0]
        heat += point["heat"]
        flow += point["flow"]
        square += point["mean_square_current"]
        position += state[POSITION]
        speed += abs(state[SPEED])
        count += 1
        if count * _PERIOD > LONGEST_CYCLE:
            raise DutyError(f"{duty.file}: one cycle takes more than {LONGEST_CYCLE:g} s; that is the most that is looked at")
    return OperatingPoint(heat / count, flow / count, square / count, position / count, speed / count), count * _PERIOD


def scaled_duty(rig: Rig, duty: Duty, cost: Callable[[Duty], OperatingPoint]) -> ScaledDuty | None:
    """A duty file's cycle with its speeds scaled, dwells as they are; None where it never moves."""
    fastest = max((abs(segment.speed) for segment in duty.cycle), default=0.0)
    if fastest < 1e-2:
        return None
    scales = _scales(rig, fastest)
    points = [OperatingPoint.rest(duty.start_position)]
    for scale in scales[1:]:
        points.append(cost(replace(duty, cycle=tuple(replace(s, speed=s.speed * scale) for s in duty.cycle))))
    return ScaledDuty(scales, points)
