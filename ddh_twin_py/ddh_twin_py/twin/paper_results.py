"""What the paper states, beside what the twin makes of it.

Minav, Papini, Pietola: A Thermal Analysis of Direct Driven Hydraulics. Its cycle is run twice by
the free run, once for each reading of its text, which names both 500 rpm and 0.2 m/s although
they do not belong together, and once at the ambient of its thermal image.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.equivalent_current import mean_square
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.motor_only import motor_only
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, N, NODES
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


COMPUTED, FITTED, INPUT = ORIGINS = ("computed", "fitted", "input")
"""The twin computes it; it computes it with a quantity of the data sheet that was derived from the paper's number; one of
the two is an input of the twin, so that nothing is tested."""


@dataclass(frozen=True)
class Row:
    """One result. `paper` and `twin` are numbers in `unit`, or words; `difference` is twin less paper.

    `origin`: whether the row tests the model, one of `ORIGINS`.
    """

    result: str
    paper: float | str
    twin: float | str
    unit: str
    explanation: str
    origin: str = COMPUTED

    @property
    def difference(self) -> float | None:
        """Twin less paper, None where one of them is words."""
        if isinstance(self.paper, str) or isinstance(self.twin, str):
            return None
        return self.twin - self.paper

    def as_json(self) -> dict:
        """The row with its difference."""
        return {**asdict(self), "difference": self.difference}


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

    def change(self, node: str, part: slice, last: bool = False) -> float:
        """K by which a node changes over a part of the cycle."""
        column = (self.last_temperatures if last else self.temperatures)[part, NODES.index(node)]
        return float(column[-1] - column[0])


@dataclass(frozen=True)
class PaperResults:
    """Everything that the table and the pictures show.

    Attributes:
        rig: as given. slow, fast: 500 rpm and 0.2 m/s. cold: 500 rpm at the chamber's temperature.
        matched: 500 rpm with pump 2 that fits the area ratio. equivalent_time, equivalent: s and K of the motor at the
            constant equivalent current (paper, eq. 6), (n,) and (n, number of motor nodes). rows: the table.
    """

    rig: Rig
    slow: Reading
    fast: Reading
    cold: Reading
    matched: Reading
    equivalent_time: np.ndarray
    equivalent: np.ndarray
    rows: list[Row]


def paper_results(rig: Rig, progress: Callable[[float], None] = lambda share: None) -> PaperResults:
    """Run the paper's cycle in all readings and set up the table."""
    rig = rig.with_values({"load.payload_mass": PAYLOAD}, source="paper")
    area_ratio = 1.0 - (rig["cylinder.rod"] / rig["cylinder.bore"]) ** 2
    fast_rpm = ROD_SPEED * _area(rig) / rig["pump_1.displacement"] * 60.0
    slow = _reading("500 rpm", rig, SPEED_RPM, AMBIENT)
    progress(0.25)
    fast = _reading("0.2 m/s", rig, fast_rpm, AMBIENT)
    progress(0.5)
    cold = _reading("500 rpm at 10 degC", rig, SPEED_RPM, CHAMBER)
    progress(0.75)
    fitting = rig.with_values({"pump_2.displacement": area_ratio * rig["pump_1.displacement"]}, source="fits the area ratio")
    matched = _reading("500 rpm, pump 2 that fits", fitting, SPEED_RPM, AMBIENT)
    time, equivalent = _equivalent_current(rig, slow)
    progress(1.0)
    results = PaperResults(rig, slow, fast, cold, matched, time, equivalent, [])
    results.rows.extend(_rows(results, area_ratio, fast_rpm))
    return results


def _area(rig: Rig) -> float:
    return 0.25 * math.pi * rig["cylinder.bore"] ** 2


def _at_speed(speed: np.ndarray, full: float) -> slice:
    near = np.flatnonzero(speed > 0.99 * full)
    if not near.size:
        return slice(0, speed.size)
    gap = np.flatnonzero(np.diff(near) > 1)
    return slice(int(near[0]), int(near[gap[0]] if gap.size else near[-1]) + 1)


def _reading(name: str, rig: Rig, rpm: float, ambient: float) -> Reading:
    """Twenty cycles from everything at ambient; the first three and the last are kept whole."""
    speed, stroke = rpm * RAD_PER_S_OF_RPM, rig["cylinder.stroke"]
    ramp = max(RAMP_RPM, rpm * rpm * rig["pump_1.displacement"] / 60.0 / _area(rig) / (0.2 * stroke)) * RAD_PER_S_OF_RPM
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


def _equivalent_current(rig: Rig, reading: Reading) -> tuple[np.ndarray, np.ndarray]:
    """Motor at the constant current I_M^2/2 (paper, eq. 6), I_M the largest of the lift, over `CYCLES` cycles."""
    step = 0.05
    n = int(round(CYCLES * reading.cycle / step))
    square = mean_square(float(np.max(reading.points["current"][reading.lift()])))
    speed = np.full(n, float(np.mean(reading.points["speed_absolute"])))
    points, temperatures = np.zeros(n, OPERATING_DTYPE), np.empty((n, N))
    motor_only(
        rig.parameters, speed, np.full(n, math.sqrt(square)), np.full(n, square), np.full(n, reading.start), step,
        np.full(N, reading.start), points, temperatures,
    )
    return step * np.arange(1, n + 1), temperatures[:, : len(MOTOR_NODES)]


def _rows(r: PaperResults, area_ratio: float, fast_rpm: float) -> list[Row]:
    rig, slow, fast, cold, matched = r.rig, r.slow, r.fast, r.cold, r.matched
    displacement_ratio = rig["pump_2.displacement"] / rig["pump_1.displacement"]
    slow_speed = SPEED_RPM / 60.0 * rig["pump_1.displacement"] / _area(rig)
    torque = {x.name: float(x.points["torque"][x.lift()].max()) for x in (slow, fast, cold, matched)}
    side_a = {x.name: 1e-5 * float(x.points["pressure_piston_side"][x.lift()].max()) for x in (slow, fast, cold, matched)}
    side_b = {x.name: 1e-5 * max(0.0, float(x.points["pressure_rod_side"][x.lift()].max())) for x in (slow, fast, cold, matched)}
    velocity = {x.name: float(x.points["rod_velocity"][x.lift()][-20:].mean()) for x in (slow, fast)}
    height = {x.name: float(np.ptp(x.points["rod_position"])) for x in (slow, fast)}
    stroke_time = {x.name: _stroke_time(x) for x in (slow, fast)}
    excess = (area_ratio - displacement_ratio) * SPEED_RPM / 60.0 * rig["pump_1.displacement"]
    relief = 1e-5 * rig["relief_valve.opening_pressure"]
    one = int(round(slow.cycle / 0.05)) - 1
    end, housing = MOTOR_NODES.index("end_winding"), MOTOR_NODES.index("housing")
    winding_rise, housing_rise = (float(r.equivalent[one, i] - slow.start) for i in (end, housing))
    first = {node: float(slow.ends[0, NODES.index(node)] - slow.start) for node in ("end_winding", "housing")}
    capacity = sum(q.value for path, q in rig.quantities.items() if path.startswith("motor.thermal.") and path.endswith("_capacity"))
    current = float(np.max(slow.points["current"][slow.lift()]))
    copper = 3.0 * rig["motor.phase_resistance_20C"] * mean_square(current) * slow.cycle
    rms = rig["motor.torque_constant"] * math.sqrt(float(np.mean(slow.last_points["mean_square_current"])))
    oil = {
        (node, part): slow.change(node, slow.lift(True) if part == "lift" else slow.lower(True), last=True)
        for node in ("pump_1_oil", "pump_2_oil", "tank_oil") for part in ("lift", "lower")
    }
    whole = slow.lower(True)
    late = slice((whole.start + whole.stop) // 2, whole.stop)
    flat = {node: slow.change(node, late, last=True) for node in ("pump_1_oil", "pump_2_oil")}
    solids = ("housing", "pump_1_case", "pump_2_case", "cylinder_barrel", "tank_wall", "line_a_wall", "line_b_wall")
    at_end = {node: float(slow.ends[-1, NODES.index(node)] - ZERO_CELSIUS) for node in NODES}
    mean_oil = float(np.mean([at_end[node] for node in ("pump_1_oil", "pump_2_oil", "tank_oil")]))
    warm_surfaces = [node for node in solids if at_end[node] > mean_oil]
    warmest, warmest_cold = (_warmest(x) for x in (slow, cold))
    second = _warmest_hydraulic(slow)
    from_voltage = math.sqrt(3.0) * rig["motor.voltage_constant"] / RAD_PER_S_OF_RPM
    return [
        Row("Torque in the lift, 149.5 kg, 500 rpm", 16.0, torque[slow.name], "N*m",
            f"Largest mean of {PERIOD * 1e3:.0f} ms in the first lift at full speed, everything at {AMBIENT:g} degC; the torque still "
            f"grows with the rod-side pressure until the lift ends and falls to "
            f"{float(slow.last_points['torque'][slow.lift(True)].max()):.2f} N*m "
            f"in cycle {CYCLES} as the oil warms. The sheet's pump friction was derived from the paper's number, so that the two agree "
            "is no test of it.", origin=FITTED),
        Row("Torque in the lift at 0.2 m/s", 16.0, torque[fast.name], "N*m",
            f"If 0.2 m/s is meant, {fast_rpm:.0f} rpm are needed: viscous friction and rod-side flow grow with the speed, the relief valve "
            f"({relief:.0f} bar) carries part of the flow and the torque is {torque[fast.name] - torque[slow.name]:.1f} N*m above that "
            "of 500 rpm. "
            "16 N*m go with 500 rpm."),
        Row("Highest pressure in the lift at 500 rpm", 100.0, side_a[slow.name], "bar",
            f"Piston side. The rod side reaches {side_b[slow.name]:.0f} bar: it has the smaller area. The paper does not say which of its "
            "two lines it means. The sheet's leakage was derived from the paper's number.", origin=FITTED),
        Row("Highest pressure in the lift at 0.2 m/s", 100.0, side_a[fast.name], "bar",
            f"Piston side; the rod side reaches {side_b[fast.name]:.0f} bar against a relief valve that opens at {relief:.0f} bar. "
            "100 bar go with 500 rpm, not with 0.2 m/s."),
        Row("Displacement ratio of pump 2 to pump 1", 14.4 / 22.8, displacement_ratio, "1",
            "From the displacements that the paper gives.", origin=INPUT),
        Row("Area ratio of rod side to piston side", 1.0 - (30.0 / 60.0) ** 2, area_ratio, "1",
            f"From bore and rod. It is above the displacement ratio: at 500 rpm the rod side returns {excess * 6e4:.2f} L/min more than "
            "pump 2 "
            "takes, which must leave as leakage under pressure.", origin=INPUT),
        Row("Pressure peak of the lift from unequal displacement", "caused by it", side_b[slow.name] - side_b[matched.name], "bar",
            f"Rod-side peak of {side_b[slow.name]:.0f} bar less the {side_b[matched.name]:.0f} bar that remain with a pump 2 of "
            f"{area_ratio * rig['pump_1.displacement'] * 1e6:.1f} cm3/rev, which fits the areas; the torque would be "
            f"{torque[matched.name]:.1f} "
            f"instead of {torque[slow.name]:.1f} N*m. The cause that the paper names is confirmed."),
        Row("Rod speed at 500 rpm", ROD_SPEED, velocity[slow.name], "m/s",
            f"The paper contradicts itself: 500 rpm with 22.8 cm3/rev and a 60 mm bore are at most {slow_speed:.4f} m/s, less leakage "
            f"{velocity[slow.name]:.4f} m/s. Its 0.2 m/s would take {fast_rpm:.0f} rpm."),
        Row("Motor speed for 0.2 m/s", SPEED_RPM, fast_rpm, "rpm",
            f"The other reading: {fast_rpm:.0f} rpm are within the motor's {rig['motor.maximum_speed']:g} rpm. At that command the rod "
            "does "
            f"{velocity[fast.name]:.3f} m/s, since leakage under pressure takes the rest."),
        Row("Time of one lift at 500 rpm", HEIGHT / ROD_SPEED, stroke_time[slow.name], "s",
            f"The paper's height and velocity give {HEIGHT / ROD_SPEED:g} s, its motor speed {HEIGHT / slow_speed:.1f} s plus ramps."),
        Row("Time of one lift at 0.2 m/s", HEIGHT / ROD_SPEED, stroke_time[fast.name], "s",
            "The rest is acceleration and braking, of which the paper's average knows nothing."),
        Row("Cycle time at 500 rpm", 2.0 * HEIGHT / ROD_SPEED, slow.cycle, "s",
            f"Paper: two strokes of {HEIGHT:g} m at {ROD_SPEED:g} m/s without rests, derived from its text, which names no cycle time. "
            "Twin: with rests of "
            f"{DWELL:g} s at both ends, which are an assumption; at 0.2 m/s it is {fast.cycle:.1f} s."),
        Row("Height of the lift", HEIGHT, height[slow.name], "m",
            f"The cylinder's whole stroke is {rig['cylinder.stroke']:g} m; the duty stops {MARGIN * 1e3:.0f} mm before each end so that "
            "no end stop is hit.", origin=INPUT),
        Row("Winding hot spot, rise per cycle at the equivalent current", 4.0, winding_rise, "K",
            f"End winding over one cycle of {slow.cycle:.1f} s at the constant current I_M/sqrt(2) of eq. 6, I_M = {current:.2f} A; "
            "cycle time decides: "
            f"over the {fast.cycle:.1f} s of the other reading it is "
            f"{float(r.equivalent[int(round(fast.cycle / 0.05)) - 1, end] - slow.start):.2f} K. "
            f"With the current as it runs the first cycle ends {first['end_winding']:.2f} K warmer."),
        Row("Motor housing, rise per cycle at the equivalent current", 1.0, housing_rise, "K",
            f"Not met, and cannot be with this sheet: the copper gives {copper:.0f} J in a cycle, and all of it spread over the motor's "
            f"{capacity:.0f} J/K "
            f"is {copper / capacity:.2f} K. 1 K would take a motor of {copper:.0f} J/K that passes heat on at once, a longer cycle or a "
            "larger current; "
            f"as it runs, the first cycle warms the housing by {first['housing']:.2f} K."),
        *(Row(f"{name} oil over the lift, cycle {CYCLES}", "rises", oil[node, "lift"], "K", why) for node, name, why in (
            ("pump_1_oil", "Pump 1", "Friction, leakage and the work against the rod-side pressure turn to heat in the lift."),
            ("pump_2_oil", "Pump 2", f"It takes oil from the rod side at up to {side_b[slow.name]:.0f} bar, whose leakage heats it."))),
        *(Row(f"{name} oil over the second half of lowering, cycle {CYCLES}", "flat", flat[node], "K",
              f"{abs(flat[node] / oil[node, 'lift']):.2f} times the change of the lift: without pressure there is hardly any loss. "
              f"Over the whole of lowering it changes by {oil[node, 'lower']:+.2f} K, most of it at the reversal, when other oil runs "
              "through the pump.")
          for node, name in (("pump_1_oil", "Pump 1"), ("pump_2_oil", "Pump 2"))),
        Row(f"Tank oil over a whole cycle, cycle {CYCLES}", "rises "
            "slowly", float(slow.ends[-1, NODES.index("tank_oil")] - slow.ends[-2, NODES.index("tank_oil")]), "K",
            f"The tank holds {rig['tank.oil_volume'] * 1e3:g} L: the oil that returns mixes with it."),
        Row("Warmest component", "electric motor", warmest[0], "", f"{warmest[1]:.1f} degC after {CYCLES} cycles; warmest of the "
            f"hydraulics is the {second[0]} with "
            f"{second[1]:.1f} degC. The winding leads because the current of the lift is "
            f"{current * rig['motor.torque_constant'] / rig['motor.rated_torque']:.1f} times that "
            f"of the rated torque; the duty decides: by the other reading it is the {_warmest(fast)[0]} "
            f"with {_warmest(fast)[1]:.1f} degC."),
        Row("Surfaces against simulated oil", "surfaces warmer", f"{len(warm_surfaces)} of {len(solids)} surfaces warmer", "",
            f"Held against the mean of pump and tank oil, {mean_oil:.1f} degC after {CYCLES} cycles; warmer: "
            f"{', '.join(node.replace('_', ' ') for node in warm_surfaces) or 'none'}. All else in the model is heated by the oil and "
            "follows it; the paper "
            "compares a measured surface with an oil that its own simulation keeps close to ambient."),
        Row("Ambient of the simulation", AMBIENT, slow.start - ZERO_CELSIUS, "degC", "Everything starts there.", origin=INPUT),
        Row("Climate chamber: torque in the lift at 10 degC", 16.0, torque[cold.name], "N*m",
            f"The thermal image was taken at {CHAMBER:g} degC, the paper gives no torque for it. Colder oil leaks less, so that the rod "
            "side reaches "
            f"{side_b[cold.name]:.0f} bar, and shears harder: {torque[cold.name] - torque[slow.name]:+.1f} N*m against {AMBIENT:g} degC."),
        Row("Climate chamber: warmest component at 10 degC", "electric motor", warmest_cold[0], "",
            f"{warmest_cold[1]:.1f} degC after {CYCLES} cycles, {warmest_cold[1] - CHAMBER:.1f} K above the chamber "
            f"({warmest[1] - AMBIENT:.1f} K at {AMBIENT:g} degC)."),
        Row("RMS torque of the cycle against the rated torque", rig["motor.rated_torque"], rms, "N*m",
            f"16 N*m are {16.0 / rig['motor.rated_torque']:.1f} times the rated torque; what heats is the RMS over the cycle, here "
            f"{rms / rig['motor.rated_torque']:.2f} times the rating.", origin=INPUT),
        Row("Torque constant from the voltage constant", rig["motor.torque_constant"], from_voltage, "N*m/A",
            "sqrt(3) K_v in SI, for K_v line to line and both rms: the paper's two constants agree.", origin=INPUT),
        Row("Equations 4 and 5", "thermal resistances", "conductances", "",
            "C_t s/L is in W/K, with s as area and L as length, and so is h s L if s is there the length around a surface: both the "
            "inverse of a resistance. "
            "The twin takes conductances.", origin=INPUT),
        Row("Unit of resistivity in equation 1", "S/m", "ohm*m", "", "S/m is a conductivity; the law itself is the usual one and is "
            "used as printed.", origin=INPUT),
    ]


def _stroke_time(reading: Reading) -> float:
    """s from the first motion of the first lift to its end."""
    rising = np.flatnonzero(reading.points["rod_velocity"][: int(reading.cycle / PERIOD)] > 1e-3)
    return float(rising[-1] - rising[0] + 1) * PERIOD


def _warmest(reading: Reading) -> tuple[str, float]:
    """Node and degC at its warmest in the last cycle."""
    peaks = reading.last_temperatures.max(axis=0) - ZERO_CELSIUS
    at = int(np.argmax(peaks))
    name = NODES[at].replace("_", " ")
    return (f"electric motor ({name})" if NODES[at] in MOTOR_NODES else name), float(peaks[at])


def _warmest_hydraulic(reading: Reading) -> tuple[str, float]:
    peaks = reading.last_temperatures.max(axis=0) - ZERO_CELSIUS
    at = max((i for i, node in enumerate(NODES) if node not in MOTOR_NODES), key=lambda i: peaks[i])
    return NODES[at].replace("_", " "), float(peaks[at])
