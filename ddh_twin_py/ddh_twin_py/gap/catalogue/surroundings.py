"""Sun and air around the unit."""

from __future__ import annotations

from ddh_twin_py.gap.effect import Effect, added, fixed

EFFECTS = (
    Effect(
        id="ambient.solar_load", component="ambient", domain="thermal", parameter="power", unit="W",
        reference=fixed(0.0), laws=(added("surroundings_solar_load"),), step=30.0, lowest=0.0, highest=2000.0,
        reached=(0.0, 1000.0),  # full sun on 1 m²
        about="Sunlight heats motor housing, tank and barrel in proportion to their area; the total of the three.",
        law="q_i = P A_i / sum(A)",
        signature="Housing, tank wall and barrel rise alike from the first minute, at rest too.",
        check="Shade the unit.",
        confused_with=("motor.pwm_loss", "motor.cooling", "tank.cooling", "cylinder.cooling", "ambient.enclosure"),
    ),
    Effect(
        id="ambient.enclosure", component="ambient", domain="thermal", parameter="temperature_rise", unit="K",
        reference=fixed(0.0), laws=(added("surroundings_enclosure_rise"),), step=2.0, lowest=-20.0, highest=60.0,
        about="The unit sits in warmer air than the ambient sensor reads.",
        about_below="The unit sits in cooler air than the ambient sensor reads.",
        law="T_a = T_read + dT",
        signature="All surfaces drift towards a warmer surrounding, the thin-walled first.",
        check="Hang a second thermometer beside the unit.",
        confused_with=(
            "motor.cooling", "pump_1.cooling", "tank.cooling", "cylinder.cooling", "ambient.solar_load", "sensor.surface_contact",
        ),
    ),
)
