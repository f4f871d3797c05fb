"""What the benchmark of the diagnosis times is a diagnosis of the recordings that it says."""

import json
from itertools import pairwise

import pytest
from ddh_twin_py.bags.case import case_of
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.benchmarks import diagnosis_speed, timed_process
from ddh_twin_py.benchmarks.timed_process import ProcessFailed, timed
from ddh_twin_py.rig import load_rig


def test_both_cases_are_made_and_asked_about(tmp_path, monkeypatch):
    asked, shares = [], []

    def said(*arguments, told):
        told("diagnosing: 12 %, fitting the rig, after 15 s\ndiagnosing: 60 %, weighing effects, after 30 s\n")
        case = case_of([arguments[1]], None, None, None)
        asked.append((case.commissioning is not None, read_recording(case.field[0]).duration, case.validation is not None))
        (tmp_path / "report.json").write_text(json.dumps({"verdict": "explained"}))
        return 12.0, 800.0

    monkeypatch.setattr(diagnosis_speed, "timed", said)
    figures = diagnosis_speed.time_diagnosis(load_rig(), tmp_path, 30.0, shares.append)
    assert shares == [0.3, 0.8]
    assert [(built, validated) for built, _, validated in asked] == [(True, True), (False, True)]
    assert all(duration == pytest.approx(28.9, abs=1.0) for _, duration, _ in asked)
    assert [(f.value, f.unit, f.against) for f in figures] == [(12.0, "s", None), (800.0, "MB", None)] * 2
    assert "explained" in figures[0].name and "with commissioning" in figures[0].name


def test_a_command_that_goes_on_tells_what_it_has_said(monkeypatch, paper_cycle_bag):
    monkeypatch.setattr(timed_process, "_LOOK", 0.02)
    heard = []
    timed("replay", str(paper_cycle_bag), "--no-smoothing", told=heard.append)
    assert any("reading" in text for text in heard) and all(later.startswith(text) for text, later in pairwise(heard))


def test_a_command_is_timed_and_what_it_says_is_kept_where_it_fails():
    seconds, megabytes = timed("--help")
    assert seconds > 0.0 and megabytes > 5.0
    with pytest.raises(ProcessFailed, match=r"ddh-twin gap nowhere --quiet left with 2: .*nowhere"):
        timed("gap", "nowhere", "--quiet")
