"""Ways of heat."""

from __future__ import annotations

from ddh_twin_py.gap.effect import Effect, added, divided, fixed, scaled


def _cooling(name: str, component: str, what: str, fields: tuple[str, ...], *confused_with: str, title: str = "") -> Effect:
    return Effect(
        id=name, title=title, component=component, domain="thermal", parameter="convection_ratio", unit="1",
        reference=fixed(1.0), laws=(scaled(*fields),), step=0.3, lowest=-0.98, highest=30.0,
        reached=(-0.95, 9.0),  # wind or a fan carries about ten times what still air does
        about=f"Convection carries more heat away from {what} than {{reference}} (a fan, wind).",
        about_below=f"Convection carries less heat away from {what} than {{reference}} (dust, a cover).",
        law="q = A r C |dT|^1.25",
        signature=f"Temperature of {what} drifts from the twin's as the unit warms, in all phases alike.",
        check="Clean or shield the surface and repeat.",
        confused_with=confused_with,
    )


EFFECTS = (
    Effect(
        id="motor.contact_resistance", component="motor", domain="thermal", parameter="resistance_ratio", unit="1",
        reference=fixed(1.0), laws=(divided("motor_yoke_to_housing"),), step=1.0, lowest=-0.9, highest=500.0, grows=True,
        reached=(-0.9, 30.0),  # a shrink fit against a gap of 0.2 mm of air
        about="Heat passes worse from stator to housing (interface gap).",
        about_below="Heat passes better from stator to housing than {reference}.",
        law="G = G_0/r between yoke and housing",
        signature="Winding warmer while the housing trails behind and is cooler.",
        check="Compare winding and housing some minutes after a hard duty.",
        confused_with=("motor.copper_resistance", "motor.cooling", "sensor.surface_contact"),
    ),
    _cooling("motor.cooling", "motor", "the motor's housing", ("motor_housing_convection",),
             "motor.iron_loss", "motor.pwm_loss", "motor.contact_resistance", "motor.flange_conduction", "ambient.solar_load",
             "ambient.enclosure", "sensor.surface_contact"),
    Effect(
        id="motor.flange_conduction", component="motor", domain="thermal", parameter="conductance", unit="W/K",
        reference=fixed(0.0), laws=(added("motor_flange_conductance"),), step=0.5, lowest=0.0, highest=200.0,
        reached=(0.0, 40.0),  # a steel flange of 200 cm², 2 cm thick
        about="Heat flows between motor and pump 1 through flange and shaft.",
        law="q = G (T_housing - T_pump_1_case)",
        signature="Housing and case of pump 1 come closer to each other.",
        check="With the drive locked out put a temperature sensor on the flange, its cable clear of the shaft.",
        confused_with=("pump_1.friction", "motor.cooling", "pump_1.cooling"),
    ),
    _cooling("pump_1.cooling", "pump_1", "both pump cases", ("pump_1_convection", "pump_2_convection"),
             "pump_1.friction", "pump_2.friction", "motor.flange_conduction", "ambient.enclosure", "sensor.surface_contact",
             title="pumps: cooling of both cases"),
    _cooling("tank.cooling", "tank", "the tank", ("tank_convection",),
             "tank.mount_conduction", "tank.oil_level", "ambient.solar_load", "ambient.enclosure", "sensor.surface_contact"),
    Effect(
        id="tank.oil_level", component="tank", domain="thermal", parameter="volume_ratio", unit="1",
        reference=fixed(1.0), laws=(scaled("tank_oil_volume"),), step=-0.1, lowest=-0.85, highest=1.5,
        feigned=0.03,  # oil that lies in layers takes part in other shares where another duty stirs it
        about="There is more oil in the tank than {reference}.",
        about_below="There is less oil in the tank than {reference}.",
        law="C = rho c r V",
        signature="Tank oil warms faster (or slower), steady temperatures alike.",
        check="Read the level.",
        confused_with=("tank.cooling", "tank.mount_conduction", "sensor.temperature_lag"),
    ),
    Effect(
        id="tank.mount_conduction", component="tank", domain="thermal", parameter="conductance", unit="W/K",
        reference=fixed(0.0), laws=(added("tank_mount_conductance"),), step=1.0, lowest=0.0, highest=500.0,
        reached=(0.0, 50.0),  # steel feet of 100 cm² in all, 1 cm thick
        unsteady=0.5,  # the frame is between as cold as the air and as warm as the tank
        about="The tank loses heat through its mounts into the machine's frame.",
        law="q = G (T_wall - T_ambient)",
        signature="Tank wall and oil cooler in proportion to their rise, where convection would grow faster.",
        check="Measure the mounts' temperature.",
        confused_with=("tank.cooling", "tank.oil_level", "sensor.surface_contact"),
    ),
    _cooling("cylinder.cooling", "cylinder", "the barrel", ("cylinder_convection",),
             "cylinder.seal_friction", "ambient.solar_load", "ambient.enclosure", "sensor.surface_contact"),
)
