"""Voltage and power at single instants."""

from __future__ import annotations

from ddh_twin_py.physics import motor
from ddh_twin_py.physics.compiled import equation, kernel
from ddh_twin_py.physics.thermal_network import END_WINDING, ROTOR, SLOT_WINDING


@equation
def _between(temperatures, node, first, part):
    """Temperature of a node so far between the end of one interval and that of the next."""
    early = temperatures[first, node]
    return early if part == 0.0 else early + part * (temperatures[first + 1, node] - early)


@kernel
def electrical_samples(params, speed, current, time, interval, temperatures, voltage, power):
    """Fill voltage (V rms, line to line) and electrical power (W) of instants, (m,).

    Args:
        params: parameters, (1,). speed: rad/s, (m,). current: A rms, (m,). time: of each instant, s, (m,).
        interval: s. temperatures: of all nodes at the end of each interval, K, (n, N); linear in between.
    """
    p = params[0]
    iron = motor.iron_coefficients(p)
    last = temperatures.shape[0] - 1
    for i in range(speed.shape[0]):
        at = min(max(time[i] / interval - 1.0, 0.0), float(last))
        first = int(at)
        part = at - first
        slot, end, rotor = (_between(temperatures, SLOT_WINDING, first, part), _between(temperatures, END_WINDING, first, part),
                            _between(temperatures, ROTOR, first, part))
        resistance = motor.phase_resistance(slot, end, p)
        teeth, yoke = motor.iron_losses(speed[i], iron, p)
        magnets = motor.magnet_factor(rotor, p)
        voltage[i] = motor.line_voltage(speed[i], current[i], resistance, magnets, p)
        power[i] = (magnets * p.motor_torque_constant * current[i] * speed[i] + 3.0 * resistance * current[i] ** 2 + teeth + yoke
                    + p.motor_pwm_loss_reported * p.motor_pwm_loss)
