"""Oil that takes the wrong way inside pumps and cylinder."""

from __future__ import annotations

from ddh_twin_py.gap.effect import Effect, added, fixed, scaled


def _pump(number: int, side: str, *confused_with: str) -> Effect:
    return Effect(
        id=f"pump_{number}.leakage", component=f"pump_{number}", domain="hydraulic", parameter="leakage_ratio", unit="1",
        reference=fixed(1.0), laws=(scaled(f"pump_{number}_leakage"),), step=0.1, lowest=-0.8, highest=30.0, grows=True,
        reached=(-0.8, 9.0),  # a pump is exchanged before it leaks ten times as much as new
        about=f"Internal leakage of pump {number} grows with wear; flow is lost and turned to heat in the pump.",
        about_below=f"Pump {number} leaks less inside than {{reference}}.",
        law=f"Q_leak = r L_{number} (mu_0/mu(T)) p_{number}",
        signature=f"Pressure of the {side} side in motion, strokes a little shorter, pump {number} warmer.",
        check=(
            "Secure the load; depressurised, lead the pump to tank through a throttle, with a rated gauge and a relief valve between "
            "pump and throttle, set below the ratings of pump and hose, and let the other pump circulate to tank; turn the shaft "
            "slowly, close the throttle in steps below the relief setting and measure speed against pressure."
        ),
        confused_with=confused_with,
    )


EFFECTS = (
    _pump(1, "piston", "cylinder.cross_leakage", "oil.viscosity_temperature", "oil.air_content", "sensor.rod_position_scale"),
    _pump(2, "rod", "relief_valve.seat_leakage", "relief_valve.setting", "cylinder.cross_leakage", "oil.viscosity_temperature",
          "sensor.pressure_rod_side_gain"),
    Effect(
        id="cylinder.cross_leakage", component="cylinder", domain="hydraulic", parameter="conductance", unit="m3/(s*Pa)",
        reference=fixed(0.0), laws=(added("cylinder_cross_leakage"),), step=2e-13, lowest=0.0, highest=1e-10,
        about="Oil passes the piston seal between the chambers.",
        law="Q = G (p_A - p_B)",
        signature="Pressures of both sides come closer; the rod creeps under load; barrel a little warmer.",
        check=(
            "Extend the rod to its end stop and secure the load; depressurised, take both lines off the cylinder and plug them, lead "
            "the rod-side port into a measuring glass, raise the piston side with a hand pump that has a gauge and a relief valve, "
            "and measure what comes. Never block both ports under load: past a leaking seal both sides rise to load over rod area."
        ),
        confused_with=("pump_1.leakage", "pump_2.leakage", "relief_valve.seat_leakage"),
    ),
)
