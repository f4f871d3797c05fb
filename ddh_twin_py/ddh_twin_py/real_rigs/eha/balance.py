"""Flow balance of the loaded side over short windows: what the pump gave, less what the rod, a leak and soft sides took."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.real_rigs.eha.model import BORE, DESCRIPTION, STROKE, delayed, smoothed
from ddh_twin_py.real_rigs.eha.recordings import STEP, Actuation

WINDOW = 0.1
"""s."""
LEAST = 0.3e-6
"""m3 that the sheet's pump moves in a window in which it counts as moving."""
_SMOOTH = 7  # samples over which pressures are averaged at the ends of a window
_AIR_PRESSURE = 101325.0


def balance(record: Actuation, p: np.void) -> tuple[np.ndarray, np.ndarray]:
    """Volume left over in each window, m3, (m,), and in which the pump moves, (m,).

    Args:
        p: parameter record; see `ideal` for sides without leak or softness.
    """
    many = round(WINDOW / STEP)
    area_a = np.pi / 4.0 * BORE**2
    area_b = area_a - np.pi / 4.0 * float(p["rod"]) ** 2
    edges = np.arange(0, record.time.size - 1, many)
    held = delayed(record.valve, float(p["switching"]), held=True)
    side = np.sign(held + 0.5)
    skew = float(p["skew"])
    speed = delayed(record.speed, skew + float(p["late"]))
    read_a, read_b = (smoothed(values - float(p[name]), _SMOOTH) for values, name in (
        (record.pressure_a, "offset_a"), (record.pressure_b, "offset_b")))
    # everything as late as the position is: the speed and the pressures are brought to its time
    a, b = (delayed(values, float(p["late"])) for values in (read_a, read_b))
    loaded, other = np.where(side > 0.0, a, b), np.where(side > 0.0, b, a)
    position = record.position / float(p["scale"])
    flow = side * float(p["displacement"]) * speed / (2.0 * np.pi) - float(p["leakage"]) * (loaded - other)
    pumped = np.concatenate([[0.0], np.cumsum(flow)])
    area = np.where(side > 0.0, area_a, area_b)
    volume = float(p["dead_volume"]) + np.where(side > 0.0, area_a * np.maximum(position, 0.0), area_b * np.maximum(STROKE - position, 0.0))
    absolute = np.maximum(loaded + _AIR_PRESSURE, 2e4)
    soft = volume * (1.0 / float(p["bulk_modulus"]) + float(p["air"]) * _AIR_PRESSURE / absolute**2) + float(p["line"])
    first, last = edges[:-1], edges[1:]
    middle = (first + last) // 2
    given = STEP * (pumped[last] - pumped[first])
    taken = side[middle] * area[middle] * (position[last] - position[first]) + soft[middle] * (loaded[last] - loaded[first])
    turned = 1.6e-6 / (2.0 * np.pi) * STEP * np.abs(np.add.reduceat(record.speed, edges))[:-1]
    switched = np.array([np.ptp(side[i : j + 1]) > 0.0 for i, j in zip(first, last, strict=True)])
    return np.where(switched, np.nan, given - taken), turned > LEAST


def ideal() -> np.ndarray:
    """The record (1,) of the sheet with an ideal side: no leak, no softness."""
    out = DESCRIPTION.record()
    out["leakage"], out["line"], out["air"], out["bulk_modulus"] = 0.0, 0.0, 0.0, np.inf
    return out
