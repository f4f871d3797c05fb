"""Terms of the direct driven unit's model that no effect is asked of: what a place may lack, and what may be learned there."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.sensors import NODE_OF_SENSOR
from ddh_twin_py.gap.catalogue.oil import more_viscous
from ddh_twin_py.gap.effect import Apply, Effect, added, fixed, scaled
from ddh_twin_py.gap.explain.learned import PREFIX

_FARTHEST = 400.0  # steps
_HEATED = ("motor", "pump_1", "pump_2", "line_a", "line_b", "cylinder", "tank")
_RESISTANCES = {  # further friction beside the sheet's: name, unit, step
    "motor": (("friction_coulomb", "N*m", 0.05), ("friction_viscous", "N*m*s", 5.0e-4)),
    "pump_1": (("friction_constant", "N*m", 0.1), ("friction_viscous", "N*m*s", 1.0e-3)),
    "pump_2": (("friction_constant", "N*m", 0.1), ("friction_viscous", "N*m*s", 1.0e-3)),
    "cylinder": (("friction_coulomb", "N", 100.0), ("friction_viscous", "N*s/m", 500.0)),
}
_FLOWS = {  # further ways of the oil and what it takes to drive it through: name, unit, step, what says its lack (`Effect.lacked`)
    "pump_1": (("leakage", "m3/(s*Pa)", 2.0e-13),),
    "pump_2": (("leakage", "m3/(s*Pa)", 2.0e-13),),
    "cylinder": (("cross_leakage", "m3/(s*Pa)", 2.0e-13),),
    "relief_valve": (("seat_leakage", "m3/(s*Pa)", 2.0e-13),),
    "line_a": (("pressure_drop_quadratic", "Pa*s2/m6", 5.0e12, ("loss_line_a", "W")),),
    "line_b": (("pressure_drop_quadratic", "Pa*s2/m6", 5.0e12, ("loss_line_b", "W")), ("compliance", "m3/Pa", 1.0e-13)),
    "check_valve": (("cracking_pressure", "Pa", 1.0e4),),
    "oil": (("air_fraction", "1", 0.005),),
}
_IN_THE_AIR = ("motor_housing_convection", "pump_1_convection", "pump_2_convection", "cylinder_convection", "tank_convection",
               "line_a_wall_to_ambient", "line_b_wall_to_ambient")
"""What carries heat from the unit's surfaces into the air."""
_UNFILLED = {  # of a pump's swept volume, while it draws from the tank: unit, step, about
    "unfilled_by_speed": ("s/rad", 2.0e-4, "pump {} delivers less the faster it draws from the tank, as where its suction starves"),
    "unfilled_by_viscosity": ("1", 0.01, "pump {} delivers less the colder the oil is that it draws, as where its suction is choked"),
}


def unlisted_laws() -> list[Effect]:
    """Pumps that their suction does not fill, with speed and with the oil's viscosity; temperatures read too warm or cold by a constant; an
    oil of another grade; a drive that misses its command."""
    return [*_unfilled(), *_zeros(), _grade(), *_missed_speed()]


def _grade() -> Effect:
    """The number of a grade is its viscosity at 40 degC, mm2/s: the next ones to 46 are 32 and 68 (ISO 3448)."""
    return Effect(
        id=f"{PREFIX}oil_viscosity", component="oil", domain="hydraulic", parameter="viscosity_ratio", unit="1", reference=fixed(1.0),
        laws=(more_viscous,), step=0.05, lowest=-0.6, highest=1.5, law_error=0.1,
        about="the oil is more viscous at every temperature, as one of a higher grade is",
        about_below="the oil is less viscous at every temperature, as one of a lower grade is, or one with fuel or solvent in it",
    )


def _zeros() -> list[Effect]:
    return [
        Effect(
            id=f"{PREFIX}sensor_{name}_offset", component="sensor", domain="measurement", parameter=f"{name}_offset", unit="K",
            reference=fixed(0.0), laws=(added(f"measurement_{name}_offset"),), step=1.0, lowest=-30.0, highest=30.0,
            about=f"temperature/{name} reads too warm by a constant", about_below=f"temperature/{name} reads too cold by a constant",
            reading=f"temperature/{name}",
        )
        for name in NODE_OF_SENSOR
    ]  # fmt: skip


def _unfilled() -> list[Effect]:
    return [
        Effect(
            id=f"{PREFIX}pump_{number}_{name}", component=f"pump_{number}", domain="hydraulic", parameter=name, unit=unit,
            reference=fixed(0.0), laws=(added(f"pump_{number}_{name}"),), step=step, lowest=0.0, highest=40.0 * step,
            about=about.format(number), law_error=0.1, lacked=(f"pump_{number}_flow", "m3/s"),
        )
        for number in (1, 2) for name, (unit, step, about) in _UNFILLED.items()
    ]  # fmt: skip


def terms() -> list[Effect]:
    """Heat, constant and growing with speed; friction, constant and growing; loads; flows and pressure drops; pumps that are not filled;
    power of the motor; a drive that misses its command; air that moves; another oil."""
    heat = [_term(component, "thermal", f"learned_{component}_{name}", name, unit, step)
            for component in _HEATED for name, unit, step in (("heat", "W", 10.0), ("heat_by_speed", "W*s", 0.3))]
    others = [_term(component, domain, f"{component}_{name}", name, *row)
              for domain, table in (("mechanical", _RESISTANCES), ("hydraulic", _FLOWS))
              for component, several in table.items() for name, *row in several]
    return [*heat, *others, *_unfilled(), *_electrical(), *_missed_speed(), *_loads(), _moving_air(), _grade()]


def _electrical() -> list[Effect]:
    """Power that the motor takes beyond its laws and that warms it: with the square of its current, with its speed, and at all times."""
    rows = (
        ("phase_resistance", "1", scaled("motor_phase_resistance_20C"), 0.05, -0.9),
        ("iron_loss", "1", added("motor_iron_loss_ratio"), 0.5, 0.0),
        ("power", "W", _counted_power, 10.0, 0.0),
    )
    return [_free("motor", "electrical", name, unit, law, step, lowest) for name, unit, law, step, lowest in rows]


def _counted_power(record: np.ndarray, x: float) -> None:
    """Heat in teeth and yoke that the drive counts."""
    record["motor_pwm_loss"] += x
    record["motor_pwm_loss_reported"] = 1.0


def _missed_speed() -> list[Effect]:
    """A shaft that settles at another speed than its command, by a share of it, or by a constant that turns it at rest, too."""
    rows = (
        ("speed_gain", "1", 1.0, scaled("motor_speed_loop_gain"), 0.01, 0.9, "settles {} than its command, by a share of it"),
        ("speed_zero", "rad/s", 0.0, added("motor_speed_loop_zero"), 0.1, 10.0, "turns {} than its command, at rest too"),
    )
    return [
        Effect(
            id=f"{PREFIX}drive_{name}", component="drive", domain="electrical", parameter=name, unit=unit, reference=fixed(neutral),
            laws=(law,), step=step, lowest=-farthest, highest=farthest, about=f"the shaft {about.format('faster')}",
            about_below=f"the shaft {about.format('slower')}", lacked=("speed", "rad/s"),
        )
        for name, unit, neutral, law, step, farthest, about in rows
    ]  # fmt: skip


def _loads() -> list[Effect]:
    return [_free("load", "mechanical", name, unit, added(f"load_{name}"), step, -_FARTHEST * step)
            for name, unit, step in (("payload_mass", "kg", 3.0), ("force_slope", "N/m", 300.0))]


def _moving_air() -> Effect:
    return _free("ambient", "thermal", "convection", "1", scaled(*_IN_THE_AIR), 0.2, -0.9)


def terms_at(component: str, domain: str) -> list[Effect]:
    """Those of one place."""
    return [term for term in terms() if (term.component, term.domain) == (component, domain)]


def _not_below_zero(field: str) -> Apply:
    """A law that adds the departure to a field of the record that cannot be negative."""

    def apply(record: np.ndarray, x: float) -> None:
        record[field] = np.maximum(record[field] + x, 0.0)

    return apply


def _term(component: str, domain: str, field: str, name: str, unit: str, step: float, lacked: tuple[str, str] | None = None) -> Effect:
    law = added(field) if field.startswith("learned_") else _not_below_zero(field)
    return _free(component, domain, name, unit, law, step, -_FARTHEST * step, lacked)


def _free(component: str, domain: str, name: str, unit: str, law: Apply, step: float, lowest: float,
          lacked: tuple[str, str] | None = None) -> Effect:
    return Effect(
        id=f"{PREFIX}{component}_{name}", component=component, domain=domain, parameter=name, unit=unit, reference=fixed(0.0),
        laws=(law,), step=step, lowest=lowest, highest=_FARTHEST * step, about="learned from a recording; its cause is unknown",
        lacked=lacked,
    )
