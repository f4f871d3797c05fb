"""What the plant's sensors and clocks make of a course: zeros, lags, steps, noise, jitter, gaps.

Zeros and lags belong to the sensors of one machine and stay from one recording to the next.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.plant import heat
from ddh_twin_py.plant.compiled import done, kernel
from ddh_twin_py.plant.machine import TEMPERATURE_GRID, Course
from ddh_twin_py.plant.run import FAST
from ddh_twin_py.rig import Rig

SENSORS = (*heat.READS, "ambient")
"""Temperature sensors that a machine may have; `ambient` is always there."""
_INNER = ("motor_winding", "tank_oil", "ambient")
_STEPS = {"speed": 0.01, "current": 0.005, "voltage": 0.1, "electrical_power": 1.0, "pressure": 4.0e7 / 2**15,
          "rod_position": 5e-5, "rod_velocity": 1e-4, "temperature": 0.01}
"""Smallest step of a reading."""
_JITTER = 4.0e-4  # s, deviation of a stamp
_SKIPPED, _BROKEN, _LATE = 5e-4, 1e-4, 4e-4  # shares of messages: missing, NaN, arriving late
_LATEST = 0.3  # s
_COLUMN = {name: k for k, name in enumerate(FAST)}


@dataclass(frozen=True)
class Instruments:
    """The sensors of one machine.

    Attributes:
        zeros: K, by temperature sensor. lags: s, the same. pressure_zeros: Pa, piston side and rod side.
        torque_constant: N*m/A that the drive reckons with. noise: deviation of one sample, by kind.
    """

    zeros: dict[str, float]
    lags: dict[str, float]
    pressure_zeros: tuple[float, float]
    torque_constant: float
    noise: dict[str, float]

    @classmethod
    def drawn(cls, sheet: Rig, lag: float, rng: np.random.Generator) -> Instruments:
        """Zeros within the sheet's tolerance, lags about ``lag``, s."""
        temperature, pressure = sheet.sensors["temperature"], sheet.sensors["pressure"]

        def cut() -> float:
            return float(np.clip(rng.standard_normal(), -2.5, 2.5))

        return cls(
            {name: temperature.offset_tolerance * cut() for name in SENSORS},
            {name: lag * (1.0 + 0.1 * cut()) for name in SENSORS},
            (pressure.offset_tolerance * cut(), pressure.offset_tolerance * cut()),
            sheet["motor.torque_constant"], {kind: spec.noise for kind, spec in sheet.sensors.items()},
        )


@dataclass(frozen=True)
class Readings:
    """Streams in the order of arrival: stamps (s) and values; temperatures in K.

    Attributes:
        drive: (n, 6) speed_command, speed, torque, current, voltage, electrical_power.
        hydraulic: (n, 4) pressure_piston_side, pressure_rod_side, rod_position, rod_velocity.
    """

    drive: tuple[np.ndarray, np.ndarray]
    hydraulic: tuple[np.ndarray, np.ndarray]
    temperatures: dict[str, tuple[np.ndarray, np.ndarray]]


def ideal(course: Course, instruments: Instruments, ambient: np.ndarray, when: np.ndarray) -> dict[str, np.ndarray]:
    """Readings without noise, steps and gaps: fast signals at the course's own times, temperatures at ``when`` (s).

    Args:
        ambient: K, once per second.
    """
    e = course.condition[0]
    drive = {name: course.drive[:, _COLUMN[name]] for name in FAST[:5]}
    current = drive["current"] * e["current_gain"] + e["current_zero"]
    shift = e["current_zero"] * drive["speed"] * instruments.torque_constant
    out = {
        "speed_command": drive["speed_command"], "speed": drive["speed"], "torque": current * instruments.torque_constant,
        "current": current, "voltage": drive["voltage"], "electrical_power": drive["electrical_power"] * e["current_gain"] + shift,
    }
    fluid = {name: course.hydraulic[:, _COLUMN[name]] for name in FAST[5:]}
    out["pressure_piston_side"] = fluid["pressure_piston_side"] + e["zero_a"] + instruments.pressure_zeros[0]
    out["pressure_rod_side"] = fluid["pressure_rod_side"] * e["span_b"] + e["zero_b"] + instruments.pressure_zeros[1]
    out["pressure_rod_side"] = out["pressure_rod_side"] + e["pressure_drift"] * course.hydraulic_time
    out["rod_position"] = (fluid["rod_position"] - fluid["slipped"]) * e["rod_scale"]
    out["rod_velocity"] = fluid["rod_velocity"] * e["rod_scale"]
    grid = TEMPERATURE_GRID * np.arange(course.temperatures.shape[0])
    air = np.interp(grid, np.arange(ambient.size), ambient)
    for name in SENSORS:
        true = air if name == "ambient" else sum(
            weight * course.temperatures[:, heat.NODES.index(node)] for node, weight in heat.READS[name].items())
        lag = instruments.lags[name]
        if name not in _INNER:
            true = true + e["surface_share"] * (air + e["enclosure"] - true)
            lag = e["surface_lag"] * lag / float(course.params["sensors_temperature_time_constant"][0]) if e["surface_lag"] > 0.0 else lag
        read = np.empty_like(true)
        follow(true, TEMPERATURE_GRID / lag, read)
        if name == "motor_housing":
            read = read + e["drift"] * grid + e["housing_gain"] * (read - 293.15)
        out[f"temperature/{name}"] = np.interp(when, grid, read) + instruments.zeros[name]
    return out


@kernel
def follow(true, share, read):
    """First-order lag; ``share`` is the time step over the time constant."""
    keep = np.exp(-share)
    value = true[0]
    for i in range(true.size):
        value = true[i] + (value - true[i]) * keep
        read[i] = value


def measure(course: Course, instruments: Instruments, ambient: np.ndarray, sensors: Sequence[str], rate: float,
            rng: np.random.Generator) -> Readings:
    """Readings as a recorder would get them.

    Args:
        ambient: K, once per second. sensors: temperature sensors that exist. rate: Hz of each.
    """
    noise = instruments.noise
    when = np.arange(0.5, TEMPERATURE_GRID * (course.temperatures.shape[0] - 2) - 1.0 / rate, 1.0 / rate)
    clean = ideal(course, instruments, ambient, when)

    def read(name: str, kind: str) -> np.ndarray:
        values = clean[name] + rng.normal(0.0, noise[kind], clean[name].size)
        return _STEPS[kind] * np.round(values / _STEPS[kind])

    current = read("current", "current")
    drive = np.column_stack([clean["speed_command"], read("speed", "speed"), instruments.torque_constant * current, current,
                             read("voltage", "voltage"),
                             read("electrical_power", "electrical_power")])
    hydraulic = np.column_stack([read("pressure_piston_side", "pressure"), read("pressure_rod_side", "pressure"),
                                 read("rod_position", "rod_position"), read("rod_velocity", "rod_velocity")])
    skew = float(course.condition["skew"][0])
    temperatures = {}
    for name in SENSORS:
        if name in sensors or name == "ambient":
            own = rng.uniform(0.0, 0.5 / rate)
            values = np.interp(when + own, when, clean[f"temperature/{name}"]) + rng.normal(0.0, noise["temperature"], when.size)
            stamps, rows = _arrive(when + own, _STEPS["temperature"] * np.round(values / _STEPS["temperature"])[:, None], rng, 0.02)
            temperatures[name] = stamps, rows[:, 0]
    return Readings(_arrive(course.drive_time, drive, rng, _JITTER), _arrive(course.hydraulic_time + skew, hydraulic, rng, _JITTER),
                    temperatures)


def _arrive(stamps: np.ndarray, rows: np.ndarray, rng: np.random.Generator, jitter: float) -> tuple[np.ndarray, np.ndarray]:
    """Stamps with jitter, a few messages missing, broken or late; in the order of arrival."""
    stamps = np.maximum(stamps + np.clip(rng.normal(0.0, jitter, stamps.size), -4.0 * jitter, 4.0 * jitter), 0.0)
    kept = rng.random(stamps.size) >= _SKIPPED
    broken = rng.random(stamps.size) < _BROKEN
    rows = rows.copy()
    if rows.shape[1] > 1:
        rows[broken, rng.integers(1, rows.shape[1], int(broken.sum()))] = np.nan
    late = np.where(rng.random(stamps.size) < _LATE, rng.uniform(0.0, _LATEST, stamps.size), 0.0)
    order = np.argsort((stamps + late)[kept], kind="stable")
    return stamps[kept][order], rows[kept][order]


done()
