"""Hoses and fittings."""

from __future__ import annotations

from ddh_twin_py.gap.effect import Effect, added, fixed


def _drop(side: str, name: str, *confused_with: str) -> Effect:
    return Effect(
        id=f"line_{side}.pressure_drop", component=f"line_{side}", domain="hydraulic", parameter="quadratic_coefficient",
        unit="Pa*s2/m6", reference=fixed(0.0), laws=(added(f"line_{side}_pressure_drop_quadratic"),), step=5e12, lowest=0.0,
        highest=2e14,
        about=f"Fittings and hose of the {name} side throttle the flow.",
        law="dp = S Q |Q| between pump port and cylinder",
        signature="Torque and current grow with the square of speed while the cylinder's pressures stay.",
        check=(
            "Lower the load; depressurised, fit a gauge and hose rated for the unit's highest pressure at the pump's port; compare "
            "with the cylinder's while moving fast, from outside the reach of hose and load."
        ),
        confused_with=confused_with, lacked=(f"loss_line_{side}", "W"),
    )


EFFECTS = (
    _drop("a", "piston", "oil.viscosity_temperature", "pump_1.friction", "line_b.pressure_drop", "motor.iron_loss"),
    _drop("b", "rod", "oil.viscosity_temperature", "pump_2.friction", "line_a.pressure_drop"),
    Effect(
        id="line_b.compliance", component="line_b", domain="hydraulic", parameter="volume_expansion", unit="m3/Pa",
        reference=fixed(0.0), laws=(added("line_b_compliance"),), step=1e-13, lowest=0.0, highest=1e-11,
        about="The rod-side hose swells with pressure.",
        law="dp_B/dt = (Q_B + A_B v)/(V_B/K + C)",
        signature="Rod-side pressure rises and falls more slowly; nothing when steady.",
        check=(
            "Replace the hose, load lowered and depressurised; or read its diameter at two steady pressures on a gauge fixed to it "
            "before, hands away from it under pressure."
        ),
        confused_with=("oil.air_content", "drive.speed_lag", "sensor.time_skew"),
    ),
)
