"""What is doubtful about recordings reaches the notes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from ddh_twin_py.estimation.fitting.unpredictable import COMMANDS_LOST, SLIPS, SUNK
from ddh_twin_py.gap.recordings.doubts import at_the_stops, damage, doubts, left_out, of_reference, pauses, undeclared
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Finding, Recording, RigInfo, drive_stream, hydraulic_stream


def finding(severity, message, field=""):
    return Finding(severity, "bag", "topic", field, None, 1, message)


def recording(*findings):
    return replace(Recording("bag", 0, None, None, None, {}), findings=tuple(findings))


def test_errors_are_told_by_themselves_and_what_is_no_warning_is_left_out():
    given = recording(finding("warning", "out of order"), finding("info", "oil not told"), finding("warning", "NaN", "speed"),
                      finding("error", "in bar", "pressure"))
    assert doubts([given]) == ["NaN", "out of order"] and damage([given]) == ["in bar"]


def test_many_warnings_are_counted():
    notes = doubts([recording(*(finding("warning", f"warning {i}") for i in range(9))), recording()])
    assert len(notes) == 7 and notes[-1] == "bag: 3 further warnings; ddh-twin info lists them"


def test_single_samples_that_are_missing_are_one_note():
    stream = drive_stream(np.arange(5000.0), np.zeros((5000, 6)))
    missing = [Finding("warning", "bag", "/ddh/drive/telemetry", field, float("nan"), count, f"{field} is NaN {count} times", mended=True)
               for field, count in (("speed", 3), ("torque", 5), ("current", 900))]
    given = replace(recording(*missing), drive=stream, namespace="/ddh")
    jump = Finding("warning", "bag", "/ddh/drive/telemetry", "", -2.0, 1, "the clock jumped")  # strikes one sample and spoils the rest
    assert doubts([replace(given, findings=(*given.findings, jump))])[1] == "the clock jumped"
    assert doubts([given]) == [
        "current is NaN 900 times",
        "bag: 2 slight warnings, of samples that are missing, late or repeated, at most 5 of 5000 of a topic; ddh-twin info lists them",
    ]


def test_a_payload_that_nobody_declared_is_said_to_be_assumed():
    declared, not_a_number = (replace(recording(), rig=RigInfo("rig_1", "", payload)) for payload in (120.0, float("nan")))
    assert undeclared([declared], 149.5, True) == []
    said = "bag: no usable payload is declared, so that the rig file's 149.5 kg was assumed"
    assert undeclared([declared, not_a_number], 149.5, False) == [said], "another recording's load is assumed"
    assert undeclared([recording()], 149.5, True) and not undeclared([recording()], 149.5, False)


def test_a_rig_that_a_recording_names_is_asked_about_where_it_was_held_against_the_reference_s_sheet():
    named, sheet = replace(recording(), rig=RigInfo("press_7", "", 100.0)), load_rig()
    (said,) = of_reference([recording(), named], sheet)
    assert "name press_7" in said and "--rig" in said
    assert of_reference([named], replace(sheet, rig_id="press_7")) == of_reference([recording()], sheet) == []


def moving(seconds, command, position, velocity):
    """A recording of 50 Hz in which these are constant."""
    time = np.arange(0.0, seconds, 0.02)
    return replace(recording(), drive=drive_stream(time, np.tile([command, *5 * [0.0]], (time.size, 1))),
                   hydraulic=hydraulic_stream(time, np.tile([1e6, 1e6, position, velocity], (time.size, 1))))


def cut_out(one, begin, end):
    """The same without anything between."""
    def kept(stream):
        apart = (stream.time <= begin) | (stream.time >= end)
        return replace(stream, time=stream.time[apart], values=stream.values[apart])

    return replace(one, drive=kept(one.drive), hydraulic=kept(one.hydraulic))


def test_a_pause_of_the_recorder_is_told_with_its_begin_and_end():
    whole = moving(120.0, 50.0, 0.2, 0.05)
    (said,) = pauses([whole, cut_out(whole, 30.0, 70.0)])
    assert said.startswith("bag: nothing was recorded from 30 s to 70 s; ")
    assert ", and 1 times more" in pauses([cut_out(cut_out(whole, 30.0, 50.0), 80.0, 100.0)])[0]
    assert pauses([whole, cut_out(whole, 30.0, 35.0), recording()]) == []


def test_a_rod_that_is_pressed_against_a_stop_is_told_and_one_that_rests_there_is_not():
    stroke = load_rig()["cylinder.stroke"]
    (said,) = at_the_stops([moving(30.0, 60.0, stroke - 1e-3, 0.0)], load_rig())
    assert "against an end stop for 30 s" in said
    assert at_the_stops([moving(30.0, -60.0, 0.0, 0.0)], load_rig())
    for command, position, velocity in ((0.0, 0.0, 0.0), (60.0, 0.0, 0.0), (60.0, 0.5 * stroke, 0.0), (60.0, stroke, 0.05)):
        assert at_the_stops([moving(30.0, command, position, velocity), recording()], load_rig()) == []


def test_what_strikes_most_samples_of_a_topic_is_told_first():
    one = replace(moving(100.0, 0.0, 0.2, 0.0), namespace="/ddh")
    often, seldom = (replace(finding("warning", said), topic="/ddh/drive/telemetry", count=count)
                     for said, count in (("repeats a stamp", 4000), ("late", 40)))
    assert damage([replace(one, findings=(often, seldom))]) == ["repeats a stamp"]


def test_what_is_not_compared_is_told_with_its_reason():
    experiments = [SimpleNamespace(recording=SimpleNamespace(path="field"), duration=600.0,
                                   left_out={COMMANDS_LOST: 41.2, SLIPS: 120.0, SUNK: 0.05})]
    end = "; no run predicts that to the second"
    assert left_out(experiments) == [
        f"field: what is fast is not compared for 41 s of 600 s, in which commands of the drive were lost{end}",
        f"field: rod_velocity is not compared for 120 s of 600 s, in which the rod sticks and slips{end}"]
