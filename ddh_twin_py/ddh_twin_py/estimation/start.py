"""Temperatures at the start of a run, from the few that are read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ddh_twin_py.estimation.sensors import NODE_OF_SENSOR, SENSORS
from ddh_twin_py.estimation.temperature_fusion import Reading, Readings
from ddh_twin_py.physics.thermal_network import NODES

START = 3.0
"""s of readings at the beginning that tell where a run starts."""
EARLY = 60.0
"""s of readings that tell it better, once a first run says how the temperature went on from there."""
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
    "line_a_wall": _OIL,
    "line_b_wall": _OIL,
    "tank_wall": _OIL,
    "valve_block": _OIL,
    "valve_oil": _OIL,
    "chamber_a_oil": ("cylinder_barrel", "line_a_wall", *_OIL),
    "chamber_b_oil": ("cylinder_barrel", "line_b_wall", *_OIL),
    "cylinder_barrel": _OIL,
    "line_a_oil": ("line_a_wall", *_OIL),
    "line_b_oil": ("line_b_wall", *_OIL),
    "pump_1_case": ("pump_2_case", *_OIL),
    "pump_2_case": ("pump_1_case", *_OIL),
    "pump_1_oil": ("pump_1_case", *_OIL),
    "pump_2_oil": ("pump_2_case", *_OIL),
    "tank_oil_top": _OIL,
    "tank_oil": _OIL,
}


def spread_start(read: Mapping[str, float], ambient: float, rise: np.ndarray | None = None) -> np.ndarray:
    """Temperature of every node, K, (N,): its own reading, else its nearest neighbour's, else ambient.

    Args:
        read: node to K, of those that a sensor reads. ambient: K. rise: above ambient that a likely history gives
            every node, K, (N,): a neighbour's reading is moved by what the two differ in it; None: by nothing.
    """
    likely = np.zeros(len(NODES)) if rise is None else rise
    start = ambient + likely
    for i, node in enumerate(NODES):
        for candidate in (node, *_NEIGHBOURS[node]):
            if candidate in read:
                start[i] = read[candidate] + likely[i] - likely[NODES.index(candidate)]
                break
    return start


def start_temperature(readings: Sequence[Reading] | Readings, ambient: float, interval: float,
                      zero: np.ndarray | None = None) -> np.ndarray:
    """Temperature of every node at the start, K, (N,): means of the readings of the first `START` seconds.

    Args:
        readings: index counted from the start. ambient: K. interval: s. zero: K, what is known of
            each of `SENSORS`' zero errors, taken off; None: nothing.
    """
    given = readings if isinstance(readings, Readings) else Readings.of(readings)
    early = given.index * interval <= START
    known = np.zeros(len(SENSORS)) if zero is None else zero
    read = {NODE_OF_SENSOR[SENSORS[k]]: float(given.temperature[early & (given.sensor == k)].mean() - known[k])
            for k in np.unique(given.sensor[early])}
    return spread_start(read, ambient)


def start_error(time: np.ndarray, off: np.ndarray, change: float, noise: float, lag: float,
                behind: float) -> tuple[float, float, float]:
    """How far a run's node, and its sensor, begin below what they were, and the standard deviation of the former, K.

    off = a (1 - e) + d e + b t, e = exp(-t/lag): a of the node, d of the sensor, which follows it, b t of what the run's parameters
    are off by; b ~ N(0, (0.15 change / `EARLY`)^2), d - a ~ N(0, behind^2).

    Args:
        time: s since the start, (n,), up to `EARLY`. off: readings less those of the run, K, (n,).
        change: of the run's reading over `EARLY`, K. noise: of one reading, K. lag: of the sensor, s.
        behind: K by which the sensor may lag behind its node at the start.
    """
    fading = np.exp(-time / lag)
    rows = np.column_stack([1.0 - fading, fading, time / EARLY])
    prior = np.diag([0.0, 0.0, noise**2 / max(_RISE_KNOWN * change, 1.0e-6) ** 2])
    prior[:2, :2] += (noise / behind) ** 2 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    covariance = np.linalg.inv(rows.T @ rows + prior)
    of_node, of_sensor, _ = covariance @ (rows.T @ off)
    return float(of_node), float(of_sensor), noise * float(np.sqrt(covariance[0, 0]))
