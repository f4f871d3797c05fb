"""What a duty costs on average: heat, flows and current of a running machine, as measured or as a duty file says.

The thermal network feels a cycle of seconds as its mean; these means drive predictions over minutes and hours.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.cylinder import rod_travel
from ddh_twin_py.physics.free_run import HYDRAULIC_STEP, free_run
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES, POSITION, SPEED
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.oil import VAPOUR_PRESSURE
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE, soft_sensor
from ddh_twin_py.physics.thermal_network import N, N_FLOWS
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.duty import Duty, DutyCommand, DutyError
from ddh_twin_py.twin.intervals import command_size
from ddh_twin_py.twin.possible_speed import STEADY, steady_operations
from ddh_twin_py.twin.rest import rest_at

WINDOW = 120.0
"""s of telemetry that count as the present duty."""
OLDEST = 2.0 * WINDOW
"""s of data time after which telemetry does not tell the present duty any more: what is missed for a moment costs nothing."""
TELLS_AHEAD = 15.0
"""s ahead that each second of telemetry tells while there is less than a whole window."""
LEAST_SEEN = 20.0
"""s of telemetry below which they tell nothing ahead: a single stroke is no duty."""
_MOST_ROWS = 300  # of the window, evenly taken, that a change of speed is worked out on
_STANDING = 1e-2  # rad/s
_SLOW, _SPEEDS = 0.05, 5  # slowest speed that counts as motion, of the fastest; speeds in each direction that are settled
_SMALL = {"pressure_piston_side": 1e5, "pressure_rod_side": 1e5, "rod_velocity": 1e-3}  # Pa, m/s; below it no share is told
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
    """The means of the last `WINDOW` seconds of telemetry, none of them older than `OLDEST`, and what they would be at another speed.

    Args:
        rig: the rig. interval: s.
    """

    def __init__(self, rig: Rig, interval: float) -> None:
        self._rig, self._interval = rig, interval
        self._size = max(1, round(WINDOW / interval))
        self.clear()

    def clear(self) -> None:
        """Forget the duty."""
        self._rows: list[tuple[np.ndarray, ...]] = []
        self._came: list[int] = []  # intervals that had passed when each of these came
        self._passed = 0
        self._count = 0

    def add(self, heat: np.ndarray, flow: np.ndarray, mean_square_current: np.ndarray, measured: np.ndarray) -> None:
        """Intervals in which all telemetry was there: (n, N), (n, N_FLOWS), (n,), `MEASURED_DTYPE` (n,)."""
        if measured.size:
            self._rows.append((heat, flow, mean_square_current, measured))
            self._came.append(self._passed)
            self._count += measured.size
        while self._rows and self._count - self._rows[0][3].size >= self._size:
            self._drop()

    def passes(self, intervals: int) -> None:
        """So many intervals passed, whether they told a duty or not."""
        self._passed += intervals
        while self._came and (self._passed - self._came[0]) * self._interval > OLDEST:
            self._drop()

    def _drop(self) -> None:
        """Forget the oldest rows."""
        self._came.pop(0)
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

    @property
    def seen(self) -> float:
        """s of telemetry that the means are of, at most `WINDOW`."""
        return min(self._count, self._size) * self._interval

    @property
    def tells_ahead(self) -> float:
        """s ahead that the telemetry so far tells: part of a cycle is not the duty; a whole window tells everything, and so does none."""
        if not 0.0 < self.seen < WINDOW - self._interval:
            return float("inf")
        return TELLS_AHEAD * self.seen if self.seen >= LEAST_SEEN else 0.0

    def changed(self, temperature: np.ndarray) -> ChangedDuty | None:
        """The duty at other speeds and temperatures than these, at which it was measured, K (N,); None where it is not known."""
        if not self.known:
            return None
        measured = np.concatenate([rows[3] for rows in self._rows])[-self._size:]
        return ChangedDuty(self._rig, self.point(), measured, temperature)


class ChangedDuty:
    """What a measured duty would be at another speed and other temperatures of the unit.

    Times of motion and rest are kept as shares. Pressures and rod velocity of a moving unit change by what the model
    settles to at both (`steady_operation`), as far as it was measured to be settled: the pumps press against what does
    not leak away, and cold oil hardly leaks.
    Losses change by what the soft sensor makes of the two.

    Args:
        rig: the rig. point: the measured means. measured: `MEASURED_DTYPE`, (n,). temperature: K, (N,), when it was measured.

    Attributes:
        scales: factors on the speed up to the motor's largest, (k,); empty where it stands.
    """

    def __init__(self, rig: Rig, point: OperatingPoint, measured: np.ndarray, temperature: np.ndarray) -> None:
        self._rig, self._point = rig, point
        self._measured = np.ascontiguousarray(measured[:: max(1, measured.size // _MOST_ROWS)])
        fastest = float(np.abs(self._measured["speed"]).max())
        self.scales = _scales(rig, fastest) if fastest >= _STANDING else np.zeros(0)
        self._moving = np.abs(self._measured["speed"]) > max(_SLOW * fastest, _STANDING)
        shares = np.geomspace(_SLOW, 1.0, _SPEEDS) * max(fastest, _STANDING)
        self._speeds = np.concatenate([-shares[::-1], shares])
        self._settled = self._steady(self._speeds, temperature)
        self._base = self._cost(1.0, temperature)

    def __call__(self, scale: float, temperature: np.ndarray) -> OperatingPoint:
        """The means at ``scale`` times the speed and with the nodes at ``temperature``, K (N,)."""
        if scale <= 0.0:
            return OperatingPoint.rest(self._point.position)
        heat, flow, square = self._cost(scale, temperature)
        point, base = self._point, self._base
        return OperatingPoint(point.heat + heat - base[0], np.maximum(point.flow + flow - base[1], 0.0),
                              point.mean_square_current * (square / base[2] if base[2] > 0.0 else 1.0), point.position, scale * point.speed)

    def _steady(self, speeds: np.ndarray, temperature: np.ndarray) -> np.ndarray:
        out = np.empty((speeds.size, len(STEADY)))
        steady_operations(self._rig.parameters, temperature, speeds, self._point.position, out)
        return out

    def _cost(self, scale: float, temperature: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        changed, moving = self._measured.copy(), self._moving
        speed = changed["speed"][moving]
        change = self._steady(scale * self._speeds, temperature) - self._settled
        for name in ("pressure_piston_side", "pressure_rod_side", "rod_velocity"):
            k = STEADY.index(name)
            settled = np.interp(speed, self._speeds, self._settled[:, k])
            with np.errstate(divide="ignore", invalid="ignore"):  # a stroke that begins is not yet where it settles
                reached = np.where(np.abs(settled) > _SMALL[name], np.clip(changed[name][moving] / settled, 0.0, 1.0), 1.0)
            changed[name][moving] += reached * np.interp(speed, self._speeds, change[:, k])
        for name in ("pressure_piston_side", "pressure_rod_side"):
            changed[name] = np.maximum(changed[name], np.minimum(self._measured[name], VAPOUR_PRESSURE))
        changed["speed"] *= scale
        changed["acceleration"] *= scale * scale
        points, temperatures = np.zeros(changed.size, OPERATING_DTYPE), np.empty((changed.size, N))
        soft_sensor(self._rig.parameters, changed, temperature, True, 1e-3, temperature.copy(), np.full(changed.size, temperature.min()),
                    points, temperatures)
        current = np.minimum(np.abs(points["current"]), self._rig["motor.current_limit"])
        return points["heat"].mean(axis=0), points["flow"].mean(axis=0), float(np.mean(current ** 2))


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
    parameters = rig.declaring(duty.payload).parameters
    record = parameters[0]
    per_rad = rod_travel(record)
    state = np.zeros(len(HYDRAULIC_STATES))
    rest_at(parameters, state, duty.start_position)
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


def duty_scales(rig: Rig, duty: Duty) -> np.ndarray:
    """Factors on a duty file's speeds, (k,), up to the motor's largest; empty where it never moves."""
    fastest = max((abs(segment.speed) for segment in duty.cycle), default=0.0)
    return _scales(rig, fastest) if fastest >= _STANDING else np.zeros(0)


def scaled_in_speed(duty: Duty, scale: float) -> Duty:
    """A duty file's cycle with its speeds scaled, dwells as they are."""
    return replace(duty, cycle=tuple(replace(s, speed=s.speed * scale) for s in duty.cycle))
