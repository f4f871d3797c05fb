"""Relief and check valves."""

from __future__ import annotations

from ddh_twin_py.gap.effect import Effect, added, fixed, value_of

EFFECTS = (
    Effect(
        id="relief_valve.setting", component="relief_valve", domain="hydraulic", parameter="opening_pressure", unit="Pa",
        title="relief valve: opening pressure",
        reference=value_of("relief_valve_opening_pressure"), laws=(added("relief_valve_opening_pressure"),), step=5e5,
        lowest=-1.2e7, highest=2e7,
        about="The rod-side relief valve opens at a higher pressure than {reference}.",
        about_below="The rod-side relief valve opens at a lower pressure than {reference}.",
        law="Q = s max(0, p_B - p_open)",
        signature="Rod-side pressure of the lift is cut at another level; nothing while it stays below.",
        check=(
            "Secure the load, depressurise, take the valve to a test stand and raise its pressure slowly with a hand pump, with a "
            "rated gauge and a second relief valve set above it, until flow to tank begins."
        ),
        confused_with=("pump_2.leakage", "relief_valve.seat_leakage", "sensor.pressure_rod_side_gain"),
    ),
    Effect(
        id="relief_valve.seat_leakage", component="relief_valve", domain="hydraulic", parameter="conductance", unit="m3/(s*Pa)",
        reference=fixed(0.0), laws=(added("relief_valve_seat_leakage"),), step=2e-13, lowest=0.0, highest=1e-10,
        about="The rod-side relief valve leaks to tank below its opening pressure.",
        law="Q = G max(0, p_B) to tank",
        signature="Rod-side pressure falls in the lift and at rest; the heat appears in tank and valve, not in pump 2.",
        check=(
            "Fix a thermometer to the valve's tank line, or, depressurised, a flow meter into it, and read it while the rod side is "
            "under pressure below the valve's setting; no hand on a line under pressure."
        ),
        confused_with=("pump_2.leakage", "cylinder.cross_leakage", "relief_valve.setting", "sensor.pressure_rod_side_gain"),
    ),
    Effect(
        id="check_valve.cracking", component="check_valve", domain="hydraulic", parameter="cracking_pressure", unit="Pa",
        title="check valve: cracking pressure",
        reference=value_of("check_valve_cracking_pressure"), laws=(added("check_valve_cracking_pressure"),), step=1e4,
        lowest=-3e4, highest=9e4, grows=True,
        about="The anti-cavitation check valve opens late, the rod side runs at a vacuum when lowering.",
        about_below="The anti-cavitation check valve opens earlier than {reference}.",
        law="Q = G max(0, -p - p_crack)",
        signature="Rod-side pressure while lowering lies further below tank pressure.",
        check="Read the rod-side pressure while lowering slowly, nobody beneath the load.",
        confused_with=("sensor.pressure_rod_side_offset",),
    ),
)
