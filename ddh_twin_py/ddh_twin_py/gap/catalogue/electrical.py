"""Motor and drive."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.effect import Effect, added, fixed, scaled, value_of


def _iron(exponent: float):
    def apply(record: np.ndarray, x: float) -> None:
        record["motor_iron_loss_ratio"] += x
        record["motor_iron_excess_exponent"] = exponent

    return apply


def _switching(reported: float):
    def apply(record: np.ndarray, x: float) -> None:
        record["motor_pwm_loss"] += x
        record["motor_pwm_loss_reported"] = reported

    return apply


EFFECTS = (
    Effect(
        id="motor.copper_resistance", component="motor", domain="electrical", parameter="resistance_ratio", unit="1",
        reference=fixed(1.0), laws=(scaled("motor_phase_resistance_20C"),), step=0.05, lowest=-0.5, highest=5.0,
        about="The winding's resistance at 20 degC is larger than {reference}.",
        about_below="The winding's resistance at 20 degC is smaller than {reference}.",
        law="P_cu = 3 r R_20 (1 + alpha (T - 20)) i^2",
        signature="Voltage and power at the same current; winding and housing warmer.",
        check=(
            "Secure the load, lock the drive out, wait until its link is discharged, and measure the cold resistance between two "
            "terminals."
        ),
        confused_with=("motor.iron_loss", "motor.contact_resistance", "drive.torque_estimate"),
    ),
    Effect(
        id="motor.iron_loss", component="motor", domain="electrical", parameter="loss_ratio", unit="1",
        reference=fixed(1.0), laws=(_iron(2.0), _iron(1.5)), step=0.5, lowest=0.0, highest=60.0,
        reached=(0.0, 9.0),  # worked and aged laminations lose a few times what the sheet's do, never ten times
        about="Iron loss beyond the Steinmetz term (eddy and excess loss, growing faster than speed).",
        law="P_fe += (r - 1) P_fe(500 rpm) (f/f_500)^n, n between 1.5 and 2",
        signature="Power grows with speed at the same torque; housing and winding warmer on fast duties.",
        check="Secure the load, which an uncoupled motor does not hold; spin the motor at several speeds and measure its power.",
        confused_with=("motor.bearing_friction", "line_a.pressure_drop", "motor.copper_resistance", "motor.pwm_loss", "motor.cooling"),
    ),
    Effect(
        id="motor.pwm_loss", component="motor", domain="electrical", parameter="power", unit="W",
        title="motor: PWM loss",
        reference=fixed(0.0), laws=(_switching(0.0), _switching(1.0)), step=10.0, lowest=0.0, highest=500.0,
        about="Switching harmonics heat the stator whenever the drive is enabled, at standstill too.",
        law="heat P into teeth and yoke at all times",
        signature="Motor warms at rest; power at standstill where the drive counts it.",
        check="Lower the load, leave the drive enabled at rest for half an hour and watch the housing.",
        confused_with=("motor.iron_loss", "motor.cooling", "ambient.solar_load"),
    ),
    Effect(
        id="motor.demagnetisation", component="motor", domain="electrical", parameter="torque_constant_slope", unit="1/K",
        reference=fixed(0.0), laws=(added("motor_torque_constant_slope"),), step=-1e-3, lowest=-0.025, highest=0.0,
        reached=(-8e-3, 0.0),  # ferrite magnets lose 0.2 % a kelvin, hot ones that do not recover several times that
        about="The torque constant falls as the magnets warm up; the drive's torque estimate does not know it.",
        law="K_t = K_t0 (1 + s (T_rotor - 23 degC))",
        signature="Current and estimated torque rise with the motor's temperature at the same pressures; voltage falls.",
        check="Secure the load, uncouple the motor, turn it from outside and compare the back-EMF of the cold and of the warm motor.",
        confused_with=("motor.bearing_friction", "drive.torque_estimate"),
    ),
    Effect(
        id="drive.torque_estimate", component="drive", domain="measurement", parameter="gain", unit="1",
        reference=fixed(1.0), laws=(scaled("measurement_current_gain"),), step=0.03, lowest=-0.5, highest=1.0,
        about="The drive reads more current than flows, and so more torque and power.",
        about_below="The drive reads less current than flows, and so less torque and power.",
        law="i_read = g i",
        signature="Current, torque and power are off by one factor; no temperature changes.",
        check="Compare with a current clamp.",
        confused_with=("pump_1.friction", "pump_2.friction", "motor.bearing_friction", "motor.copper_resistance", "motor.demagnetisation"),
    ),
    Effect(
        id="drive.speed_lag", component="drive", domain="electrical", parameter="time_constant", unit="s",
        reference=value_of("motor_speed_loop_time_constant"), laws=(added("motor_speed_loop_time_constant"),), step=0.005,
        lowest=-0.012, highest=1.0, grows=True,
        reached=(-0.012, 0.3),
        about="The speed loop follows its command more slowly than {reference}.",
        about_below="The speed loop follows its command faster than {reference}.",
        law="tau dw/dt = w_command - w",
        signature="Speed trails its command at every change, and all that moves with it.",
        check="Record speed and command of one small step at 1 kHz, nobody within reach of the load.",
        confused_with=("oil.air_content", "line_b.compliance", "sensor.time_skew"),
    ),
)
