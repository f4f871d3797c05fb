"""Relief and anti-cavitation check valves."""

from __future__ import annotations

from ddh_twin_py.physics.compiled import equation


@equation
def relief_flow(pressure, p):
    """Flow of the rod-side relief valve to tank, m3/s: slope max(0, p - p_open) + G_seat max(0, p), p in Pa gauge."""
    return p.relief_valve_slope * max(0.0, pressure - p.relief_valve_opening_pressure) + p.relief_valve_seat_leakage * max(0.0, pressure)


@equation
def relief_flow_slope(pressure, p):
    """dQ/dp of `relief_flow`, m3/(s*Pa), at a pressure in Pa gauge."""
    slope = p.relief_valve_seat_leakage if pressure > 0.0 else 0.0
    return slope + p.relief_valve_slope if pressure > p.relief_valve_opening_pressure else slope


@equation
def check_flow(pressure, p):
    """Flow from tank through a check valve, m3/s: G max(0, -p - p_crack), p in Pa gauge, tank at 0."""
    return p.check_valve_conductance * max(0.0, -pressure - p.check_valve_cracking_pressure)
