"""Relief and anti-cavitation check valves."""

from __future__ import annotations

from ddh_twin_py.physics.compiled import inlined


@inlined
def relief_flow(pressure, p):
    """Flow of the rod-side relief valve to tank, m3/s: slope max(0, p - p_open)."""
    return p.relief_valve_slope * max(0.0, pressure - p.relief_valve_opening_pressure)


@inlined
def check_flow(pressure, p):
    """Flow from tank through a check valve, m3/s: G max(0, -p - p_crack)."""
    return p.check_valve_conductance * max(0.0, -pressure - p.check_valve_cracking_pressure)
