"""Voltage and power at single instants."""

from __future__ import annotations

from ddh_twin_py.physics import motor
from ddh_twin_py.physics.compiled import kernel


@kernel
def electrical_samples(params, speed, current, slot_temperature, end_temperature, rotor_temperature, voltage, power):
    """Fill voltage (V rms, line to line) and electrical power (W) of instants; speed (rad/s), current (A rms), temperatures (K): (n,)."""
    p = params[0]
    iron = motor.iron_coefficients(p)
    for i in range(speed.shape[0]):
        resistance = motor.phase_resistance(slot_temperature[i], end_temperature[i], p)
        teeth, yoke = motor.iron_losses(speed[i], iron, p)
        magnets = motor.magnet_factor(rotor_temperature[i], p)
        voltage[i] = motor.line_voltage(speed[i], current[i], resistance, magnets, p)
        power[i] = (magnets * p.motor_torque_constant * current[i] * speed[i] + 3.0 * resistance * current[i] ** 2 + teeth + yoke
                    + p.motor_pwm_loss_reported * p.motor_pwm_loss)
