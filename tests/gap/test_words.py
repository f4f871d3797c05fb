"""The verdict in one sentence."""

import math

import pytest
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.words import BesideReport, careful, sentence

SHRINK = {"speed": {"after": 0.1, "noise": 0.1}, "temperature/motor_winding": {"after": 1.5, "noise": 1.0}}
NO_GAP = {"verdict": "no_gap", "gap": {"as_is": 5.0, "before": 6.0, "after": 1.0}, "hypotheses": [{"effects": [], "probability": 1.0}],
          "shrink": SHRINK}


@pytest.mark.parametrize(("unseen", "pressed", "likely", "ends"), [
    ((), (), "that no effect acts is > 99.5 % likely.", " Unfitted the twin was 5.0 times the floor off, which calibration closes."),
    (("pump_1.leakage up to 1.43",), (), "that no effect acts is > 99.5 % likely.",
     " The notes name 1 effect that would not show."),
    (("a", "b"), ("c (1 instead of 2)", "d", "e"), "that no effect acts is > 99.5 % likely.",
     " The notes name 3 parameters at the end of what a fit may use and 2 effects that would not show."),
    ((), ("c",), "that no effect acts is > 99.5 % likely.", " The notes name 1 parameter at the end of what a fit may use."),
])  # fmt: skip
def test_no_gap_is_the_verdict_and_one_calm_sentence(unseen, pressed, likely, ends):
    said = sentence({**NO_GAP, "gap": {"as_is": 5.0, "before": 1.1, "after": 1.0}}, EFFECTS, BesideReport(unseen, pressed=pressed))
    first, *rest = said.split(". ")
    assert first.startswith("No gap: ") and likely in f"{first}." and " " + ". ".join(rest) == ends and len(rest) == 1
    assert not any(word in said for word in ("had to", "wrong", "hide", "stays", "a fit may use, "))


def test_no_gap_of_a_twin_that_needs_no_fit_is_the_verdict_alone():
    said = sentence({**NO_GAP, "gap": {"as_is": 1.1, "before": 1.1, "after": 1.0}}, EFFECTS)
    assert said.endswith("likely.") and said.count(". ") == 0


@pytest.mark.parametrize(("none", "others", "begins", "ends"), [
    (0.95, [(["unknown"], 0.05)], "No gap: ", "and that no effect acts is 95 % likely."),
    (0.6, [(["unknown"], 0.38), (["load.mass"], 0.02)], "Probably no gap: ",
     "and that no effect acts is 60 % likely (something that is not listed 38 %)."),
])  # fmt: skip
def test_no_gap_that_is_not_sure_says_what_else_it_may_be(none, others, begins, ends):
    sets = [{"effects": [], "probability": none}, *({"effects": ids, "probability": p} for ids, p in others)]
    said = sentence({**NO_GAP, "hypotheses": sets}, EFFECTS)
    assert said.startswith(begins) and said.partition(" Unfitted")[0].endswith(ends)


def test_the_surest_of_two_effects_is_named_first_and_each_has_its_probability():
    why = [{"effect": "pump_1.leakage", "probability": 0.95}, {"effect": "motor.flange_conduction", "probability": 0.52}]
    report = {"verdict": "explained", "gap": {"as_is": 9.0, "before": 2.8, "after": 1.1}, "shrink": SHRINK, "why": why, "classes": [],
              "hypotheses": [{"effects": ["motor.flange_conduction", "pump_1.leakage"], "probability": 0.5}]}
    said = sentence(report, EFFECTS, BesideReport(together=0.93))
    assert said.startswith("The gap is explained by pump_1.leakage")
    assert said.endswith("(probability 50 %, 93 % with what it cannot be told from; pump_1.leakage 95 %, motor.flange_conduction 52 % each "
                         "for itself).")
    one = {**report, "why": [{"effect": "pump_1.leakage", "probability": 0.95}],
           "hypotheses": [{"effects": ["pump_1.leakage"], "probability": 0.74}]}
    assert sentence(one, EFFECTS, BesideReport(together=0.95)).endswith("(probability 74 %, 95 % alone or beside others).")
    sure = {**report, "hypotheses": [{**report["hypotheses"][0], "probability": 0.94}]}
    assert sentence(sure, EFFECTS, BesideReport(together=0.94)).endswith("(probability 94 %).")


def test_no_gap_names_a_signal_that_is_left_off():
    said = sentence({**NO_GAP, "shrink": {**SHRINK, "temperature/tank_wall": {"after": 0.62, "noise": 0.2}}}, EFFECTS)
    assert " Temperature, tank wall stays 3.1 times its floor off, and no listed effect explains that" in said
    said = sentence({**NO_GAP, "shrink": {**SHRINK, "temperature/motor_winding": {"after": 2.8, "noise": 1.0}}}, EFFECTS,
                    BesideReport(amplified=["temperature/motor_winding"]))
    assert " Temperature, motor winding, which small flaws of the model move far, stays 2.8 times its floor off" in said
    report = {**NO_GAP, "shrink": {"temperature/motor_winding": {"after": 2.2, "noise": 1.0}, "rod_position": {"after": 2.3, "noise": 1.0}}}
    assert " Stroke error stays 2.3 times its floor off" in sentence(report, EFFECTS), "as the page's tables call it"


@pytest.mark.parametrize(("since", "who"), [
    ({"relief_valve.setting": "a 1 bar instead of 2 bar"}, "relief_valve.setting"),
    ({"relief_valve.setting": "a 1 bar instead of 2 bar", "b": "", "c": ""}, "relief_valve.setting and 2 more"),
])  # fmt: skip
def test_no_gap_says_right_after_the_verdict_what_may_have_changed(since, who):
    first, second = sentence(NO_GAP, EFFECTS, BesideReport(since=since, pressed=["p"], unseen=["u"])).split(". ")
    assert first == ("No gap: with its parameters fitted within 2.5 times their tolerances the twin explains data not used for that to 1.0 "
                     "times the floor, and that no effect acts is > 99.5 % likely")
    assert second == f"But {who} may have changed since commissioning, which these recordings cannot tell."
    plain = sentence(NO_GAP, EFFECTS)
    assert plain.endswith(" Unfitted the twin was 5.0 times the floor off, fitted to the commissioning recording alone 6.0.")
    assert "But " not in sentence(NO_GAP, EFFECTS)


@pytest.mark.parametrize(("before", "begins"), [
    (2.3, "There is a gap of 2.3 times the floor, and these cannot be told apart surely: "),
    (0.9, "Data not used for that lie 0.9 times the floor off, which is no gap, but the recording in which it was sought asks for a cause"),
])
def test_what_is_within_the_floor_is_called_no_gap(before, begins):
    report = {"verdict": "ambiguous", "gap": {"as_is": 5.0, "before": before, "after": 0.9}, "hypotheses": [
        {"effects": ["load.mass"], "probability": 0.4}, {"effects": [], "probability": 0.3}]}
    assert sentence(report, EFFECTS).startswith(begins) and sentence(report, EFFECTS).endswith("load.mass 40 %; no effect 30 %.")


def test_what_is_unknown_within_the_floor_is_called_no_gap():
    report = {**_unknown(("motor", 1.0)), "gap": {"as_is": 9.0, "before": 0.9, "after": 0.9}}
    assert sentence(report, EFFECTS) == ("Data not used for that lie 0.9 times the floor off, which is no gap, but the recording in which "
                                         "it was sought asks for a cause at motor (mechanical) that no listed effect explains.")


def test_no_gap_says_what_a_duty_of_its_own_asks_of_the_rig():
    """A valve that opened in no fitted recording: what is open of it explains the gap, so that nothing stays off."""
    report = {**NO_GAP, "gap": {"as_is": 5.0, "before": 3.9, "after": 3.9}, "shrink": {**SHRINK, "speed": {"after": 1.0, "noise": 0.1}}}
    said = sentence(report, EFFECTS, BesideReport(at_best={"speed": 1.04, "temperature/motor_winding": 0.9},
                                             asked_for="relief_valve.opening_pressure"))
    assert "to 3.9 times the floor" in said
    assert "and 1.0 times with another relief_valve.opening_pressure, which no fitted recording" in said
    assert "stays" not in said and "Speed stays 10.0 times" in sentence(report, EFFECTS)


@pytest.mark.parametrize(("left", "ends"), [(1.5, "> 99.5 %)."), (3.1, "; pressure, rod side stays 3.1 times its floor off, which nothing "
                                                                    "that is listed explains.")])  # fmt: skip
def test_sizes_are_in_the_units_of_the_page_and_nothing_is_quite_sure(left, ends):
    drop = {"value": 6.508e12, "std": 6.7e11, "unit": "Pa*s2/m6", "nominal": 0.0}
    report = {"verdict": "explained", "gap": {"as_is": 9.0, "before": 2.8, "after": 1.1}, "classes": [],
              "shrink": {"pressure_rod_side": {"after": left, "noise": 1.0}},
              "hypotheses": [{"effects": ["line_b.pressure_drop"], "probability": 1.0}],
              "why": [{"effect": "line_b.pressure_drop", "probability": 1.0, "parameters": {"quadratic_coefficient": drop}}]}
    said = sentence(report, EFFECTS)
    assert "quadratic coefficient 0.0181 ± 0.0019 bar/(L/min)²" in said and "probability > 99.5 %" in said
    assert "Pa*s2" not in said and "e+" not in said and said.endswith(ends) and "it shrinks from 2.8 to 1.1 times the floor" in said


def test_an_effect_explains_though_what_is_unknown_is_likelier_than_each_of_its_class():
    report = {"verdict": "explained", "gap": {"as_is": 9.0, "before": 2.8, "after": 1.1}, "shrink": SHRINK, "why": [],
              "classes": [["pump_1.leakage", "pump_2.leakage"]],
              "hypotheses": [{"effects": ["unknown"], "probability": 0.25}, {"effects": ["pump_1.leakage"], "probability": 0.24}]}
    assert "explained by unknown" not in sentence(report, EFFECTS) and "pump_1.leakage" in sentence(report, EFFECTS)


def test_a_class_stands_beside_the_effect_that_it_is_of():
    report = {"verdict": "explained", "gap": {"as_is": 9.0, "before": 2.8, "after": 1.1}, "shrink": SHRINK, "why": [],
              "classes": [["pump_1.leakage", "pump_2.leakage"]],
              "hypotheses": [{"effects": ["pump_1.leakage", "sensor.surface_contact"], "probability": 0.9, "gap_after": 1.1}]}
    said = sentence(report, EFFECTS)
    assert said.index("pump_1.leakage") < said.index("cannot tell from pump_2.leakage, and sensor.surface_contact")


@pytest.mark.parametrize(("rise", "air"), [(3.0, "warmer"), (-3.0, "cooler")])
def test_what_happens_is_said_in_the_direction_found(rise, air):
    found = {"value": rise, "std": 0.2, "unit": "K", "nominal": 0.0}
    report = {"verdict": "explained", "gap": {"as_is": 9.0, "before": 2.8, "after": 1.1}, "classes": [], "shrink": SHRINK,
              "hypotheses": [{"effects": ["ambient.enclosure"], "probability": 0.9}],
              "why": [{"effect": "ambient.enclosure", "probability": 0.9, "parameters": {"temperature_rise": found}}]}
    assert f"the unit sits in {air} air than the ambient sensor reads)" in sentence(report, EFFECTS)


def test_a_cause_of_which_held_out_data_show_nothing_shrinks_nothing():
    report = {"verdict": "explained", "gap": {"as_is": 5.0, "before": 0.8, "after": 0.76}, "classes": [], "shrink": SHRINK,
              "hypotheses": [{"effects": ["motor.contact_resistance"], "probability": 0.96}], "why": []}
    said = sentence(report, EFFECTS)
    assert "only the recording in which it was sought tells of it: data not used" in said
    assert "with it and without it (0.8 and 0.8 times)" in said
    shrinks = {**report, "gap": {**report["gap"], "after": 0.5}}
    assert "shrinks" not in said and "it shrinks from 0.8 to 0.5" in sentence(shrinks, EFFECTS)


@pytest.mark.parametrize(("before", "commissioned", "hidden", "taken_up"), [
    (1.03, False, True, True), (1.03, True, True, False), (3.4, False, False, False)])
def test_a_cause_without_a_gap_in_held_out_data_says_what_hides_it_there(before, commissioned, hidden, taken_up):
    report = {"verdict": "explained", "gap": {"as_is": 9.0, "before": before, "after": 0.9}, "classes": [], "shrink": SHRINK,
              "hypotheses": [{"effects": ["motor.copper_resistance"], "probability": 0.73}], "why": []}
    said = sentence(report, EFFECTS, BesideReport(commissioned=commissioned))
    assert ("hardly anything is beyond the floor" in said) is hidden
    assert ("the rig's own parameters may take up what it does" in said) is taken_up


@pytest.mark.parametrize(("without", "alone"), [(4.4, True), (8.3, False)])
def test_what_parameters_close_as_well_is_not_said_to_be_closed_by_a_cause(without, alone):
    report = {"verdict": "explained", "gap": {"as_is": 20.1, "before": 8.5, "after": 4.5}, "classes": [], "shrink": SHRINK, "why": [],
              "hypotheses": [{"effects": ["motor.flange_conduction"], "probability": 0.6, "gap_after": 4.5},
                             {"effects": [], "probability": 0.1, "gap_after": without}]}
    said = sentence(report, EFFECTS)
    assert ("lie 4.5 times the floor off with it and 4.4 times without it, once the rig's parameters" in said) is alone
    assert ("it shrinks from 8.5 to 4.5" in said) is not alone


@pytest.mark.parametrize(("without", "share"), [(6.0, ", where the rig's parameters fitted anew without it leave 6.0"), (8.2, "")])
def test_what_parameters_close_of_a_gap_is_not_credited_to_the_cause(without, share):
    report = {"verdict": "explained", "gap": {"as_is": 20.1, "before": 8.5, "after": 1.1}, "classes": [], "shrink": SHRINK, "why": [],
              "hypotheses": [{"effects": ["motor.flange_conduction"], "probability": 0.8, "gap_after": 1.1},
                             {"effects": [], "probability": 0.1, "gap_after": without}]}
    assert f"it shrinks from 8.5 to 1.1 times the floor on data not used to find it{share} (probability" in sentence(report, EFFECTS)


def test_a_cause_that_leaves_held_out_data_off_shrinks_nothing():
    report = {"verdict": "explained", "gap": {"as_is": 9.0, "before": 1.2, "after": 1.8}, "classes": [], "shrink": SHRINK,
              "hypotheses": [{"effects": ["motor.pwm_loss"], "probability": 0.9}], "why": []}
    said = sentence(report, EFFECTS, BesideReport(at_best={"speed": 1.0}, asked_for="tank.area"))
    assert "data not used to find it lie 1.8 times the floor off, 1.2 without it, and 1.0 times with another tank.area, which" in said
    assert "shrinks" not in said


def _unknown(*shares):
    where = [{"component": name, "share": share} for name, share in shares]
    return {"verdict": "unknown", "gap": {"as_is": 9.0, "before": 2.8, "after": 2.8}, "where": where, "hypotheses": [],
            "unknown": {"component": shares[0][0], "domain": "mechanical"}}


@pytest.mark.parametrize(("shares", "place"), [
    ([("motor", 0.5), ("motor", 0.4), ("pump_1", 0.1)], "at motor (mechanical) that"),
    ([("pump_1", 0.35), ("motor", 0.3), ("tank", 0.2), ("oil", 0.15)],
     "at pump_1 (mechanical), 35 % likely, or at motor 30 %, tank 20 %, that"),
])  # fmt: skip
def test_an_unknown_place_that_is_not_sure_is_named_with_the_next_ones(shares, place):
    assert sentence(_unknown(*shares), EFFECTS) == f"There is a gap of 2.8 times the floor {place} no listed effect explains."


def test_a_reading_that_errs_is_named():
    said = sentence(_unknown(("sensor", 1.0)), EFFECTS, BesideReport(reading="pressure_rod_side"))
    assert " at sensor (mechanical: pressure_rod_side) that " in said


@pytest.mark.parametrize(("commissioned", "said"), [
    (True, "than at commissioning"), (False, "than the sheet says"), (None, "than expected"),
])  # fmt: skip
def test_a_cause_is_told_against_what_it_was_counted_from(commissioned, said):
    oil = {"value": 0.8, "std": 0.1, "unit": "1", "nominal": 1.0}
    report = {"verdict": "explained", "gap": {"as_is": 9.0, "before": 2.8, "after": 1.1}, "classes": [], "shrink": SHRINK,
              "hypotheses": [{"effects": ["tank.oil_level"], "probability": 1.0}],
              "why": [{"effect": "tank.oil_level", "probability": 1.0, "parameters": {"level_ratio": oil}}]}
    assert f"there is less oil in the tank {said})" in sentence(report, EFFECTS, BesideReport(commissioned=commissioned))


def test_what_is_wrong_with_recordings_stands_first_as_a_sentence_of_its_own():
    assert careful([]) == ""
    assert careful(["v: is it of the same rig?", "more"]) == "Careful: v: is it of the same rig? "
    assert careful(["a note"]) == "Careful: a note. "


def test_a_gap_that_parameters_close_is_not_the_size_of_what_acts():
    report = {**_unknown(("motor", 1.0)), "hypotheses": [{"effects": [], "probability": 0.1, "gap_after": 0.97}]}
    said = sentence(report, EFFECTS)
    assert said.startswith("Something acts at motor (mechanical) that no listed effect explains: ")
    assert "lie 2.8 times the floor off, and 1.0 times with the rig's parameters fitted anew." in said
    report["hypotheses"][0]["gap_after"] = 2.7
    assert sentence(report, EFFECTS).startswith("There is a gap of 2.8 times the floor at motor")


@pytest.mark.parametrize(("gap", "set_", "begins", "holds"), [
    ({"verdict": "ambiguous"}, ["load.mass"], "Free runs of data not used for that go astray, and these cannot be told apart surely: ", ""),
    ({"verdict": "explained"}, ["load.mass"], "The gap is explained by load.mass",
     "free runs of data not used to find it lie 1.1 times the floor off with it and go astray without it (probability 60 %"),
    ({"verdict": "unknown"}, [], "Something acts at motor (mechanical) that no listed effect explains: ",
     "data not used to find it go astray, and lie 1.1 times the floor off with the rig's parameters fitted anew."),
    ({"verdict": "unknown"}, ["load.mass"], "Free runs of data not used to find it go astray, and something acts at ", ""),
    ({"verdict": "no_gap"}, [], "Probably no gap: ", " Unfitted the twin went astray, fitted to the commissioning recording alone it "),
])  # fmt: skip
def test_runs_that_go_astray_are_no_number(gap, set_, begins, holds):
    report = {**_unknown(("motor", 1.0)), "gap": {"as_is": math.inf, "before": math.inf, "after": 1.1}, "why": [], "classes": [],
              "shrink": SHRINK, "hypotheses": [{"effects": set_, "probability": 0.6, "gap_after": 1.1}], **gap}
    said = sentence(report, EFFECTS)
    assert said.startswith(begins) and holds in said and "inf" not in said and "nan" not in said
