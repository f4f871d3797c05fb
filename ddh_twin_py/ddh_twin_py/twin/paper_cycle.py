"""The paper's cycle as the free run drives it, by one reading of its text.

Minav, Papini, Pietola: A Thermal Analysis of Direct Driven Hydraulics. The text names both 500 rpm and 0.2 m/s, although they do not
belong together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.physics.cylinder import piston_area
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, NODES
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.cycle import DutyRun
from ddh_twin_py.twin.duty import Duty, Segment

PAYLOAD, SPEED_RPM, ROD_SPEED, HEIGHT = 149.5, 500.0, 0.2, 0.4
"""Paper, section 5: kg, rpm, m/s, m."""
AMBIENT, CHAMBER = 23.0, 10.0
"""degC: paper, section 3.1, and the thermal image of its figure 1b."""
CYCLES = 20
DWELL, MARGIN, RAMP_RPM = 1.5, 0.01, 1150.0
"""s at each end, m kept from the end stops, rpm/s: not in the paper, as in the project's own recording of its cycle."""
SHOWN_CYCLES = 4
PERIOD = 0.01


@dataclass(frozen=True)
class Reading:
    """The cycle by one reading of the paper.

    Attributes:
        name: for people. speed: of the motor, rpm. time: s, (n,), end of each period of the first cycles.
        points: operating points (n,). temperatures: K, (n, N). last_points, last_temperatures: of the last cycle.
        cycle: s. start: K at the start. ends: K after each cycle, (CYCLES, N).
    """

    name: str
    speed: float
    time: np.ndarray
    points: np.ndarray
    temperatures: np.ndarray
    last_points: np.ndarray
    last_temperatures: np.ndarray
    cycle: float
    start: float
    ends: np.ndarray

    def lift(self, last: bool = False) -> slice:
        """Periods of the first (or last) lift in which the shaft is at its speed, to within 1 %."""
        return _at_speed((self.last_points if last else self.points)["speed"], self.speed * RAD_PER_S_OF_RPM)

    def lower(self, last: bool = False) -> slice:
        """The same of lowering."""
        return _at_speed(-(self.last_points if last else self.points)["speed"], self.speed * RAD_PER_S_OF_RPM)

    def peak(self, field: str) -> float:
        """Largest value of an operating point's field in the first lift at full speed."""
        return float(self.points[field][self.lift()].max())

    def change(self, node: str, part: slice, last: bool = False) -> float:
        """K by which a node changes over a part of the cycle."""
        column = (self.last_temperatures if last else self.temperatures)[part, NODES.index(node)]
        return float(column[-1] - column[0])

    def at_end(self, node: str) -> float:
        """degC of a node after all cycles."""
        return float(self.ends[-1, NODES.index(node)] - ZERO_CELSIUS)

    def first_rise(self, node: str) -> float:
        """K by which the first cycle ends warmer than it began."""
        return float(self.ends[0, NODES.index(node)] - self.start)

    @property
    def stroke_time(self) -> float:
        """s from the first motion of the first lift to its end."""
        rising = np.flatnonzero(self.points["rod_velocity"][: int(self.cycle / PERIOD)] > 1e-3)
        return float(rising[-1] - rising[0] + 1) * PERIOD

    @property
    def warmest(self) -> tuple[str, float]:
        """Node, the motor's called so, and degC at its warmest in the last cycle."""
        peaks = self.last_temperatures.max(axis=0) - ZERO_CELSIUS
        at = int(np.argmax(peaks))
        name = NODES[at].replace("_", " ")
        return (f"electric motor ({name})" if NODES[at] in MOTOR_NODES else name), float(peaks[at])

    @property
    def warmest_hydraulic(self) -> tuple[str, float]:
        """The same of all nodes but the motor's."""
        peaks = self.last_temperatures.max(axis=0) - ZERO_CELSIUS
        at = max((i for i, node in enumerate(NODES) if node not in MOTOR_NODES), key=lambda i: peaks[i])
        return NODES[at].replace("_", " "), float(peaks[at])


def read_as(name: str, rig: Rig, rpm: float, ambient: float) -> Reading:
    """Twenty cycles from everything at ambient; the first `SHOWN_CYCLES` and the last are kept whole."""
    speed, stroke = rpm * RAD_PER_S_OF_RPM, rig["cylinder.stroke"]
    least = rpm * rpm * rig["pump_1.displacement"] / 60.0 / piston_area(rig.parameters[0]) / (0.2 * stroke)
    ramp = max(RAMP_RPM, least) * RAD_PER_S_OF_RPM
    cycle = (
        Segment("dwell", 0.0, 0.0, DWELL), Segment("lift", speed, stroke - MARGIN, 60.0),
        Segment("dwell", 0.0, 0.0, DWELL), Segment("lower", speed, MARGIN, 60.0),
    )
    temperature = ambient + ZERO_CELSIUS
    duty = Duty(rig["load.payload_mass"], np.zeros(1), np.full(1, temperature), MARGIN, ramp, 0, cycle)
    run = DutyRun(rig, duty, temperature, temperature, period=PERIOD)
    points, temperatures, ends, durations = [], [], [], []
    for k in range(CYCLES):
        one = run.cycle(longest=120.0, keep=k < SHOWN_CYCLES or k == CYCLES - 1)
        ends.append(run.temperature.copy())
        durations.append(one.duration)
        if k < SHOWN_CYCLES:
            points.append(one.points)
            temperatures.append(one.temperatures)
    joined = np.concatenate(points)
    return Reading(
        name, rpm, PERIOD * np.arange(1, joined.size + 1), joined, np.concatenate(temperatures), one.points, one.temperatures,
        float(np.mean(durations)), temperature, np.array(ends),
    )


def _at_speed(speed: np.ndarray, full: float) -> slice:
    near = np.flatnonzero(speed > 0.99 * full)
    if not near.size:
        return slice(0, speed.size)
    gap = np.flatnonzero(np.diff(near) > 1)
    return slice(int(near[0]), int(near[gap[0]] if gap.size else near[-1]) + 1)
