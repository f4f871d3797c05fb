"""What a quantity of the data sheet may be: physics' own limits, and how far from the reference sheet.

Beyond these a number is a mistake of unit or of typing, or one that the model's equations or its
integrator do not hold for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase

LARGEST_TOLERANCE = 1.0
"""One relative standard deviation."""
SENSOR_FACTOR = 1000.0
"""How far noise and zero of a sensor may be from the reference sheet's."""
LARGEST_ROD = 0.98
"""Of the bore; the rod side's area is what is left."""
VISCOSITY = (2.0, 3000.0)
"""Kinematic viscosity at 23 degC, cSt, from the thinnest to the thickest hydraulic oil."""


@dataclass(frozen=True)
class Bound:
    """Allowed values of one quantity, both ends included, in its unit."""

    lowest: float
    highest: float

    def holds(self, value: float) -> bool:
        """Whether the value is allowed."""
        return self.lowest <= value <= self.highest


def _near(factor: float) -> tuple[str, float, float]:
    """Above 0, at most `factor` times smaller or larger than the reference."""
    return "times", 1.0 / factor, factor


def _up_to(factor: float) -> tuple[str, float, float]:
    """0 or more, at most `factor` times the reference."""
    return "times", 0.0, factor


def _between(lowest: float, highest: float) -> tuple[str, float, float]:
    return "from", lowest, highest


TABLE: tuple[tuple[str, tuple[str, float, float]], ...] = (
    ("ambient", _between(-60.0, 80.0)),
    ("motor.iron.loss_ratio", _between(0.0, 100.0)),
    ("motor.iron.excess_exponent", _between(1.0, 2.5)),
    ("motor.pwm_loss", _between(0.0, 1000.0)),
    ("motor.pwm_loss_reported", _between(0.0, 1.0)),
    ("motor.speed_loop_gain", _between(0.1, 2.0)),
    ("motor.speed_loop_zero", _between(-10.0, 10.0)),
    ("motor.torque_constant_slope", _between(-0.03, 0.01)),
    ("motor.flange_conductance", _between(0.0, 1000.0)),
    ("pump_?.friction_added", _between(-5.0, 50.0)),
    ("pump_?.unfilled_by_speed", _between(-0.001, 0.01)),
    ("pump_?.unfilled_by_viscosity", _between(-0.2, 0.9)),
    ("cylinder.cross_leakage", _between(0.0, 1.0e-9)),
    ("line_?.pressure_drop_quadratic", _between(0.0, 2.0e14)),
    ("line_b.compliance", _between(0.0, 1.0e-10)),
    ("relief_valve.seat_leakage", _between(0.0, 1.0e-9)),
    ("cylinder.creep_velocity", _between(0.0, 1.0e-2)),
    ("cylinder.run_past_*", _between(0.0, 10.0)),
    ("load.payload_ratio", _between(0.01, 100.0)),
    ("load.force_slope", _between(-1.0e5, 1.0e5)),
    ("oil.reference_viscosity", _near(100.0)),
    ("oil.viscosity_pressure_coefficient", _between(0.0, 5.0e-8)),
    ("tank.mount_conductance", _between(0.0, 1000.0)),
    ("tank.top_share", _between(0.05, 0.95)),
    ("tank.mixing_resistance", _between(0.0, 1.0)),
    ("tank.suction_from_top", _between(0.0, 1.0)),
    ("valve_block.oil_volume", _near(100.0)),
    ("valve_block.capacity", _near(100.0)),
    ("valve_block.*", _up_to(100.0)),
    ("surroundings.solar_load", _between(0.0, 5000.0)),
    ("surroundings.enclosure_rise", _between(-50.0, 100.0)),
    ("learned.*_heat", _between(-5000.0, 5000.0)),
    ("learned.*_heat_by_speed", _between(-100.0, 100.0)),
    ("measurement.pressure_*_offset", _between(-1.0e7, 1.0e7)),
    ("measurement.surface_lag_ratio", _between(0.02, 200.0)),
    ("measurement.surface_contact", _between(0.0, 0.95)),
    ("measurement.time_skew", _between(-1.0, 1.0)),
    ("measurement.*_offset", _between(-50.0, 50.0)),
    ("measurement.*", _between(0.1, 10.0)),
    ("motor.thermal.winding_limit", _between(40.0, 400.0)),
    ("motor.pole_pairs", _between(1.0, 60.0)),
    ("motor.copper_temperature_coefficient", _between(0.0, 0.01)),
    ("motor.speed_loop_time_constant", _near(20.0)),
    ("motor.phase_resistance_20C", _near(20.0)),
    ("motor.phase_inductance", _up_to(100.0)),
    ("motor.friction_*", _up_to(100.0)),
    ("motor.iron.hysteresis_coefficient", _up_to(100.0)),
    ("motor.iron.eddy_coefficient", _between(0.0, 4.0)),
    ("motor.iron.alpha", _between(0.5, 3.0)),
    ("motor.iron.beta", _between(0.5, 3.0)),
    ("motor.iron.*_flux_density", _between(0.05, 3.0)),
    ("*_share", _between(0.0, 1.0)),
    ("*_share_to_case", _between(0.0, 1.0)),
    ("*_share_to_barrel", _between(0.0, 1.0)),
    ("*emissivity", _between(0.0, 1.0)),
    ("*convection", _up_to(100.0)),
    ("*_capacity", _near(100.0)),
    ("*.dead_volume_*", _near(100.0)),
    ("tank.oil_volume", _near(20.0)),
    ("*volume", _near(100.0)),
    ("*area", _near(100.0)),
    ("motor.thermal.*_to_*", _up_to(100.0)),
    ("*.oil_to_*", _up_to(100.0)),
    ("*.wall_to_ambient", _up_to(100.0)),
    ("pump_case_link", _up_to(100.0)),
    ("pump_?.leakage", _up_to(100.0)),
    ("pump_?.friction_pressure", _between(0.0, 0.9)),
    ("pump_?.friction_*", _up_to(100.0)),
    ("cylinder.bore", _near(4.0)),
    ("cylinder.rod", _near(4.0)),
    ("cylinder.stroke", _near(4.0)),
    ("cylinder.stribeck_velocity", _near(100.0)),
    ("cylinder.stribeck_ratio", _between(1.0, 5.0)),
    ("cylinder.friction_*", _up_to(100.0)),
    ("line_?.pressure_drop_laminar", _up_to(100.0)),
    ("relief_valve.*", _near(100.0)),
    ("check_valve.cracking_pressure", _up_to(100.0)),
    ("check_valve.conductance", _near(100.0)),
    ("oil.walther_a", _between(7.0, 12.0)),
    ("oil.walther_b", _between(2.7, 4.8)),
    ("oil.density_15C", _between(600.0, 1300.0)),
    ("oil.thermal_expansion", _between(0.0, 3.0e-3)),
    ("oil.specific_heat", _between(1000.0, 4500.0)),
    ("oil.bulk_modulus", _between(1.0e8, 1.0e10)),
    ("oil.air_fraction", _between(0.0, 0.3)),
    ("load.gravity", _between(1.0, 30.0)),
    ("load.payload_mass", _near(100.0)),
    ("motor.*", _near(100.0)),
    ("pump_?.displacement", _near(10.0)),
    ("sensors.*.time_constant", _near(100.0)),
)
"""Path pattern and allowed range, absolute or as multiples of the reference; the first that fits counts."""

WHOLE = ("motor.pole_pairs",)
"""Quantities that are whole numbers."""


def bound_of(path: str, reference: float) -> Bound:
    """Allowed values of the quantity at a dotted path of which the reference sheet has that value.

    Raises:
        KeyError: for a quantity that the table does not know.
    """
    for pattern, (kind, lowest, highest) in TABLE:
        if fnmatchcase(path, pattern):
            scale = reference if kind == "times" else 1.0
            return Bound(lowest * scale, highest * scale)
    raise KeyError(f"no bound for {path!r}; add it to rig/bounds.py")


def contradiction(values: Mapping[str, float]) -> str:
    """What does not fit together although each number is allowed, '' where all fits."""
    rod, bore = values["cylinder.rod"], values["cylinder.bore"]
    if rod > LARGEST_ROD * bore:
        return (
            f"cylinder.rod: value is {rod:g} m, with cylinder.bore {bore:g} m at most {LARGEST_ROD * bore:g} m is allowed"
        )
    a, b = values["oil.walther_a"], values["oil.walther_b"]
    exponent = a - b * math.log10(296.15)
    viscosity = 10.0 ** 10.0**exponent - 0.7 if exponent < 1.0 else math.inf
    if not VISCOSITY[0] <= viscosity <= VISCOSITY[1]:
        return (
            f"oil.walther_a and oil.walther_b: values are {a:g} and {b:g}, which is {viscosity:.3g} cSt at 23 degC, "
            f"allowed are {VISCOSITY[0]:g} to {VISCOSITY[1]:g} cSt"
        )
    return ""
