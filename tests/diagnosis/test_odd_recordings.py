"""Recordings in which much is missing: a report that says what cannot be known, or a refusal."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.experiment import ExperimentError
from ddh_twin_py.gap.diagnose import Recordings, diagnose
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Stream
from support.drifted import recorded

pytestmark = pytest.mark.long

OFFSET = "sensor.pressure_rod_side_offset"
ASKED = (OFFSET, "pump_1.leakage", "motor.cooling", "load.mass")
"""Few effects, so that the search is short."""


def put(stream, **values):
    """The stream with whole columns replaced, by a value or a function of the old ones."""
    changed = stream.values.copy()
    for name, value in values.items():
        column = changed[:, stream.fields.index(name)]
        column[:] = value(column) if callable(value) else value
    return Stream(stream.time, changed, stream.fields)


@pytest.fixture(scope="module")
def new():
    return recorded(60.0)


@pytest.fixture(scope="module")
def drifted():
    return recorded(100.0, OFFSET, 2e5)


def answer(field, commissioning=None, validation=None):
    report = diagnose(Recordings([field], commissioning, validation), load_rig(), only=ASKED).report
    json.dumps(report, allow_nan=False)
    return report, " ".join(report["notes"])


def test_three_temperature_sensors_are_enough_for_a_pressure(new, drifted):
    few = replace(drifted, temperatures={name: drifted.temperatures[name] for name in ("ambient", "motor_housing", "tank_oil")})
    report, _ = answer(few, new)
    assert report["why"][0]["effect"] == OFFSET and report["why"][0]["probability"] > 0.9
    assert {n for n in report["shrink"] if n.startswith("temperature/")} == {"temperature/motor_housing", "temperature/tank_oil"}


def test_no_temperature_but_ambient_says_what_cannot_be_known(new, drifted):
    report, notes = answer(replace(drifted, temperatures={"ambient": drifted.temperatures["ambient"]}), new)
    assert "thermal effects cannot be known" in notes and report["verdict"] in ("explained", "ambiguous")


def test_pressures_that_are_nan_are_not_seen_and_said(new, drifted):
    blind = replace(drifted, hydraulic=put(drifted.hydraulic, pressure_piston_side=math.nan, pressure_rod_side=math.nan))
    report, notes = answer(blind, new)
    assert "pressure_rod_side" not in report["shrink"] and report["verdict"] != "explained"
    assert "there is no usable pressure_piston_side, pressure_rod_side; what shows in these alone cannot be known" in notes


def test_without_commissioning_the_sheet_is_what_the_rig_is_held_against():
    """A zero error of two tolerances of the transducer (0.6 bar) is the rig's parameter; one of ten is an effect."""
    report, notes = answer(recorded(150.0, OFFSET, 1.2e5))
    assert "there is no commissioning recording" in notes and report["gap"]["before"] < 1.2
    assert next((row["probability"] for row in report["why"] if row["effect"] == OFFSET), 0.0) < 0.2
    report, _ = answer(recorded(150.0, OFFSET, 6e5))
    assert report["verdict"] == "explained" and report["why"][0]["effect"] == OFFSET and report["gap"]["closed_fraction"] > 0.5


@pytest.mark.parametrize("odd, words", [
    (lambda r: replace(r, drive=put(r.drive, speed_command=np.nan)), "speed_command has no usable value"),
    (lambda r: replace(r, hydraulic=put(r.hydraulic, rod_position=np.nan)), "rod_position has no usable value"),
    (lambda r: replace(r, temperatures={}), "temperature/ambient: there is no usable value"),
    (lambda r: r.between(0.0, 4.0), "at least 10 s"),
])
def test_what_no_free_run_can_be_made_of(odd, words, new, drifted):
    """In the field it is a report without an answer; a recording that was to help and cannot is refused."""
    report, notes = answer(odd(drifted), new)
    assert report["verdict"] == "insufficient" and words in notes and report["gap"]["before"] is None
    for role in ("commissioning", "validation"):
        with pytest.raises(ExperimentError) as refused:
            answer(drifted, **{"commissioning": new, role: odd(new)})
        assert words in str(refused.value) and f"leave this {role} recording out" in str(refused.value) and "\n" not in str(refused.value)


def test_neither_pressure_nor_current(new, drifted):
    blind = replace(drifted, drive=put(drifted.drive, current=np.nan, torque=np.nan),
                    hydraulic=put(drifted.hydraulic, pressure_piston_side=np.nan, pressure_rod_side=np.nan))
    report, notes = answer(blind, new)
    assert report["verdict"] == "insufficient" and "neither pressure nor current" in notes


def test_a_field_recording_too_short_to_hold_a_part_out(new, drifted):
    report, notes = answer(drifted.between(0.0, 30.0), new)
    assert report["verdict"] == "insufficient" and ("too short" in notes or "at least 10 s" in notes)
    none, = report["hypotheses"]  # always listed: nothing speaks for or against it
    assert none["effects"] == [] and 0.0 < none["probability"] < 1.0 and none["gap_after"] is None


def test_an_effect_that_no_signal_shows_is_said_to_be_out_of_sight(new, drifted):
    without = [replace(r, hydraulic=put(r.hydraulic, pressure_rod_side=math.nan)) for r in (drifted, new)]
    report = diagnose(Recordings(without[:1], without[1]), load_rig(), only=("sensor.pressure_rod_side_gain", "load.mass")).report
    assert "no signal of these recordings would show it: sensor.pressure_rod_side_gain" in " ".join(report["notes"])


@pytest.mark.parametrize("odd, words", [
    (lambda r: replace(r, drive=put(r.drive, speed=lambda v: v * 9.5493, speed_command=lambda v: v * 9.5493)), "look as if given in rpm"),
    (lambda r: replace(r, hydraulic=put(r.hydraulic, rod_position=0.3, rod_velocity=0.0)), "rod_position is stuck"),
    (lambda r: replace(r, drive=put(r.drive, current=3.0, torque=3.0),
                       hydraulic=put(r.hydraulic, pressure_piston_side=1e6, pressure_rod_side=1e6)), "neither pressure nor current"),
    (lambda r: replace(r, temperatures={name: Stream(s.time, s.values + [273.15, 0.0], s.fields) for name, s in r.temperatures.items()}),
     "looks as if given in K"),
])
def test_what_screening_set_aside_is_the_reason(odd, words, new, drifted):
    """A wrong unit or a stuck sensor is named, not only that a value is missing."""
    report, notes = answer(odd(drifted), new)
    assert report["verdict"] == "insufficient" and words in notes


def test_pressures_in_bar_are_said_beside_the_answer(new, drifted):
    in_bar = {name: lambda v: v * 1e-5 for name in ("pressure_piston_side", "pressure_rod_side")}
    wrong = replace(drifted, hydraulic=put(drifted.hydraulic, **in_bar))
    report, notes = answer(wrong, new)
    assert "look as if given in bar" in notes and "there is no usable pressure_piston_side, pressure_rod_side;" in notes
    assert "pressure_rod_side" not in report["shrink"]


@pytest.mark.parametrize("seconds, words", [(7200.0, "jump 1 time, first by +7"), (-40.0, "jump 1 time, first by -")])
def test_where_the_stamps_jump_is_told(seconds, words, new, drifted):
    def moved(stream):
        return Stream(np.where(stream.time > 70.0, stream.time + seconds, stream.time), stream.values, stream.fields)

    odd = replace(drifted, drive=moved(drifted.drive), hydraulic=moved(drifted.hydraulic),
                  temperatures={name: moved(stream) for name, stream in drifted.temperatures.items()})
    with pytest.raises(ExperimentError, match="the stamps") as refused:
        answer(odd, new)
    assert words in str(refused.value) and drifted.path in str(refused.value)
