"""What an answer says beside its verdict."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.calibration import FittedParameter
from ddh_twin_py.gap import answer
from ddh_twin_py.gap.answer import _shrink
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.report_notes import at_the_end, not_held, pressed_ones
from ddh_twin_py.gap.verdict.hearing import spread_elsewhere, spread_of_unsteady
from ddh_twin_py.real_rigs.diagnose import diagnose
from ddh_twin_py.rig.sheet import CUT
from support.heated_block import DESCRIPTION, block


def test_a_parameter_pressed_against_its_tolerance_is_named():
    free, high, low = (FittedParameter(name, "bar", 10.0, 2.0, value, 0.1, True) for name, value in
                       (("oil.a", 14.8), ("oil.b", 15.0), ("oil.c", 5.0)))
    assert pressed_ones([free, high, low]) == ["oil.b (15.00 instead of 10.00 bar)", "oil.c (5.000 instead of 10.00 bar)"]
    assert pressed_ones([replace(high, cut=math.inf)]) == [], "nothing holds it"
    assert pressed_ones([replace(high, informed=False)]) == [], "nothing was learnt of it"
    assert pressed_ones([replace(high, unit="1")]) == ["oil.b (15.00 instead of 10.00)"]
    offset = FittedParameter("measurement.pressure_rod_side_offset", "Pa", -1.202e5, 8160.0, -9.984e4, 100.0, True)
    assert pressed_ones([replace(offset, prior_std=8144.0)])[0].endswith("_offset (−0.9984 instead of −1.202 bar)")
    assert at_the_end([], False, CUT) == []
    assert at_the_end(["a", "b"], False, CUT)[0].startswith("a, b are fitted 2.5 times the tolerance off")
    assert at_the_end(["c"], False, CUT)[0].startswith("c is fitted 2.5 times the tolerance off, the very end of what a fit may use")
    assert at_the_end(["c"], True, CUT)[0].startswith("in the fit that comes nearest, which no rig file is written from, c is fitted")
    (note,) = at_the_end(["c"] * 6, False, CUT)
    assert note.startswith("c, c, c, c and 2 further parameters are fitted")


def test_sizes_in_another_duty_err_by_fit_and_law_and_heat_into_an_unknown_body_is_another_in_each():
    names = ("motor.pwm_loss", "sensor.rod_position_scale", "tank.mount_conduction")
    fitted = SimpleNamespace(columns=[SimpleNamespace(effect=EFFECTS[name]) for name in names], x=np.array([10.0, 0.02, 4.0]),
                             covariance=np.diag([9.0, 1.0e-6, 1.0]))
    assert spread_elsewhere(fitted) == pytest.approx([np.hypot(3.0, 2.0), 1.0e-3, 0.0])
    assert spread_of_unsteady(fitted) == pytest.approx([0.0, 0.0, 2.0])


def test_what_held_out_data_lack_is_said():
    model = SimpleNamespace(signals=[{"current": 0, "voltage": 0}, {"current": 0, "tank": 0, "rod": 0}], altered=[False, True])
    assert not_held(model, {"current": 1.0}) == ["held-out data have no usable tank, rod: how near the twin comes to that is not known"]
    assert not_held(model, {"current": 1.0, "tank": 1.0, "rod": 1.0}) == []


def test_a_signal_in_which_a_run_goes_astray_has_no_size_but_a_note():
    signal = SimpleNamespace(unit="A", noise=0.5)
    held = SimpleNamespace(signals=lambda: [{"current": signal, "speed": signal}])
    runs = SimpleNamespace(held=held, floor={"current": 1.2, "speed": 1.0}, ratios=lambda leader: {"current": 2.0, "speed": math.inf},
                           interval=lambda name, runs: None, of=lambda leader: [])
    rows, notes = _shrink(SimpleNamespace(runs=runs, off={"current": 4.0, "speed": 3.0}, run=[]), None)
    assert list(rows) == ["current"] and (rows["current"]["before"], rows["current"]["after"], rows["current"]["noise"]) == (2.0, 1.0, 0.6)
    assert notes == ["free runs of held-out data go astray in speed"]


def test_a_signal_that_only_a_later_recording_reads_has_its_size():
    amps, volts = SimpleNamespace(unit="A", noise=0.5), SimpleNamespace(unit="V", noise=2.0)
    held = SimpleNamespace(signals=lambda: [{"current": amps}, {"current": SimpleNamespace(unit="A", noise=0.7), "voltage": volts}])
    ratios = {"current": 2.0, "voltage": 30.0}
    runs = SimpleNamespace(held=held, floor=dict.fromkeys(ratios, 1.0), ratios=lambda leader: ratios, interval=lambda *given: None,
                           of=lambda leader: [])
    rows, _ = _shrink(SimpleNamespace(runs=runs, off=ratios, run=[]), None)
    assert {name: (row["unit"], row["after"]) for name, row in rows.items()} == {"current": ("A", 1.0), "voltage": ("V", 60.0)}


def test_a_report_of_runs_that_go_astray_is_finite_and_says_so_in_words(monkeypatch):
    usual = answer._before
    monkeypatch.setattr(answer, "_before", lambda *given: replace(usual(*given), gap=math.inf, gap_as_is=math.inf))
    diagnosis = diagnose(block([(DESCRIPTION.effects[0], 0, 0.3)])).diagnosis
    json.dumps(diagnosis.report, allow_nan=False)
    gap = diagnosis.report["gap"]
    assert (gap["as_is"], gap["before"], gap["closed_fraction"]) == (None, None, 1.0)
    assert (diagnosis.gap("before"), diagnosis.gap("after")) == (math.inf, gap["after"])
    assert gap["after"] > 0.0 and "astray" in diagnosis.sentence and "inf" not in diagnosis.sentence
