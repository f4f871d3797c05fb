"""Words and units of a gap diagnosis."""

import math

import pytest
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.report.gap.symbols import legend
from ddh_twin_py.report.gap.words import (
    axis_scale,
    closed,
    effect_name,
    ending,
    leaning,
    percent,
    regime_name,
    set_name,
    times_floor,
    way_closed,
)
from ddh_twin_py.report.units import plus_minus, probably


@pytest.mark.parametrize("value, std, unit, said", [
    (1.834, 0.043, "1", "1.834 ± 0.043"),
    (-7.2e-6, 3e-7, "m3/s", "−0.432 ± 0.018 L/min"),
    (6.21e6, 1.2e5, "Pa", "62.1 ± 1.2 bar"),
    (52.36, 0.5, "rad/s", "500.0 ± 4.8 rpm"),
    (2e-13, 1e-14, "m3/(s*Pa)", "1.200 ± 0.060 mL/(min·bar)"),
    (1e13, 1e12, "Pa*s2/m6", "0.0278 ± 0.0028 bar/(L/min)²"),
    (0.0, None, "N*m", "0 N·m"),
    (149.5, 0.0, "kg", "150 kg"),
    (12345.0, 678.0, "N", "12345 ± 678 N"),
])
def test_values_have_the_digits_that_their_uncertainty_allows(value, std, unit, said):
    assert plus_minus(value, std, unit) == said


def test_a_pressure_drop_is_the_same_in_both_units():
    """10 L/min through 1e13 Pa s2/m6 drop 2.78 bar."""
    flow = 10.0 / 6e4
    assert 1e13 * flow**2 * 1e-5 == pytest.approx(2.78, abs=0.01)
    assert float(plus_minus(1e13, None, "Pa*s2/m6").split()[0]) * 10.0**2 == pytest.approx(2.78, abs=0.01)


def test_variables_and_regimes_are_said_in_units_that_people_read():
    assert axis_scale("speed, rad/s", -50.0) == ("speed", "rpm", pytest.approx(30.0 / math.pi), 0.0)
    assert axis_scale("oil_temperature [K]", 290.0)[1:] == ("°C", 1.0, 273.15)
    assert axis_scale("temperature above ambient (K)", 0.0)[1:] == ("K", 1.0, 0.0)
    assert axis_scale("pressure piston side Pa", 0.0) == ("pressure piston side", "bar", 1e-5, 0.0)
    assert axis_scale("cycle", 0.0) == ("cycle", "", 1.0, 0.0)
    assert regime_name("speed 40 to 80 rad/s") == "speed 382 to 764 rpm"
    assert regime_name("oil temperature 293.15 to 303.15 K") == "oil temperature 20.0 to 30.0 °C"
    assert regime_name("speed 0 to 2.4e-13 rad/s") == "speed about 0 rpm"
    assert regime_name("pressure 370000 to 5860000 Pa") == "pressure 3.7 to 58.6 bar"
    assert regime_name("below the relief valve's opening") == "below the relief valve's opening"


def test_probabilities_are_never_more_certain_than_they_are():
    assert [percent(p) for p in (0.0, 1e-6, 0.5, 0.9999, 1.0)] == ["0 %", "< 0.5 %", "50 %", "> 99.5 %", "100 %"]
    assert [probably(p) for p in (0.0, 0.004, 0.5, 0.9999, 1.0)] == ["< 0.5 %", "< 0.5 %", "50 %", "> 99.5 %", "> 99.5 %"]
    assert [closed(f) for f in (-0.2, 0.94, 1.3)] == ["none", "94 %", "all"]
    assert [leaning(g) for g in (3.9, -3.9, 30.0, -100.0, 5.0, 5e3, 4e5)] == [
        "says nothing", "says nothing", "clear, for it", "strong, against it", "some, for it", "very strong, for it",
        "overwhelming, for it"]
    assert times_floor({"before": 3.0, "noise": 0.0}, "before") == math.inf


@pytest.mark.parametrize("before", [None, math.inf])
def test_a_gap_that_was_without_a_number_closes_from_astray(before):
    assert way_closed({"before": before, "closed_fraction": 1.0}) == "all of the way from astray to 1"


def test_the_end_of_a_diagnosis_is_called_what_it_is():
    assert ending("unknown", ()) == ending("no_gap", ()) == "parameters refitted"
    assert ending("unknown", ("learned.motor_heat",)) == "with a learned term"
    assert ending("unknown", ("load.mass",)) == "with the best listed hypothesis"
    assert ending("explained", ("load.mass",)) == "with the cause added"


def test_symbols_of_a_law_are_explained():
    assert legend("q = G (T_wall - T_ambient)") == "q: heat flow, G: conductance, T_wall: temperature of the tank's wall, " \
                                                   "T_ambient: ambient temperature"
    assert legend("p_read = g p").startswith("p_read: pressure read, g: gain") and "g: gravity" in legend(EFFECTS["load.mass"].law)
    assert all(legend(effect.law) for effect in EFFECTS.values())


def test_every_effect_has_a_name_of_its_own():
    names = [effect_name(e) for e in EFFECTS]
    assert len(set(names)) == len(EFFECTS) and not any("_" in name or "." in name for name in names)
    assert effect_name("relief_valve.setting") == EFFECTS["relief_valve.setting"].title == "relief valve: opening pressure"
    assert effect_name("pump_1.leakage") == "pump 1: leakage" and not EFFECTS["pump_1.leakage"].title
    assert effect_name("unknown") == "a cause outside the catalogue" and set_name(()).startswith("no effect")
