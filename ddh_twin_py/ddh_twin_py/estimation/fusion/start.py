"""Temperatures at the start of a run, from the few that are read."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fusion.inputs import Reading, Readings
from ddh_twin_py.estimation.fusion.outvoted import outvoted
from ddh_twin_py.estimation.fusion.temperature_filter import AGREEING
from ddh_twin_py.estimation.sensors import NODE_OF_SENSOR, SENSORS
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.sensor_errors import temperature_zero_errors
from ddh_twin_py.twin.temperature_sensors import sensed

START = 3.0
"""s of readings at the beginning that tell where a run starts."""
EARLY = 60.0
"""s of readings that tell it better, once a first run says how the temperature went on from there."""
UNDRIVEN = 30.0
"""s without telemetry after which readings tell anew how warm a unit is: nobody knows what it did meanwhile."""
_RISE_KNOWN = 0.15  # of the first run's own change, how well it knows that over `EARLY`

_OIL = ("tank_oil", "cylinder_barrel", "tank_wall", "pump_2_case", "pump_1_case", "line_b_wall", "line_a_wall")
"""What the oil flows through and a sensor reads, nearest to the oil's mean first; the walls of lines cool soonest."""

_NEIGHBOURS = {
    "slot_winding": ("end_winding", "housing"),
    "end_winding": ("housing",),
    "teeth": ("housing", "end_winding"),
    "rotor": ("housing", "end_winding"),
    "yoke": ("housing", "end_winding"),
    "housing": ("end_winding",),
    "line_a_wall": ("line_b_wall", *_OIL),
    "line_b_wall": ("line_a_wall", *_OIL),
    "tank_wall": _OIL,
    "valve_block": _OIL,
    "valve_oil": _OIL,
    "chamber_a_oil": ("cylinder_barrel", "line_a_wall", *_OIL),
    "chamber_b_oil": ("cylinder_barrel", "line_b_wall", *_OIL),
    "cylinder_barrel": _OIL,
    "line_a_oil": ("line_a_wall", "line_b_wall", *_OIL),
    "line_b_oil": ("line_b_wall", "line_a_wall", *_OIL),
    "pump_1_case": ("pump_2_case", *_OIL),
    "pump_2_case": ("pump_1_case", *_OIL),
    "pump_1_oil": ("pump_1_case", *_OIL),
    "pump_2_oil": ("pump_2_case", *_OIL),
    "tank_oil_top": _OIL,
    "tank_oil": _OIL,
}


def air_at_start(air: np.ndarray, interval: float) -> float:
    """Air, K, that the first readings were made in, of that of each interval, (n,), of so many s."""
    return float(air[min(air.size - 1, round(START / interval))])


def spread_start(read: Mapping[str, float], ambient: float, rise: np.ndarray | None = None) -> np.ndarray:
    """Temperature of every node, K, (N,): its own reading, else its nearest neighbour's, else ambient.

    Args:
        read: node to K, of those that a sensor reads. ambient: K. rise: above ambient that a likely history gives
            every node, K, (N,): a neighbour's reading is moved by what the two differ in it; None: by nothing.
    """
    likely = np.zeros(len(NODES)) if rise is None else rise
    start = ambient + likely
    for i, node in enumerate(NODES):
        source = _source(node, read)
        if source is not None:
            start[i] = read[source] + likely[i] - likely[NODES.index(source)]
    return start


def start_temperature(readings: Sequence[Reading] | Readings, ambient: float, interval: float,
                      zero: np.ndarray | None = None, within: float = START) -> np.ndarray:
    """Temperature of every node at the start, K, (N,): of each sensor the mean over `START` from its first reading on.

    Readings farther than `AGREEING` from the median, as one wrong one is, do not count, nor does a sensor that is `outvoted`.

    Args:
        readings: index counted from the start. ambient: K. interval: s. zero: K, what is known of
            each of `SENSORS`' zero errors, taken off; None: nothing. within: s of readings that count.
    """
    early = _within(readings, interval, within)
    known = np.zeros(len(SENSORS)) if zero is None else zero
    told = np.full(len(SENSORS), np.nan)
    for k, temperature in _telling(early, interval):
        told[k] = _agreed(temperature)
    heard = np.flatnonzero(np.isfinite(told) & ~outvoted(told, ambient))
    read = {NODE_OF_SENSOR[SENSORS[k]]: float(told[k] - known[k]) for k in heard}
    return spread_start(read, ambient)


def _telling(early: Readings, interval: float) -> Iterator[tuple[int, np.ndarray]]:
    """Of each sensor its readings, K, over `START` from the first on."""
    for k in np.unique(early.sensor).tolist():
        index, temperature = early.index[early.sensor == k], early.temperature[early.sensor == k]
        yield k, temperature[(index - index[0]) * interval <= START]


def _agreed(temperature: np.ndarray) -> float:
    """Mean of those readings, K, (n,), that are within `AGREEING` of their median; the median where none is."""
    median = float(np.median(temperature))
    near = temperature[np.abs(temperature - median) <= AGREEING]
    return float(near.mean()) if near.size else median


def _agree(temperature: np.ndarray) -> bool:
    """Whether two readings in a row, K, (n,), say the same."""
    return bool(np.any(np.abs(np.diff(temperature)) <= AGREEING))


def _within(readings: Sequence[Reading] | Readings, interval: float, within: float) -> Readings:
    """The readings of the first ``within`` seconds."""
    given = readings if isinstance(readings, Readings) else Readings.of(readings)
    return given.between(0, _intervals(within, interval))


def _intervals(within: float, interval: float) -> int:
    """How many intervals hold the readings of the first ``within`` seconds."""
    return int(within / interval + 1.0e-9) + 1


@dataclass(frozen=True)
class _Doubted:
    """A reading that the sensor's next has not confirmed yet: K, and whether a model is as warm as it says."""

    temperature: float
    moved: bool


@dataclass(frozen=True)
class Told:
    """A reading that tells how warm a model is: before which interval, of which sensor, K, and the nodes that move by it, bool (N,)."""

    row: int
    sensor: str
    temperature: float
    nodes: np.ndarray
    top_share: float

    def move(self, *temperatures: np.ndarray) -> None:
        """Put temperatures, K, (N,) each, to it, in place."""
        for temperature in temperatures:
            temperature[self.nodes] += self.temperature - sensed(temperature, self.sensor, self.top_share)


class Undriven:
    """For how long it was not known what drives a model; ``least``: intervals of that which count."""

    def __init__(self, least: int) -> None:
        self._least, self._intervals = least, 0

    def again(self, driven: np.ndarray) -> list[tuple[int, int]]:
        """With which of n intervals that follow those before, bool (n,), a model is driven again, and after how many."""
        if driven.all() and not self._intervals:
            return []
        again = []
        for row, known in enumerate(driven.tolist()):
            if known and self._intervals >= self._least:
                again.append((row, self._intervals))
            self._intervals = 0 if known else self._intervals + 1
        return again


class FirstReadings:
    """Tells which readings move a model that goes on by itself otherwise; the first it is given to follow are those that told the start.

    The first of each sensor that was silent while the start was told, within `EARLY` of it, and of each sensor after
    `UNDRIVEN` in which nothing was known of what drives the model. A first one that the sensor's next does not confirm, within
    `AGREEING`, was none: the model is moved again, by the first two in a row that agree within as long once more.

    Args:
        rig: the rig. interval: s. readings: index counted from the start. within: s of them that told the start.
    """

    def __init__(self, rig: Rig, interval: float, readings: Sequence[Reading] | Readings, within: float = START) -> None:
        self._zero, self._top_share = temperature_zero_errors(rig)[0], rig["tank.top_share"]
        telling = dict(_telling(_within(readings, interval, within), interval))
        self._heard = {k for k, temperature in telling.items() if _agree(temperature)}
        self._doubted = {k: _Doubted(float(temperature[-1]), temperature.size == 1)
                         for k, temperature in telling.items() if k not in self._heard}
        self._early, self._undriven = round(EARLY / interval), Undriven(round(UNDRIVEN / interval))
        self._until = self._early  # interval up to which a first reading counts, from the first that comes next
        self._telling = _intervals(within, interval)  # intervals that come next, whose readings told the start

    def follow(self, driven: np.ndarray, readings: Readings) -> list[Told]:
        """What moves the model in n intervals that follow those before.

        Args:
            driven: whether it is known what drives the model, bool (n,). readings: index within these intervals.
        """
        anew = [row for row, _ in self._undriven.again(driven)]
        told = []
        for row, sensor, temperature in zip(readings.index.tolist(), readings.sensor.tolist(), readings.temperature.tolist(), strict=True):
            while anew and anew[0] <= row:
                self._ask_anew(anew.pop(0))
            late = self._until + self._early if sensor in self._doubted else self._until
            if self._telling <= row < late and sensor not in self._heard:
                told += self._listen(row, sensor, temperature)
        for row in anew:
            self._ask_anew(row)
        self._until -= driven.size
        self._telling = 0
        return told

    def _ask_anew(self, row: int) -> None:
        """From interval ``row`` on each sensor's first reading counts again."""
        self._until = row + self._early
        self._heard.clear()
        self._doubted.clear()

    def _listen(self, row: int, sensor: int, temperature: float) -> list[Told]:
        """What a reading, K, of a sensor that is not believed yet moves."""
        before = self._doubted.pop(sensor, None)
        confirmed = before is not None and abs(temperature - before.temperature) <= AGREEING
        moves = before is None or confirmed and not before.moved
        if confirmed:
            self._heard.add(sensor)
        else:
            self._doubted[sensor] = _Doubted(temperature, moves)
        return [self._told(row, sensor, temperature)] if moves else []

    def _told(self, row: int, sensor: int, temperature: float) -> Told:
        node, heard = NODE_OF_SENSOR[SENSORS[sensor]], {NODE_OF_SENSOR[SENSORS[k]] for k in (*self._heard, *self._doubted)}
        nodes = np.array([_source(i, heard) == node for i in NODES])
        return Told(row, SENSORS[sensor], temperature - float(self._zero[sensor]), nodes, self._top_share)


def _source(node: str, read: Collection[str]) -> str | None:
    """The node that is read of which another takes its temperature, None where nothing near is read."""
    return next((candidate for candidate in (node, *_NEIGHBOURS[node]) if candidate in read), None)


def start_error(time: np.ndarray, off: np.ndarray, change: float, noise: float, lag: float,
                behind: float, otherwise: np.ndarray) -> tuple[float, float, float]:
    """How far a run's node, and its sensor, begin below what they were, and the standard deviation of the former, K.

    off = a (1 - e) + d e + b t + w c, e = exp(-t/lag): a of the node, d of the sensor, which follows it, b t of what the run's parameters
    are off by, w c of what no sensor reads; b ~ N(0, (0.15 change / `EARLY`)^2), d - a ~ N(0, behind^2), w ~ N(0, 1).

    Args:
        time: s since the start, (n,), up to `EARLY`. off: readings less those of the run, K, (n,).
        change: of the run's reading over `EARLY`, K. noise: of one reading, K. lag: of the sensor, s.
        behind: K by which the sensor may lag behind its node at the start.
        otherwise: c, K, by how much the run would read otherwise if what no sensor reads began so, (n, ways).
    """
    fading = np.exp(-time / lag)
    rows = np.column_stack([1.0 - fading, fading, time / EARLY, otherwise])
    prior = np.diag([0.0, 0.0, noise**2 / max(_RISE_KNOWN * change, 1.0e-6) ** 2, *[noise**2] * otherwise.shape[1]])
    prior[:2, :2] += (noise / behind) ** 2 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    covariance = np.linalg.inv(rows.T @ rows + prior)
    of_node, of_sensor = (covariance @ (rows.T @ off))[:2]
    return float(of_node), float(of_sensor), noise * float(np.sqrt(covariance[0, 0]))
