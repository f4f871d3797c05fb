"""The table of what the paper states beside what the twin makes of it, row by row."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from ddh_twin_py.physics.cylinder import piston_area
from ddh_twin_py.physics.equivalent_current import mean_square
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, NODES
from ddh_twin_py.twin.paper_cycle import (
    AMBIENT,
    CHAMBER,
    CYCLES,
    DWELL,
    HEIGHT,
    MARGIN,
    PERIOD,
    ROD_SPEED,
    SPEED_RPM,
    Reading,
)
from ddh_twin_py.twin.paper_runs import Runs, area_ratio

COMPUTED, FITTED, INPUT = ORIGINS = ("computed", "fitted", "input")
"""The twin computes it; it computes it with a quantity of the data sheet that was derived from the paper's number; one of
the two is an input of the twin, so that nothing is tested."""
_SOLIDS = ("housing", "pump_1_case", "pump_2_case", "cylinder_barrel", "tank_wall", "line_a_wall", "line_b_wall")


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


def rows(r: Runs) -> list[Row]:
    """The table, in the order of the paper's text."""
    return [*_loads(r), *_displacements(r), *_motion(r), *_motor(r), *_oil(r), *_warmth(r), *_chamber(r), *_ratings(r)]


def _bar(reading: Reading, side: str) -> float:
    """Highest pressure of a side in the first lift, bar; not below that of the surroundings."""
    return 1e-5 * max(0.0, reading.peak(f"pressure_{side}"))


def _loads(r: Runs) -> list[Row]:
    slow, fast = r.slow, r.fast
    torque, torque_fast = slow.peak("torque"), fast.peak("torque")
    relief = 1e-5 * r.rig["relief_valve.opening_pressure"]
    return [
        Row("Torque in the lift, 149.5 kg, 500 rpm", 16.0, torque, "N*m",
            f"Largest mean of {PERIOD * 1e3:.0f} ms in the first lift at full speed, everything at {AMBIENT:g} degC; the torque still "
            "grows with the rod-side pressure until the lift ends and falls to "
            f"{float(slow.last_points['torque'][slow.lift(True)].max()):.2f} N*m in cycle {CYCLES} as the oil warms. The sheet's pump "
            "friction was derived from the paper's number, so that the two agree is no test of it.", origin=FITTED),
        Row("Torque in the lift at 0.2 m/s", 16.0, torque_fast, "N*m",
            f"If 0.2 m/s is meant, {fast.speed:.0f} rpm are needed: viscous friction and rod-side flow grow with the speed, the relief "
            f"valve ({relief:.0f} bar) carries part of the flow and the torque is {torque_fast - torque:.1f} N*m above that of 500 rpm. "
            "16 N*m go with 500 rpm."),
        Row("Highest pressure in the lift at 500 rpm", 100.0, _bar(slow, "piston_side"), "bar",
            f"Piston side. The rod side reaches {_bar(slow, 'rod_side'):.0f} bar: it has the smaller area. The paper does not "
            "say which of its two lines it means. The sheet's leakage was derived from the paper's number.", origin=FITTED),
        Row("Highest pressure in the lift at 0.2 m/s", 100.0, _bar(fast, "piston_side"), "bar",
            f"Piston side; the rod side reaches {_bar(fast, 'rod_side'):.0f} bar against a relief valve that opens at "
            f"{relief:.0f} bar. 100 bar go with 500 rpm, not with 0.2 m/s."),
    ]


def _displacements(r: Runs) -> list[Row]:
    rig, slow, matched = r.rig, r.slow, r.matched
    ratio, areas = rig["pump_2.displacement"] / rig["pump_1.displacement"], area_ratio(rig)
    excess = (areas - ratio) * SPEED_RPM / 60.0 * rig["pump_1.displacement"]
    peak, left = (_bar(reading, "rod_side") for reading in (slow, matched))
    return [
        Row("Displacement ratio of pump 2 to pump 1", 14.4 / 22.8, ratio, "1",
            "From the displacements that the paper gives.", origin=INPUT),
        Row("Area ratio of rod side to piston side", 1.0 - (30.0 / 60.0) ** 2, areas, "1",
            f"From bore and rod. It is above the displacement ratio: at 500 rpm the rod side returns {excess * 6e4:.2f} L/min more than "
            "pump 2 takes, which must leave as leakage under pressure.", origin=INPUT),
        Row("Pressure peak of the lift from unequal displacement", "caused by it", peak - left, "bar",
            f"Rod-side peak of {peak:.0f} bar less the {left:.0f} bar that remain with a pump 2 of "
            f"{areas * rig['pump_1.displacement'] * 1e6:.1f} cm3/rev, which fits the areas; the torque would be "
            f"{matched.peak('torque'):.1f} instead of {slow.peak('torque'):.1f} N*m. The cause that the paper names is confirmed."),
    ]


def _motion(r: Runs) -> list[Row]:
    rig, slow, fast = r.rig, r.slow, r.fast
    at_most = SPEED_RPM / 60.0 * rig["pump_1.displacement"] / piston_area(rig.parameters[0])
    velocity, velocity_fast = (float(x.points["rod_velocity"][x.lift()][-20:].mean()) for x in (slow, fast))
    return [
        Row("Rod speed at 500 rpm", ROD_SPEED, velocity, "m/s",
            f"The paper contradicts itself: 500 rpm with 22.8 cm3/rev and a 60 mm bore are at most {at_most:.4f} m/s, less leakage "
            f"{velocity:.4f} m/s. Its 0.2 m/s would take {fast.speed:.0f} rpm."),
        Row("Motor speed for 0.2 m/s", SPEED_RPM, fast.speed, "rpm",
            f"The other reading: {fast.speed:.0f} rpm are within the motor's {rig['motor.maximum_speed']:g} rpm. At that command the rod "
            f"does {velocity_fast:.3f} m/s, since leakage under pressure takes the rest."),
        Row("Time of one lift at 500 rpm", HEIGHT / ROD_SPEED, slow.stroke_time, "s",
            f"The paper's height and velocity give {HEIGHT / ROD_SPEED:g} s, its motor speed {HEIGHT / at_most:.1f} s plus ramps."),
        Row("Time of one lift at 0.2 m/s", HEIGHT / ROD_SPEED, fast.stroke_time, "s",
            "The rest is acceleration and braking, of which the paper's average knows nothing."),
        Row("Cycle time at 500 rpm", 2.0 * HEIGHT / ROD_SPEED, slow.cycle, "s",
            f"Paper: two strokes of {HEIGHT:g} m at {ROD_SPEED:g} m/s without rests, derived from its text, which names no cycle time. "
            f"Twin: with rests of {DWELL:g} s at both ends, which are an assumption; at 0.2 m/s it is {fast.cycle:.1f} s."),
        Row("Height of the lift", HEIGHT, float(np.ptp(slow.points["rod_position"])), "m",
            f"The cylinder's whole stroke is {rig['cylinder.stroke']:g} m; the duty stops {MARGIN * 1e3:.0f} mm before each end so that "
            "no end stop is hit.", origin=INPUT),
    ]


def _motor(r: Runs) -> list[Row]:
    rig, slow, fast = r.rig, r.slow, r.fast
    one, one_fast = (int(round(x.cycle / 0.05)) - 1 for x in (slow, fast))
    end, housing = MOTOR_NODES.index("end_winding"), MOTOR_NODES.index("housing")
    capacity = sum(q.value for path, q in rig.quantities.items() if path.startswith("motor.thermal.") and path.endswith("_capacity"))
    current = slow.peak("current")
    copper = 3.0 * rig["motor.phase_resistance_20C"] * mean_square(current) * slow.cycle
    return [
        Row("Winding hot spot, rise per cycle at the equivalent current", 4.0, float(r.equivalent[one, end] - slow.start), "K",
            f"End winding over one cycle of {slow.cycle:.1f} s at the constant current I_M/sqrt(2) of eq. 6, I_M = {current:.2f} A; cycle "
            f"time decides: over the {fast.cycle:.1f} s of the other reading it is {float(r.equivalent[one_fast, end] - slow.start):.2f} "
            f"K. With the current as it runs the first cycle ends {slow.first_rise('end_winding'):.2f} K warmer."),
        Row("Motor housing, rise per cycle at the equivalent current", 1.0, float(r.equivalent[one, housing] - slow.start), "K",
            f"Not met, and cannot be with this sheet: the copper gives {copper:.0f} J in a cycle, and all of it spread over the motor's "
            f"{capacity:.0f} J/K is {copper / capacity:.2f} K. 1 K would take a motor of {copper:.0f} J/K that passes heat on at once, a "
            f"longer cycle or a larger current; as it runs, the first cycle warms the housing by {slow.first_rise('housing'):.2f} K."),
    ]


def _oil(r: Runs) -> list[Row]:
    slow, whole = r.slow, r.slow.lower(True)
    late = slice((whole.start + whole.stop) // 2, whole.stop)
    why = {"pump_1_oil": "Friction, leakage and the work against the rod-side pressure turn to heat in the lift.",
           "pump_2_oil": f"It takes oil from the rod side at up to {_bar(slow, 'rod_side'):.0f} bar, whose leakage heats it."}
    names = {"pump_1_oil": "Pump 1", "pump_2_oil": "Pump 2"}
    lift, lower, flat = ({node: slow.change(node, part, last=True) for node in names} for part in (slow.lift(True), whole, late))
    tank = NODES.index("tank_oil")
    return [
        *(Row(f"{name} oil over the lift, cycle {CYCLES}", "rises", lift[node], "K", why[node]) for node, name in names.items()),
        *(Row(f"{name} oil over the second half of lowering, cycle {CYCLES}", "flat", flat[node], "K",
              f"{abs(flat[node] / lift[node]):.2f} times the change of the lift: without pressure there is hardly any loss. Over the whole "
              f"of lowering it changes by {lower[node]:+.2f} K, most of it at the reversal, when other oil runs through the pump.")
          for node, name in names.items()),
        Row(f"Tank oil over a whole cycle, cycle {CYCLES}", "rises slowly", float(slow.ends[-1, tank] - slow.ends[-2, tank]), "K",
            f"The tank holds {r.rig['tank.oil_volume'] * 1e3:g} L: the oil that returns mixes with it."),
    ]


def _warmth(r: Runs) -> list[Row]:
    rig, slow = r.rig, r.slow
    (warmest, peak), (second, second_peak), (other, other_peak) = slow.warmest, slow.warmest_hydraulic, r.fast.warmest
    times = slow.peak("current") * rig["motor.torque_constant"] / rig["motor.rated_torque"]
    oil = float(np.mean([slow.at_end(node) for node in ("pump_1_oil", "pump_2_oil", "tank_oil")]))
    warm = [node for node in _SOLIDS if slow.at_end(node) > oil]
    return [
        Row("Warmest component", "electric motor", warmest, "",
            f"{peak:.1f} degC after {CYCLES} cycles; warmest of the hydraulics is the {second} with {second_peak:.1f} degC. The winding "
            f"leads because the current of the lift is {times:.1f} times that of the rated torque; the duty decides: by the other reading "
            f"it is the {other} with {other_peak:.1f} degC."),
        Row("Surfaces against simulated oil", "surfaces warmer", f"{len(warm)} of {len(_SOLIDS)} surfaces warmer", "",
            f"Held against the mean of pump and tank oil, {oil:.1f} degC after {CYCLES} cycles; warmer: "
            f"{', '.join(node.replace('_', ' ') for node in warm) or 'none'}. All else in the model is heated by the oil and follows it; "
            "the paper compares a measured surface with an oil that its own simulation keeps close to ambient."),
        Row("Ambient of the simulation", AMBIENT, slow.start - ZERO_CELSIUS, "degC", "Everything starts there.", origin=INPUT),
    ]


def _chamber(r: Runs) -> list[Row]:
    slow, cold = r.slow, r.cold
    torque, (warmest, peak) = cold.peak("torque"), cold.warmest
    return [
        Row("Climate chamber: torque in the lift at 10 degC", 16.0, torque, "N*m",
            f"The thermal image was taken at {CHAMBER:g} degC, the paper gives no torque for it. Colder oil leaks less, so that the rod "
            f"side reaches {_bar(cold, 'rod_side'):.0f} bar, and shears harder: {torque - slow.peak('torque'):+.1f} N*m against "
            f"{AMBIENT:g} degC."),
        Row("Climate chamber: warmest component at 10 degC", "electric motor", warmest, "",
            f"{peak:.1f} degC after {CYCLES} cycles, {peak - CHAMBER:.1f} K above the chamber ({slow.warmest[1] - AMBIENT:.1f} K at "
            f"{AMBIENT:g} degC)."),
    ]


def _ratings(r: Runs) -> list[Row]:
    rig = r.rig
    rms = rig["motor.torque_constant"] * math.sqrt(float(np.mean(r.slow.last_points["mean_square_current"])))
    from_voltage = math.sqrt(3.0) * rig["motor.voltage_constant"] / RAD_PER_S_OF_RPM
    return [
        Row("RMS torque of the cycle against the rated torque", rig["motor.rated_torque"], rms, "N*m",
            f"16 N*m are {16.0 / rig['motor.rated_torque']:.1f} times the rated torque; what heats is the RMS over the cycle, here "
            f"{rms / rig['motor.rated_torque']:.2f} times the rating.", origin=INPUT),
        Row("Torque constant from the voltage constant", rig["motor.torque_constant"], from_voltage, "N*m/A",
            "sqrt(3) K_v in SI, for K_v line to line and both rms: the paper's two constants agree.", origin=INPUT),
        Row("Equations 4 and 5", "thermal resistances", "conductances", "",
            "C_t s/L is in W/K, with s as area and L as length, and so is h s L if s is there the length around a surface: both the "
            "inverse of a resistance. The twin takes conductances.", origin=INPUT),
        Row("Unit of resistivity in equation 1", "S/m", "ohm*m", "",
            "S/m is a conductivity; the law itself is the usual one and is used as printed.", origin=INPUT),
    ]
