"""Two tanks in Torricelli flow, the upper filled by a pump, and what they may have beside it.

    dx1/dt = pump f(u) - ratio outlet g(x1) - leak sqrt(x1) - overflow
    dx2/dt = ratio outlet g(x1) + share overflow - outlet g(x2),        f(u) = u, g(x) = sqrt(x) without effects

Levels are in volts of the lower tank's sensor; both tanks have the same area. y = min(x2, limit) + offset.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import MOVING, SMOOTH, STEADY, STROKES, Discrepancy
from ddh_twin_py.gap.effect import Effect, added, fixed, value_of
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.real_rigs.cascaded_tanks.recordings import SOURCE, STEP, TankRecord
from ddh_twin_py.real_rigs.description import Description, Parameter
from ddh_twin_py.real_rigs.run import Run
from ddh_twin_py.real_rigs.signals import signal
from ddh_twin_py.rig.sheet import CUT

NOISE = 0.1
"""V: 1 % of the sensor's range, which a free run is not expected to undercut; readings themselves scatter by less."""
BLOCK, EVERY = 64, 4
"""Samples of a block, and which block of the identification record takes no part in finding and may refute: every fourth. A block of
256 s is longer than the time constants of both tanks together (some 150 s): its middle does not follow from the samples around it."""
NOTHING_FORGIVEN = Discrepancy(dict.fromkeys((STEADY, MOVING, SMOOTH, STROKES), 1e-6))
"""Stretches for which classes are forgiven (120 s) are as long as the tanks' own time constants: it would be the levels' own motion."""
_STEPS = 8  # in a sample
_PUMP, _LEVEL = 3.0, 5.0
"""V, middle of the ranges: effects on the shape of a law leave its value there as it is, which parameters have set."""

PARAMETERS = (
    Parameter("pump", 0.05, 0.03, "1/s", "fills a tank of 10 V in some minutes", 1e-3),
    Parameter("outlet", 0.05, 0.03, "V^0.5/s", "empties a tank of 10 V in some minutes", 1e-3),
    Parameter("outlet_ratio", 1.0, 0.1, "1", "upper over lower outlet: tanks of one build", 0.2),
    Parameter("start_1", 5.0, 2.0, "V", "anywhere in a tank of 10 V", 0.0),
    Parameter("start_2", 5.0, 1.0, "V", "near the first readings", 0.0),
    Parameter("overflow_share", 0.5, 0.3, "1", "what the lower tank gets of an overflow; without one it has no part", 0.0, 1.0),
)
NEUTRAL = {"inverse_rim_1": 0.0, "inverse_rim_2": 0.0, "inverse_limit": 0.0, "exponent": 0.5, "curvature": 0.0, "threshold": 0.0,
           "head": 0.0,
           "leak": 0.0, "offset": 0.0}
"""A rim or limit is given by its inverse, which is 0 where it is never reached."""


def _spilled(record: np.ndarray, x: float) -> None:
    """All of the overflow is lost."""
    record["inverse_rim_1"] += x
    record["overflow_share"] *= 0.0 if x != 0.0 else 1.0


def _effect(id: str, domain: str, parameter: str, unit: str, laws, step: float, lowest: float, highest: float, about: str, law: str,
            reference=None) -> Effect:
    return Effect(id, id.split(".")[0], domain, parameter, unit, reference or fixed(0.0), laws, step, lowest, highest, about, law)


EFFECTS = (
    _effect("upper_tank.overflow", "hydraulic", "inverse_rim", "1/V", (added("inverse_rim_1"), _spilled), 0.08, 0.0, 0.125,
            "The upper tank runs over at high level; a share of it, or nothing, falls into the lower one.",
            "x1 stays at the rim; what is too much goes to the lower tank by its share"),
    _effect("lower_tank.overflow", "hydraulic", "inverse_rim", "1/V", (added("inverse_rim_2"),), 0.08, 0.0, 0.1,
            "The lower tank runs over at high level.", "x2 stays at the rim"),
    _effect("sensor.saturation", "measurement", "inverse_limit", "1/V", (added("inverse_limit"),), 0.08, 0.0, 0.1,
            "The level sensor reads no more than a limit.", "y = min(x2, limit)"),
    _effect("sensor.offset", "measurement", "offset", "V", (added("offset"),), 0.1, -2.0, 2.0,
            "The level sensor has a zero error.", "y = x2 + offset"),
    _effect("outlet.head", "hydraulic", "head", "V", (added("head"),), 0.5, -1.0, 10.0,
            "The outlets end below the level at which the sensor reads zero.", "flow ~ sqrt(x + head)"),
    _effect("outlet.exponent", "hydraulic", "exponent", "1", (added("exponent"),), 0.02, -0.3, 0.5,
            "The outlets do not follow Torricelli's square root: pipe friction, a partly filled outlet.", "flow ~ x^n",
            value_of("exponent")),
    _effect("pump.curvature", "hydraulic", "curvature", "1/V", (added("curvature"),), 0.02, -0.2, 0.2,
            "The pump's flow grows more or less than in proportion to its voltage.", "flow ~ u (1 + curvature (u - 3 V))"),
    _effect("pump.threshold", "hydraulic", "threshold", "V", (added("threshold"),), 0.1, 0.0, 2.5,
            "The pump delivers nothing below a voltage.", "flow ~ max(u - threshold, 0)"),
    _effect("upper_tank.leak", "hydraulic", "leak", "V^0.5/s", (added("leak"),), 1e-3, 0.0, 0.1,
            "The upper tank loses water that does not reach the lower one.", "leak sqrt(x1)"),
)
DESCRIPTION = Description("cascaded tanks", SOURCE, PARAMETERS, NEUTRAL, EFFECTS, {"level": ("lower_tank", "hydraulic")}, (
    "Both records begin at the same unknown levels, as the benchmark says.",
    "A leak of the lower tank cannot be told from a wider outlet and is not listed.",
), CUT)


class Tanks(Run):
    """One record, simulated from the pump's voltage alone; signal ``level`` of the lower tank, V.

    Args:
        record: as read. used: samples that are compared, (n,); None is all.
    """

    def __init__(self, record: TankRecord, used: np.ndarray | None = None) -> None:
        self.name, self.record = record.name, record
        self.time = STEP * np.arange(record.level.size)
        level = record.level if used is None else np.where(used, record.level, np.nan)
        kind = np.digitize(record.level, np.quantile(record.level, (1.0 / 3.0, 2.0 / 3.0)))
        self.signals = {"level": signal(self.time, level, NOISE, "V", None, kind)}

    def levels(self, record: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Levels of both tanks at the samples, V, (n,) each, from a parameter record (1,)."""
        upper, lower = np.empty(self.time.size), np.empty(self.time.size)
        _run(record[0], self.record.pump, upper, lower)
        return upper, lower

    def predict(self, record: np.ndarray) -> dict[str, np.ndarray]:
        return {"level": np.minimum(self.levels(record)[1], _height(record["inverse_limit"][0])) + record["offset"][0]}

    def variables(self, record: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        upper, lower = self.levels(record)
        return {"upper level, V": (self.time, upper), "lower level, V": (self.time, lower), "pump, V": (self.time, self.record.pump)}


def held_blocks(size: int) -> np.ndarray:
    """Which samples of a record are held out, (size,)."""
    return (np.arange(size) // BLOCK) % EVERY == EVERY - 1


@kernel
def _height(inverse):
    """A rim or limit, V."""
    return 1.0 / inverse if inverse > 0.0 else np.inf


@kernel
def _flow(p, x):
    """Flow of an outlet over its coefficient, V^0.5; as Torricelli's at 5 V whatever its shape is."""
    return _LEVEL**0.5 * (max(x + p["head"], 0.0) / (_LEVEL + p["head"])) ** p["exponent"] if x > 0.0 else 0.0


@kernel
def _run(p, pump, upper, lower):
    """Heun's method; a level above its rim is brought back to it and the rest spilled."""
    h = STEP / _STEPS
    x1, x2 = max(p["start_1"], 0.0), max(p["start_2"], 0.0)
    rim_1, rim_2 = _height(p["inverse_rim_1"]), _height(p["inverse_rim_2"])
    lower_outlet = p["outlet"]
    upper_outlet = p["outlet_ratio"] * lower_outlet
    for k in range(pump.size):
        upper[k], lower[k] = x1, x2
        u = max(pump[k] - p["threshold"], 0.0) * _PUMP / (_PUMP - p["threshold"])
        filled = p["pump"] * max(u * (1.0 + p["curvature"] * (u - _PUMP)), 0.0)
        for _ in range(_STEPS):
            out = upper_outlet * _flow(p, x1)
            a1, a2 = filled - out - p["leak"] * np.sqrt(x1), out - lower_outlet * _flow(p, x2)
            y1, y2 = max(x1 + h * a1, 0.0), max(x2 + h * a2, 0.0)
            out = upper_outlet * _flow(p, y1)
            b1, b2 = filled - out - p["leak"] * np.sqrt(y1), out - lower_outlet * _flow(p, y2)
            x1, x2 = max(x1 + 0.5 * h * (a1 + b1), 0.0), max(x2 + 0.5 * h * (a2 + b2), 0.0)
            spilled = max(x1 - rim_1, 0.0)
            x1 -= spilled
            x2 = min(x2 + p["overflow_share"] * spilled, rim_2)
