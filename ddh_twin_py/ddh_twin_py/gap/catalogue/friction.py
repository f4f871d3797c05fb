"""Rubbing in pumps, motor and cylinder."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.effect import Effect, added, fixed, value_of


def _pump(number: int, *confused_with: str) -> Effect:
    return Effect(
        id=f"pump_{number}.friction", component=f"pump_{number}", domain="mechanical", parameter="torque", unit="N*m",
        reference=fixed(0.0), laws=(added(f"pump_{number}_friction_added"),), step=0.2, lowest=0.0, highest=20.0,
        about=f"Added hydromechanical torque loss of pump {number}, heating its case.",
        law="T = T_added sign(omega), heat T omega into the case",
        signature=f"Current and torque shift with the direction of turning; case of pump {number} warmer.",
        check=(
            "Secure the load; depressurised, connect both pumps so that they circulate to tank; measure the torque without pressure, "
            "and the case's temperature after an hour."
        ),
        confused_with=confused_with,
    )


def _seals_with_stribeck(record: np.ndarray, x: float) -> None:
    """The rise at low speed doubles with the friction."""
    share = x / (record["cylinder_friction_coulomb"] + abs(x))
    record["cylinder_friction_coulomb"] += x
    record["cylinder_stribeck_ratio"] += 0.3 * share


EFFECTS = (
    _pump(1, "oil.viscosity_temperature", "pump_2.friction", "motor.bearing_friction", "drive.torque_estimate", "line_a.pressure_drop",
          "motor.flange_conduction", "pump_1.cooling"),
    _pump(2, "oil.viscosity_temperature", "pump_1.friction", "motor.bearing_friction", "drive.torque_estimate", "line_b.pressure_drop",
          "pump_1.cooling"),
    Effect(
        id="motor.bearing_friction", component="motor", domain="mechanical", parameter="torque", unit="N*m",
        reference=fixed(0.0), laws=(added("motor_friction_coulomb"),), step=0.2, lowest=0.0, highest=20.0,
        about="Added torque loss in the motor's bearings, heating the motor.",
        law="T = T_added sign(omega), heat T omega into rotor and housing",
        signature="Current and torque shift with the direction of turning; housing warmer, pump cases not.",
        check="Secure the load, which an uncoupled motor does not hold; turn the motor and measure its current.",
        confused_with=("pump_1.friction", "pump_2.friction", "drive.torque_estimate", "motor.iron_loss", "motor.demagnetisation"),
    ),
    Effect(
        id="cylinder.seal_friction", component="cylinder", domain="mechanical", parameter="force", unit="N",
        reference=value_of("cylinder_friction_coulomb"), laws=(added("cylinder_friction_coulomb"), _seals_with_stribeck),
        step=60.0, lowest=-280.0, highest=2e4, grows=True,
        about="Piston and rod seals rub harder than {reference}, with a Stribeck rise at low speed.",
        about_below="Piston and rod seals rub less than {reference}.",
        law="F = sign(v) (F_c + k |dp|) (1 + (r_s - 1) exp(-(v/v_s)^2)) + b v",
        signature="Pressure difference between lifting and lowering grows; jumps where motion begins; barrel warmer.",
        check="Lower, secure and disconnect the load, move the rod slowly both ways and read both pressures.",
        confused_with=("load.mass", "load.geometry", "sensor.pressure_piston_side_offset", "cylinder.cooling"),
    ),
)
