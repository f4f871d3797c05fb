"""What is known of the ZeMA rig before its cycles are looked at: parameters with priors, effects with neutral values."""

from __future__ import annotations

from ddh_twin_py.gap.effect import Effect, added, fixed, scaled, value_of
from ddh_twin_py.real_rigs.description import Description, Parameter
from ddh_twin_py.real_rigs.zema.recordings import WHERE

_CYCLES = "order of magnitude"
PARAMETERS = (
    Parameter("air", 22.0, 2.0, "degC", "a workshop; no sensor reads it"),
    Parameter("effectiveness", 0.5, 0.15, "1", "an air cooler of twice the rig's heat", 0.01, 0.95),
    Parameter("heat_share", 0.85, 0.07, "1", "share of the motor's power that reaches the oil: its efficiency", 0.3, 1.0),
    Parameter("pump_heat_share", 0.55, 0.15, "1", "share that is heat before TS2: the rest is turned to heat behind it", 0.1, 1.0),
    Parameter("mixing", 15.0, 8.0, "L/min", "exchange of the tank's zones; " + _CYCLES, 0.5),
    Parameter("wall", 10.0, 6.0, "W/K", "tank of a square metre or two at 8 W/(m2 K)", 0.0),
    Parameter("heat_capacity", 110.0, 40.0, "kJ/K", "some 50 L of oil and a steel tank", 20.0),
    Parameter("pump_flow", 8.7, 0.5, "L/min", _CYCLES, 1.0),
    Parameter("slip", 0.005, 0.003, "L/(min bar)", "volumetric efficiency of 0.9 at 160 bar and 40 degC", 0.0),
    Parameter("gas", 65.0, 30.0, "L bar", "half a litre of gas at 130 bar", 1.0),
    Parameter("closing", 0.1, 0.05, "s", "proportional valve of this size", 0.0),
    Parameter("opening", 0.25, 0.1, "s", "the same, with the time that the load's pressure takes", 0.0),
    Parameter("flow_late", 0.02, 0.02, "s", "turbine of the flow sensor"),
    Parameter("rise_late", 0.0, 0.02, "s", "what the closing by pressure is off for the pressure before the valve"),
    Parameter("rise_ratio", 0.85, 0.1, "1", "gas that is compressed within a second is stiffer than at constant temperature", 0.5, 1.1),
)
NEUTRAL = {"leakage": 0.0, "FS1_gain": 1.0, "TS1_offset": 0.0, "TS2_offset": 0.0, "TS3_offset": 0.0, "TS4_offset": 0.0}

COOLER, VALVE, PUMP, ACCUMULATOR = "cooler.effectiveness", "valve.switching", "pump.leakage", "accumulator.precharge"


def _offset(number: int) -> Effect:
    return Effect(
        id=f"sensor.TS{number}_offset", component="sensor", domain="measurement", parameter="offset", unit="K", reference=fixed(0.0),
        laws=(added(f"TS{number}_offset"),), step=0.5, lowest=-10.0, highest=10.0,
        about=f"Zero error of the temperature sensor TS{number}.", law="T_read = T + b", signature="One temperature alone.",
        check="Compare the sensors at standstill in the morning.")


EFFECTS = (
    Effect(id=COOLER, component="cooler", domain="thermal", parameter="effectiveness", unit="1", reference=value_of("effectiveness"),
           laws=(scaled("effectiveness"),), step=0.2, lowest=-0.98, highest=0.0,
           about="The cooler brings the oil less near to the air's temperature.", law="T_4 = T_3 - eps (T_3 - T_air)",
           signature="The outlet's temperature first, then all of the oil; TS3 - TS4 shrinks.", check="Fan, fins, bypass of the cooler."),
    Effect(id=PUMP, component="pump", domain="hydraulic", parameter="leakage", unit="L/min", reference=fixed(0.0),
           laws=(added("leakage"),), step=0.1, lowest=0.0, highest=8.0,
           about="Oil goes back inside the pump; the leakage at 155 bar is told.", law="Q = Q_0 - slip - q sqrt(p/155 bar)",
           signature="Flow at every load, whatever the oil's temperature says of it.", check="Drain line of the pump."),
    Effect(id=VALVE, component="valve", domain="hydraulic", parameter="lag", unit="s", reference=fixed(0.0),
           laws=(added("closing", "opening"), added("closing"), added("opening")), step=0.01, lowest=-0.5, highest=0.8,
           about="The directional valve switches late, when closing, opening or both.", law="t = t_0 + x",
           signature="Pressure behind the valve in the seconds of switching.", check="Solenoid current, spool, pilot filter."),
    Effect(id=ACCUMULATOR, component="accumulator", domain="hydraulic", parameter="precharge_ratio", unit="1", reference=fixed(1.0),
           laws=(scaled("gas"),), step=-0.1, lowest=-0.9, highest=0.0,
           about="The gas is not charged to its pressure and stores less oil.", law="V = x p_0 V_0 (1/a - 1/b)",
           signature="Oil that is taken up and given back at every step of the load; the rise of pressure after the closing.",
           check="Pre-charge with the oil side empty."),
    *(_offset(number) for number in (1, 2, 3, 4)),
    Effect(id="sensor.FS1_gain", component="sensor", domain="measurement", parameter="gain", unit="1", reference=fixed(1.0),
           laws=(scaled("FS1_gain"),), step=0.02, lowest=-0.5, highest=0.5, about="Span error of the flow sensor FS1.",
           law="Q_read = k Q", signature="Flow at all loads in proportion, the stored oil with it.", check="Measuring glass and clock.",
           confused_with=(PUMP,)),
)

DESCRIPTION = Description(
    rig="zema", source=WHERE, parameters=PARAMETERS, neutral=NEUTRAL, effects=EFFECTS,
    assumptions=("the air's temperature is not measured and taken as constant", "all oil in the return zone has one temperature",
                 "the accumulator's gas follows its law at constant temperature"))
