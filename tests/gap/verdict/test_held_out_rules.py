"""Something outside the catalogue is believed where held-out data show it too."""

import math

import pytest
from ddh_twin_py.gap.drive.direct_drive import WITNESSES
from ddh_twin_py.gap.locate.leftover import FreeForm
from ddh_twin_py.gap.verdict.held_out_rules import (
    FAR_PROBABILITY,
    REFUTED,
    REFUTED_AS_RUN,
    bent,
    borne_out,
    displaced,
    drifted,
    far_off,
    halfway,
    left_behind,
    off_its_noise,
    refuted,
    resized,
    strained,
    worsened,
)
from ddh_twin_py.gap.verdict.unknown import Unknown

HOUSING, WINDING = "temperature/motor_housing", "temperature/motor_winding"


def unknown(*gains):
    forms = [FreeForm(signal, gain, 3.0, ["time"], "all") for signal, gain in gains]
    return Unknown(0.98, forms, 0.5, "K", [])


def heard(seen, left, closed=0.9, effects=1, built=True, best=None, in_field=None):
    """By default the field recording shows by itself what its free forms speak of."""
    def needed(signal):
        return WITNESSES.needed_of(signal, effects, built)

    return borne_out(seen, WITNESSES, needed, left, best or left, closed, effects, built, in_field or dict.fromkeys(left, 2.0))


def test_what_held_out_data_show_too_stays():
    seen = heard(unknown((HOUSING, 60.0)), {HOUSING: 1.4})
    assert seen.probability == 0.98 and not seen.notes


@pytest.mark.parametrize(("closed", "effects", "verdict"), [
    (0.9, 1, "listed"), (0.9, 2, "neither"), (0.3, 1, "neither"), (None, 1, "neither"),
])  # fmt: skip
def test_what_they_do_not_show_is_no_sure_unknown(closed, effects, verdict):
    weak = heard(unknown((HOUSING, 60.0), (WINDING, 40.0)), {HOUSING: 1.1, WINDING: 2.0}, closed, effects)  # the winding needs more
    assert weak.probability < 0.3 if verdict == "listed" else 0.3 < weak.probability < 0.5
    assert HOUSING in weak.notes[0] and WINDING not in weak.notes[0]


@pytest.mark.parametrize(("left", "believed"), [(1.9, False), (3.2, True)])
def test_the_winding_alone_must_be_far_off(left, believed):
    seen = heard(unknown((WINDING, 300.0)), {WINDING: left, HOUSING: 1.0}, None, 0)
    assert seen.probability == (0.98 if believed else pytest.approx(0.4))


@pytest.mark.parametrize(("others", "built", "believed"), [((), False, False), ((), True, True), (((HOUSING, 60.0),), False, True)])
def test_the_winding_alone_proves_nothing_where_nothing_showed_the_laws(others, built, believed):
    seen = heard(unknown((WINDING, 300.0), *others), {WINDING: 3.8, HOUSING: 1.9}, None, 0, built)
    assert seen.probability == (0.98 if believed else 0.1)
    assert ("no commissioning recording" in "".join(seen.notes)) is not believed


@pytest.mark.parametrize(("best", "closed", "effects", "built", "listed"), [
    (1.4, 0.98, 1, True, True),
    (2.5, 0.98, 1, True, False),  # also at best they are off
    (1.4, 0.9, 1, True, False),  # much is left of the gap
    (1.4, 0.98, 2, True, False),  # any two close much
    (1.4, 0.98, 1, False, False),  # nothing showed the laws
])  # fmt: skip
def test_a_cause_that_closes_nearly_all_needs_no_free_form(best, closed, effects, built, listed):
    far = unknown(("rod_position", 90.0), (HOUSING, 5.0))
    as_run, at_best = {"rod_position": 4.6, HOUSING: 1.0}, {"rod_position": best, HOUSING: 1.0}
    after = heard(far, as_run, closed, effects, built, at_best)
    assert after.probability == (0.25 if listed else 0.98)
    assert ("98 % of the gap" in "".join(after.notes)) is listed


def test_a_signal_that_held_out_data_lack_tells_nothing_against_it():
    assert heard(unknown((HOUSING, 60.0)), {WINDING: 1.0}).probability == 0.98


@pytest.mark.parametrize(("signal", "in_field", "built", "silent"), [
    (HOUSING, 1.05, True, True), (HOUSING, 1.6, True, False),
    (HOUSING, 1.05, False, False),  # nothing showed that floor
    ("rod_position", 1.05, True, False),  # small flaws of laws move it
])  # fmt: skip
def test_what_free_forms_alone_find_held_out_data_say_nothing_about(signal, in_field, built, silent):
    after = heard(unknown((signal, 60.0)), {signal: 1.05}, None, built=built, in_field={signal: in_field})
    assert after.probability == (0.98 if silent else 0.4)


@pytest.mark.parametrize(("left", "closed", "sure"), [(1.5, 0.58, False), (1.1, 0.58, True), (1.5, 0.9, True), (0.9, None, True)])
def test_two_effects_that_leave_much_of_the_gap_are_not_sure_to_be_all(left, closed, sure):
    nothing = Unknown(0.01, [], 0.0, "1")
    after = halfway(nothing, left, closed)
    assert (after is nothing) if sure else (after.probability == pytest.approx(0.4) and "close 58 % of the gap" in after.notes[0])


def test_two_effects_that_widen_the_gap_close_nothing_of_it():
    assert "close nothing of the gap" in halfway(Unknown(0.01, [], 0.0, "1"), 1.5, -0.62).notes[0]


def test_a_signal_in_which_runs_go_astray_has_no_size_that_is_left_behind():
    nothing, floor = Unknown(0.01, [], 0.0, "1"), {"current": (0.1, "A"), "speed": (1.0, "rad/s")}
    left, before = {"current": math.inf, "speed": 4.0}, {"current": math.inf, "speed": 9.0}
    after = left_behind(nothing, left, before, floor, True, left)
    assert after.probability > 0.95 and math.isfinite(after.size) and after.unit == "rad/s"


@pytest.mark.parametrize(("left", "before", "built", "least", "most"), [
    (1.2, 5.0, True, 0.0, 0.02), (2.3, 5.0, True, 0.05, 0.3), (3.4, 5.0, True, 0.95, 1.0),
    (3.0, 3.0, True, 0.0, 0.02),  # brought no nearer: a law may not hold in a duty that nothing showed
    (3.0, 9.0, False, 0.0, 0.02), (6.0, 9.0, False, 0.95, 1.0),
])  # fmt: skip
def test_what_the_best_hypothesis_leaves_behind_on_held_out_data_is_unknown(left, before, built, least, most):
    nothing = Unknown(0.01, [], 0.0, "1")
    floor = {"pressure_rod_side": (2.0e4, "Pa"), "current": (0.1, "A")}
    after = left_behind(nothing, {"current": 1.0, "pressure_rod_side": left}, {"current": 1.0, "pressure_rod_side": before}, floor, built)
    assert least <= after.probability <= most
    if least > 0.9 and left == 3.4:
        assert (after.size, after.unit) == (pytest.approx(2.0e4 * (3.4**2 - 1.0) ** 0.5), "Pa")
        assert "pressure_rod_side of the held-out data is 3.4 times its floor" in after.notes[0]


def test_what_neither_field_nor_held_out_data_show_explained_is_unknown():
    nothing = Unknown(0.01, [], 0.0, "1")
    left, before, floor = {"speed": 4.2}, {"speed": 4.9}, {"speed": (0.1, "rad/s")}
    assert left_behind(nothing, left, before, floor, True, {"speed": 1.1}).probability < 0.02
    assert left_behind(nothing, left, before, floor, True, {"speed": 4.0}).probability > 0.95
    far = {"speed": 9.0}
    assert left_behind(nothing, far, far, floor, True, far).probability > 0.95
    assert left_behind(nothing, far, far, floor, False, far) is nothing  # it may be a flaw of the laws in the field, too


@pytest.mark.parametrize(("in_field", "believed"), [(6.4, True), (3.0, False)])
def test_what_a_field_recording_leaves_without_structure_is_no_sign_in_held_out_data(in_field, believed):
    """A rod that sticks and comes free at other moments than the model's."""
    nothing, floor = Unknown(0.01, [], 0.0, "1"), {"speed": (0.1, "rad/s")}
    after = left_behind(nothing, {"speed": 6.6}, {"speed": 20.0}, floor, False, {"speed": in_field})
    assert (after is nothing) if believed else after.probability > 0.95
    assert left_behind(nothing, {"speed": 6.6}, {"speed": 20.0}, floor, True, {"speed": in_field}).probability > 0.95


def test_a_rig_whose_laws_follow_no_signal_to_the_floor_leaves_nothing_behind():
    nothing = Unknown(0.01, [], 0.0, "1")
    assert left_behind(nothing, {}, {}, {}) is nothing


def test_two_effects_are_not_blamed_for_a_start_that_nothing_tells():
    nothing = Unknown(0.01, [], 0.0, "1")
    assert halfway(nothing, 10.2, 0.07, slow=13.4) is nothing
    assert halfway(nothing, 10.2, 0.07, slow=2.0).probability == pytest.approx(0.4)


@pytest.mark.parametrize(("without", "left", "least"), [(2.0, 1.5, 0.01), (1.0, 1.04, 0.01), (1.15, 1.28, 0.7), (10.1, 10.3, 0.01)])
def test_what_makes_held_out_data_worse_is_not_believed(without, left, least):
    after = refuted(Unknown(0.01, [], 0.0, "1"), WITNESSES, [({"current": without}, {"current": left}, REFUTED)])
    assert after.probability == least and bool(after.notes) is (least > 0.1)


@pytest.mark.parametrize(("without", "left", "least"), [(1.03, 1.06, 0.01), (1.10, 1.12, 0.01), (1.51, 1.89, 0.7), (0.5, 0.64, 0.01)])
def test_as_run_a_right_cause_may_spoil_held_out_data_a_little(without, left, least):
    assert refuted(Unknown(0.01, [], 0.0, "1"), WITNESSES, [({"speed": without}, {"speed": left}, REFUTED_AS_RUN)]).probability == least


def test_a_cause_that_is_refuted_in_two_ways_is_so_once_by_the_worse():
    ways = [({"speed": 1.15}, {"speed": 1.28}, REFUTED), ({"speed": 1.51}, {"speed": 1.89}, REFUTED_AS_RUN)]
    after = refuted(Unknown(0.01, [], 0.0, "1"), WITNESSES, ways)
    assert after.probability == 0.7 and len(after.notes) == 1 and "worse by 0.38 times" in after.notes[0]


@pytest.mark.parametrize(("without", "left", "worse"), [
    ({"rod_position": 10.0, "current": 1.0, WINDING: 1.0}, {"rod_position": 18.0, "current": 1.0, WINDING: 1.5}, False),
    ({"rod_position": 10.0, "current": 1.0, WINDING: 1.0}, {"rod_position": 18.0, "current": 1.2, WINDING: 1.0}, True),
    ({"rod_position": 1.0, "current": 1.0, WINDING: 8.0}, {"rod_position": 1.0, "current": 1.2, WINDING: 1.0}, False),  # the whole shrinks
    ({"rod_position": 1.0}, {"rod_position": 3.0}, True),  # nothing else is measured
])
def test_what_sums_up_small_flaws_refutes_no_cause_by_itself(without, left, worse):
    after = refuted(Unknown(0.01, [], 0.0, "1"), WITNESSES, [(without, left, REFUTED)])
    assert (after.probability == 0.7) is worse and (after.checks[-1].measured >= after.checks[-1].limit) is worse


@pytest.mark.parametrize("left, closed, effects, sure", [
    ({"current": 10.0, "pressure_rod_side": 78.0, "speed": 1.0}, 0.09, 1, True),  # a cause that hardly closes anything
    ({"current": 10.0, "pressure_rod_side": 78.0, "speed": 1.0}, None, 0, True),  # the field recording shows no effect, these data do
    ({"current": 10.0, "pressure_rod_side": 78.0, "speed": 1.0}, 0.95, 1, False),  # most of a very large gap is closed
    ({"current": 1.0, "pressure_rod_side": 78.0, "speed": 1.0}, 0.09, 1, False),  # one signal, which a law may misjudge
    ({}, None, 1, False),
])
def test_where_most_signals_of_held_out_data_are_far_off_something_is_unknown(left, closed, effects, sure):
    nothing = Unknown(0.01, [], 0.0, "1")
    after = far_off(nothing, left, closed, effects)
    assert (after.probability > nothing.probability) is sure
    if sure:
        assert after.probability == FAR_PROBABILITY and "half of the signals" in after.notes[-1]


@pytest.mark.parametrize("before, left, away", [
    (1.1, 2.35, True), (7.0, 7.3, False), (2.2, 2.5, False), (1.0, 1.3, False), (3.0, 6.7, True),
])
def test_a_cause_that_moves_a_signal_away_is_not_believed(before, left, away):
    nothing = Unknown(0.01, [], 0.0, "1")
    after = worsened(nothing, WITNESSES, {"temperature/line_b": left, "current": 1.0}, {"temperature/line_b": before, "current": 5.0})
    assert (after.probability > 0.7 and "temperature/line_b" in after.notes[0]) if away else after.probability < 0.1


def test_strokes_and_winding_may_be_moved_away():
    nothing = Unknown(0.01, [], 0.0, "1")
    assert worsened(nothing, WITNESSES, {"rod_position": 9.0, WINDING: 9.0}, {"rod_position": 1.0, WINDING: 1.0}) is nothing


@pytest.mark.parametrize(("as_built", "least", "most"), [
    ({"current": 1.02, "pressure_rod_side": 1.0}, 0.0, 0.02), ({"current": 1.04}, 0.0, 0.1), ({"current": 1.12}, 0.45, 0.55),
    ({"current": 1.02, "pressure_rod_side": 1.3}, 0.97, 1.0),
    ({"rod_position": 3.0, WINDING: 3.0, "temperature/line_b": 1.3}, 0.0, 0.02),  # they sum up
    ({}, 0.0, 0.02),
])
def test_a_cause_that_asks_for_another_rig_than_was_built_is_not_the_cause(as_built, least, most):
    after = strained(Unknown(0.01, [], 0.0, "1"), WITNESSES.prompt(as_built))
    assert least <= after.probability <= most and bool(after.notes) is (most > 0.5)


@pytest.mark.parametrize(("off", "least", "most"), [
    ({}, 0.0, 0.02), ({"speed": 1.0, "rod_velocity": 1.15}, 0.0, 0.03), ({"speed": 1.0, "rod_velocity": 1.4}, 0.95, 1.0),
])
def test_a_signal_that_was_at_its_noise_as_built_and_is_not_since_is_not_explained(off, least, most):
    forms = [FreeForm(name, gain, 1.0, [], "all") for name, gain in ((WINDING, 99.0), ("rod_velocity", 3.0))]
    after = off_its_noise(Unknown(0.01, forms, 0.0, "1"), off)
    assert least <= after.probability <= most
    assert after.off == (after.forms[0].signal if least > 0.5 else "") and bool(after.notes) is (least > 0.5)


@pytest.mark.parametrize(("drift", "effects", "least", "most"), [
    (3.0, 0, 0.0, 0.06), (6.9, 0, 0.7, 0.8), (6.7, 1, 0.0, 0.15), (10.6, 1, 0.75, 0.8), (-3.0, 2, 0.0, 0.02),
])
def test_what_fits_only_with_another_rig_than_was_commissioned_is_doubted(drift, effects, least, most):
    after = drifted(Unknown(0.01, [], 0.0, "1"), drift, effects, 1.4, 1.3)
    assert least <= after.probability <= most and bool(after.notes) is (least > 0.5)


def test_a_rig_whose_further_data_are_as_commissioned_has_not_drifted_wherever_a_fit_went():
    nothing = Unknown(0.01, [], 0.0, "1")
    assert drifted(nothing, 10.2, 0, 1.02, 1.02) is nothing
    assert drifted(nothing, 10.2, 1, 1.02, 1.3).probability > 0.7, "that a cause acts is doubted all the same"


def test_a_cause_with_whose_rig_held_out_data_are_at_the_floor_is_not_doubted_by_that_rig():
    nothing = Unknown(0.01, [], 0.0, "1")
    assert drifted(nothing, 16.8, 1, 7.8, 1.0) is nothing
    assert drifted(nothing, 16.8, 2, 4.9, 1.32).probability > 0.75
    assert drifted(nothing, 16.8, 0, 2.0, 1.0).probability > 0.75, "parameters that take up a gap confirm nothing"


@pytest.mark.parametrize(("beyond", "least", "most"), [(-1.5, 0.0, 0.02), (0.1, 0.0, 0.02), (4.9, 0.9, 1.0)])
def test_a_cause_beside_which_another_duty_asks_for_another_rig_is_doubted(beyond, least, most):
    after = displaced(Unknown(0.01, [], 0.0, "1"), beyond)
    assert least <= after.probability <= most and bool(after.notes) is (least > 0.5)


@pytest.mark.parametrize("gained, explained, least, most", [
    (3.0, 20.0, 0.0, 0.02), (20.0, 1000.0, 0.0, 0.02), (100.0, 600.0, 0.99, 1.0),
    (100.0, 9000.0, 0.0, 0.02),  # a little of very much
])
def test_a_cause_whose_law_must_bend_is_not_the_cause(gained, explained, least, most):
    after = bent(Unknown(0.01, [], 0.0, "1"), gained, explained)
    assert least <= after.probability <= most and bool(after.notes) is (least > 0.5)


def test_two_laws_that_are_free_may_gain_more_than_one():
    one, two = (bent(Unknown(0.01, [], 0.0, "1"), 41.0, 100.0, effects).probability for effects in (1, 2))
    assert one > 0.8 and two < 0.2 and bent(Unknown(0.01, [], 0.0, "1"), 71.0, 100.0, 2).probability > 0.95


@pytest.mark.parametrize(("gained", "least", "most"), [(0.6, 0.0, 0.02), (3.0, 0.0, 0.05), (12.0, 0.95, 1.0)])
def test_a_pair_of_which_held_out_data_ask_for_another_size_is_doubted(gained, least, most):
    spread = {"pump_1.friction": 0.2, "motor.pwm_loss": 0.2}
    seen = resized(Unknown(0.01, [], 0.0, "1"), gained, {"pump_1.friction": 0.69, "motor.pwm_loss": 1.17}, spread, True)
    assert least <= seen.probability <= most
    assert any("pump_1.friction 0.69 times as large and motor.pwm_loss 1.17" in note for note in seen.notes) == (least > 0.5)


def test_one_cause_whose_size_another_duty_shifts_a_little_is_believed():
    nothing = Unknown(0.01, [], 0.0, "1")
    assert resized(nothing, 18.0, {"ambient.enclosure": 0.67}, {"ambient.enclosure": 0.2}, False).probability < 0.02
    assert resized(nothing, 240.0, {"sensor.rod_position_scale": 0.6}, {"sensor.rod_position_scale": 0.0}, False).probability > 0.99


def test_a_size_within_a_deviation_of_that_found_tells_nothing():
    nothing, spread = Unknown(0.01, [], 0.0, "1"), {"drive.torque_estimate": 0.2, "ambient.solar_load": 0.21}
    assert resized(nothing, 9.9, {"drive.torque_estimate": 1.001, "ambient.solar_load": 0.81}, spread, True) is nothing
    assert resized(nothing, 9.9, {"drive.torque_estimate": 1.001, "ambient.solar_load": 0.7}, spread, True).probability > 0.9
    assert resized(nothing, 9.9, {"drive.torque_estimate": 0.7, "ambient.solar_load": 0.81}, spread, True).probability > 0.9
