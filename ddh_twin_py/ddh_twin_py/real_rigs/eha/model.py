"""The electro-hydraulic actuator: parameters, effects, and its free run from pump speed and valve (`run.Run`).

The pump moves oil between the sides, the valve joins the side that carries no load (low) to the accumulator. Of the loaded side s

    d(W)/dt = sigma D omega/(2 pi) - L (p_s - p_low),      sigma A_s dx + C_s(p_s) dp_s = dW
    C_s = V_s (1/K + phi p_0/p^2) + C_line,      sigma = 1 (s = a, extending), -1 (s = b, retracting)

The load is a brake: the rod stands while p_s is below what the load asks, and then moves with it. What it asks grows with the way s since
the last reversal towards what the record itself shows in steady motion, p_m at v_m; a part p_f may be there at once (seals), the rest may
begin after a play g, know the speed, and have a breakaway:

    p = p_low + p_f + (p_m - p_low - p_f) (1 - exp(-(s - g)/lambda)) (1 - w + w v/v_m + b exp(-(s - g)/lambda_b))

The low side is

    p_low = (p_g + p_at)(V_g/(V_g + (A_a - A_b) x))^n - p_at - R Q|Q|

(the accumulator's gas; drop of the way to it, Q the flow from it). Position and loaded pressure are put back to the measured ones where
a stroke begins. All in SI units.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.gap.effect import Effect, added, fixed, scaled, value_of
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.real_rigs.description import Description, Parameter
from ddh_twin_py.real_rigs.eha.recordings import STEP, WHERE, Actuation
from ddh_twin_py.real_rigs.run import Run
from ddh_twin_py.real_rigs.signals import signal

BORE = 0.050
"""m, of the sheet."""
STROKE = 0.10
"""m, taken for the volumes of the sides."""
MOVING = 30.0
"""rad/s of the pump above which it makes a stroke; below it holds a position."""
NOISE = {"position": 3e-4, "pressure_a": 1.0e5, "pressure_b": 1.5e5}
"""m and Pa: what a free run is not expected to undercut; the pressures ripple by this with the pump's teeth."""
_BREAKAWAY_WAY, _SEALS_WAY = 4e-3, 3e-4  # m
_BIN = 0.05  # s
_STILL = 0.25  # s without a stroke before one
_BEFORE = 0.1  # s before a stroke at which it is put back

PARAMETERS = (  # within three standard deviations of what the sheet and the authors give: beyond, it is an effect
    Parameter("displacement", 1.6e-6, 0.02e-6, "m3", "sheet of the pump, per revolution; a tolerance of 1 %", 1.54e-6, 1.66e-6),
    Parameter("leakage", 1.3e-13, 0.4e-13, "m3/(s Pa)", "the authors' 0.92 at 250 bar, taken at 1500 rpm", 0.1e-13, 2.5e-13),
    Parameter("bulk_modulus", 1.4e9, 0.2e9, "Pa", "mineral oil", 0.8e9, 2.0e9),
    Parameter("dead_volume", 50e-6, 20e-6, "m3", "pump, valve and pipes of one side", 5e-6, 110e-6),
    Parameter("gas_pressure", 5.0e5, 1.0e5, "Pa", "gauge, of the accumulator with the rod in; as the sides read at rest", 2.0e5, 8.0e5),
    Parameter("way", 3e-3, 1.5e-3, "m", "after which a load is fully there: play and stiffness of the stand", 2e-4, 7.5e-3),
)
NEUTRAL = {"rod": 0.020, "air": 1e-3, "line": 0.0, "gas_volume": 0.25e-3, "resistance": 0.0, "switching": 0.0, "skew": 0.0, "late": 0.0,
           "offset_a": 0.0, "offset_b": 0.0, "scale": 1.0, "speed_share": 0.0, "breakaway": 0.0,
           "friction": 0.0, "play": 0.0}


def _effect(name: str, domain: str, parameter: str, unit: str, reference, laws, step: float, lowest: float = -math.inf,
            highest: float = math.inf, **words: str) -> Effect:
    return Effect(name, name.split(".")[0], domain, parameter, unit, reference, laws, step, lowest, highest, **words)


EFFECTS = (
    _effect("pump.displacement", "hydraulic", "ratio", "1", fixed(1.0), (scaled("displacement"),), -0.05, -0.4, 0.3,
            about="The pump moves another volume per revolution than {reference}.", law="Q = r D omega",
            signature="Strokes in both ways in one proportion, at every pressure.", check="Measuring glass and revolutions."),
    _effect("pump.leakage", "hydraulic", "leakage_ratio", "1", fixed(1.0), (scaled("leakage"),), 1.0, -0.9, 60.0,
            about="Oil goes back inside the pump or past the piston seal.", law="Q_leak = r L p",
            signature="The loaded side loses pressure at rest; strokes under load are shorter.", check="Close the ports under load."),
    _effect("cylinder.rod_diameter", "hydraulic", "diameter", "m", value_of("rod"), (added("rod"),), 0.003, -0.019, 0.028,
            about="The rod is thicker than {reference}.", law="A_b = A_a - pi d^2/4",
            signature="Retraction faster than the sheet's area says, extension as it says; the accumulator gives more oil.",
            check="A calliper."),
    _effect("side.compliance", "hydraulic", "volume_expansion", "m3/Pa", fixed(0.0), (added("line"),), 1e-12, 0.0, 2e-11,
            about="Hoses and seals of the loaded side give way.", law="C = C_oil + C_line",
            signature="Pressure follows the pump late, and so does the rod.", check="Pump against a closed port."),
    _effect("oil.air_content", "hydraulic", "volume_fraction", "1", value_of("air"), (added("air"),), 0.01, -0.001, 0.5,
            about="Air in the oil makes it soft at low pressure.", law="C = V (1/K + phi p_0/p^2)",
            signature="As compliance, but gone at high pressure.", check="Bleed, let stand."),
    _effect("accumulator.gas_volume", "hydraulic", "gas_volume", "m3", value_of("gas_volume"), (added("gas_volume"),), -1e-4, -2.4e-4, 3e-3,
            about="The accumulator holds less or more gas.", law="p_low = p_g (V_g/(V_g + dA x))^n",
            signature="Pressure of the low side along the stroke.", check="Pre-charge with the oil side empty."),
    _effect("line.pressure_drop", "hydraulic", "quadratic_coefficient", "Pa s2/m6", fixed(0.0), (added("resistance"),), 5e14, 0.0, 1e17,
            about="Valve and pipes between accumulator and low side throttle.", law="dp = R Q|Q|",
            signature="The low side below the accumulator while it gives oil, above while it takes it.", check="Gauge at both ends."),
    _effect("load.speed_dependence", "mechanical", "share", "1", fixed(0.0), (added("speed_share"),), 0.2, 0.0, 1.0,
            about="A part of the load grows with speed.", law="p = (p_m - p_low)(1 - w + w v/v_m)",
            signature="The loaded pressure falls as a stroke slows down.", check="Two speeds."),
    _effect("load.breakaway", "mechanical", "ratio", "1", fixed(0.0), (added("breakaway"),), 0.2, 0.0, 3.0,
            about="The load asks for more as it begins to move (breakaway, Stribeck).", law="p = (p_m - p_low)(1 + b exp(-s/lambda_b))",
            signature="A peak of the loaded pressure in the first millimetres.", check="Slow strokes."),
    _effect("load.play", "mechanical", "way", "m", fixed(0.0), (added("play"),), 1e-3, 0.0, 0.02,
            about="The load is met only after some way.", law="p(s - g)", signature="Little pressure at first, then a steep rise.",
            check="Push by hand."),
    _effect("cylinder.seal_friction", "mechanical", "force", "N", fixed(0.0), (added("friction"),), 500.0, 0.0, 8000.0,
            about="A part of what the rod has to overcome is the seals' and is there at once.", law="p_f = F/A",
            signature="Pressure before the rod moves at all.", check="Without a load."),
    _effect("valve.switching_time", "hydraulic", "delay", "s", fixed(0.0), (added("switching"),), 0.03, 0.0, 0.5,
            about="The valve joins the sides to the accumulator later than it is told.", law="u(t - tau)",
            signature="Both pressures in the moments after a command.", check="Current and pressure together."),
    _effect("sensor.position_late", "measurement", "delay", "s", fixed(0.0), (added("late"),), 0.01, 0.0, 0.03,
            about="The position is read late.", law="x_read(t) = x(t - tau)", signature="Position behind in every motion.",
            check="Knock at the rod, look at both channels."),
    _effect("sensor.time_skew", "measurement", "delay", "s", fixed(0.0), (added("skew"),), 0.01, 0.0, 0.03,
            about="Pressures and position are stamped later than the speed.", law="y_read(t) = y(t - tau)",
            signature="Everything behind the pump.", check="One clock for both."),
    _effect("sensor.pressure_a_offset", "measurement", "offset", "Pa", fixed(0.0), (added("offset_a"),), 1e5, -5e5, 5e5,
            about="Zero error of the piston side's transducer.", law="p_read = p + b", signature="One pressure, always.", check="Vent."),
    _effect("sensor.pressure_b_offset", "measurement", "offset", "Pa", fixed(0.0), (added("offset_b"),), 1e5, -5e5, 5e5,
            about="Zero error of the rod side's transducer.", law="p_read = p + b", signature="One pressure, always.", check="Vent."),
)

DESCRIPTION = Description(
    rig="eha", source=WHERE, parameters=PARAMETERS, neutral=NEUTRAL, effects=EFFECTS,
    places={"position": ("cylinder", "mechanical"), "pressure_a": ("line", "hydraulic"), "pressure_b": ("line", "hydraulic")},
    assumptions=("the load is a brake; what it asks in steady motion is read off each record itself, one pressure out and one in",
                 "what seals ask in steady motion is part of the load",
                 "a leak past the piston is told as the pump's, a scale of the position as the pump's displacement: they show alike",
                 "one controller stamps all signals: they are at most 30 ms apart"))


@kernel
def _free_run(speed, valve, starts, position, pressure, asked, at_speed, q):
    """Position m, pressures of piston and rod side Pa, (n, 3), by the laws above; q: parameters as `_values` has them."""
    displacement, leakage, bulk, dead, gas, way, area_a, area_b, air, line, gas_volume, resistance, share, breakaway, friction, play = q
    n = speed.size
    out = np.empty((n, 3))
    x, p, travelled, side = position[0], pressure[0], 0.0, 1.0
    for i in range(n):
        if valve[i] != 0.0 and valve[i] != side:
            side = valve[i]
            travelled = 0.0
            p = gas
        if starts[i]:
            x, p = position[i], pressure[i]
        area = area_a if side > 0.0 else area_b
        taken = max(gas_volume + (area_a - area_b) * x, 1e-6)
        held = (gas + 101325.0) * (gas_volume / taken) ** 1.2 - 101325.0
        which = 0 if side > 0.0 else 1
        more = max(asked[which] - held, 0.0)
        volume = dead + (area_a * max(x, 0.0) if side > 0.0 else area_b * max(STROKE - x, 0.0))
        absolute = max(p + 101325.0, 2e4)
        soft = volume * (1.0 / bulk + air * 101325.0 / (absolute * absolute)) + line
        pumped = (side * displacement * speed[i] / (2.0 * math.pi) - leakage * (p - held)) * STEP
        seals = min(more, friction / area)
        more -= seals
        met = max(travelled - play, 0.0)
        begun, first = math.exp(-met / way), breakaway * math.exp(-met / _BREAKAWAY_WAY)
        still = math.exp(-travelled / _SEALS_WAY)
        level = held + seals * (1.0 - still) + more * (1.0 - begun) * (1.0 - share + first)
        moved = 0.0
        tried = p + pumped / soft
        if tried > level:  # slides: what is left above the level moves the rod, which asks for more
            slope = seals * still / _SEALS_WAY
            if met > 0.0 or play == 0.0:
                slope += more * (begun / way * (1.0 - share + first) - (1.0 - begun) * first / _BREAKAWAY_WAY
                                 + (1.0 - begun) * share / (at_speed[which] * STEP))
            moved = (pumped - (level - p) * soft) / max(area + soft * slope, 0.5 * area)
            if moved > 0.0:
                tried = level + slope * moved
                travelled += moved
            else:
                moved = 0.0
        lowest = min(held, 0.0) - 0.9e5
        if tried < lowest:  # pulled back, the load asks nothing
            moved = (pumped - (lowest - p) * soft) / area
            tried = lowest
        p = tried
        x += side * moved
        flow = side * displacement * speed[i] / (2.0 * math.pi) - (area_b if side > 0.0 else area_a) * moved / STEP
        low = held - resistance * flow * abs(flow)
        out[i, 0] = x
        out[i, 1] = p if side > 0.0 else low
        out[i, 2] = low if side > 0.0 else p
    return out


class Stroke(Run):
    """One record: extensions and retractions from where each begins."""

    def __init__(self, record: Actuation) -> None:
        self.name, self.record = record.name, record
        moving = np.abs(record.speed) > MOVING
        still = round(_STILL / STEP)
        begins = moving & (np.convolve(moving, np.ones(still + 1))[: moving.size] < 1.5)
        self._starts = np.zeros(moving.size, dtype=bool)
        self._starts[np.maximum(np.flatnonzero(begins) - round(_BEFORE / STEP), 0)] = True
        loaded = np.where(record.valve >= 0.0, record.pressure_a, record.pressure_b)
        self._pressure = smoothed(loaded, 5)
        velocity = np.abs(np.gradient(smoothed(record.position, 11), STEP))
        ways = [(sign * record.speed > MOVING, p) for sign, p in ((1.0, record.pressure_a), (-1.0, record.pressure_b))]
        self.asked = np.array([_steady(way, p) for way, p in ways])
        self.at_speed = np.maximum([_steady(way, velocity) for way, _ in ways], 1e-3)
        begun = int(np.argmax(self._starts)) if self._starts.any() else 0
        used = np.arange(record.time.size) >= begun
        phase = (record.valve + 1.0).astype(np.int64) * 2 + moving
        self.signals = {
            name: signal(record.time, np.where(used, values, np.nan), NOISE[name], unit, _BIN, phase)
            for name, values, unit in (("position", record.position, "m"), ("pressure_a", record.pressure_a, "Pa"),
                                       ("pressure_b", record.pressure_b, "Pa"))}

    def predict(self, record: np.ndarray) -> dict[str, np.ndarray]:
        """Every signal from speed and valve, put back where a stroke begins."""
        p, own = record[0], self.record
        valve = delayed(own.valve, float(p["switching"]), held=True)
        area_a = np.pi / 4.0 * BORE**2
        values = np.array([p["displacement"], p["leakage"], p["bulk_modulus"], p["dead_volume"], p["gas_pressure"], p["way"], area_a,
                           area_a - np.pi / 4.0 * p["rod"] ** 2, p["air"], p["line"], p["gas_volume"], p["resistance"],
                           p["speed_share"], p["breakaway"], p["friction"], p["play"]])
        run = _free_run(own.speed, valve, self._starts, own.position, self._pressure, self.asked, self.at_speed, values)
        skew = float(p["skew"])
        return {"position": p["scale"] * delayed(run[:, 0], skew + float(p["late"])),
                "pressure_a": delayed(run[:, 1], skew) + p["offset_a"], "pressure_b": delayed(run[:, 2], skew) + p["offset_b"]}

    def variables(self, record: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Speed of the pump, position and loaded pressure, as read."""
        own = self.record
        return {"pump speed, rad/s": (own.time, own.speed), "position, m": (own.time, own.position),
                "loaded pressure, Pa": (own.time, self._pressure)}


def _steady(moving: np.ndarray, values: np.ndarray) -> float:
    """Median of values (n,) in the second halves of the stretches in which the rod moves, 0 where it does not."""
    edge = np.flatnonzero(np.diff(moving.astype(np.int8), prepend=0, append=0))
    late = [values[(a + b) // 2 : b] for a, b in zip(edge[::2], edge[1::2], strict=True)]
    return float(np.median(np.concatenate(late))) if late else 0.0


def delayed(values: np.ndarray, delay: float, held: bool = False) -> np.ndarray:
    """Values (n,) some s later, between samples by a straight line, or ``held``."""
    if delay == 0.0:
        return values
    at = np.arange(values.size) - delay / STEP
    if held:
        return values[np.clip(np.floor(at + 1e-9).astype(np.int64), 0, values.size - 1)]
    return np.interp(at, np.arange(values.size), values)


def smoothed(values: np.ndarray, width: int) -> np.ndarray:
    """Means of values (n,) over an odd number of samples about each."""
    return np.convolve(np.pad(values, width // 2, mode="edge"), np.ones(width) / width, "valid")
