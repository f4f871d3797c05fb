"""What the rod carries."""

from __future__ import annotations

from ddh_twin_py.gap.effect import Effect, added, fixed, value_of

EFFECTS = (
    Effect(
        id="load.mass", component="load", domain="mechanical", parameter="mass", unit="kg",
        reference=value_of("load_payload_mass"), laws=(added("load_payload_mass"),), step=3.0, lowest=-2000.0, highest=20000.0,
        about="The payload is heavier than was declared.",
        about_below="The payload is lighter than was declared.",
        law="m dv/dt = p_A A_A - p_B A_B - m g - F_f",
        signature="Piston-side pressure shifts alike in lifting, lowering and rest.",
        check="Weigh the load on a scale or a load cell rated for it; on a hoist nobody stands beneath.",
        confused_with=("cylinder.seal_friction", "load.geometry", "sensor.pressure_piston_side_offset"),
    ),
    Effect(
        id="load.geometry", component="load", domain="mechanical", parameter="force_slope", unit="N/m",
        reference=fixed(0.0), laws=(added("load_force_slope"),), step=300.0, lowest=-2e4, highest=2e4,
        about="The load force changes along the stroke (a boom, a linkage); zero at mid-stroke.",
        law="F = s (x - stroke/2)",
        signature="Piston-side pressure changes with the rod's position, in rest and in motion.",
        check="Stop near both ends of the stroke, nobody beneath the load, and compare the pressures.",
        confused_with=("cylinder.seal_friction", "load.mass"),
    ),
)
