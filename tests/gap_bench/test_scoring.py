"""Scores of reports made by hand."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from ddh_twin_py.gap_bench.answers import answer_of, groups_of
from ddh_twin_py.gap_bench.intervals import mean, median, share
from ddh_twin_py.gap_bench.result_files import ResultError
from ddh_twin_py.gap_bench.scoring import answers_of_all, confusion, reliability, score, summary
from ddh_twin_py.gap_bench.sealing import seal
from ddh_twin_py.report.bench.page import shown
from ddh_twin_py.report.bench.table import BEGIN, END, TableError, gap_bench_table, write_table
from support.gap_reports import report, result, truth

P1, P2 = "pump_1.leakage", "pump_2.leakage"


def answer(case, blind, **further):
    return answer_of(case, {"blind": result(blind), **{q: result(r) for q, r in further.items()}})


def test_right_effect_first():
    a = answer(truth(), report(why=[(P1, 0.9), (P2, 0.1)]), oracle=report(closed=1.0))
    assert (a.right, a.detected, a.ranks, a.named, a.component_first) == (True, True, (1.0,), P1, True)
    assert a.probability == (0.9,)
    assert a.closed == pytest.approx(0.9)
    assert a.errors == (pytest.approx(0.2),) and a.covered == (True,)


def test_wrong_effect_first():
    a = answer(truth(), report(why=[(P2, 0.7), ("oil.air_content", 0.2), (P1, 0.1)], where="pump_2"))
    assert (a.right, a.ranks, a.component_first) == (False, (3.0,), False)
    scores = score([a])
    assert (scores["first"].value, scores["third"].value, scores["detected"].value) == (0.0, 1.0, 1.0)


def test_truth_outside_the_interval():
    assert answer(truth(), report(why=[(P1, 0.9)], value=1.1, std=0.1)).covered == (False,)


def test_small_class_counts_and_a_large_one_does_not():
    why = [(P2, 0.4), (P1, 0.3), ("oil.air_content", 0.2), ("load.mass", 0.1)]
    small = answer(truth(), report("ambiguous", why, classes=[(P1, P2)]))
    assert (small.ranks, small.right) == ((1.0,), True)
    assert small.probability == (pytest.approx(0.7),)
    large = answer(truth(), report("ambiguous", why, classes=[(P1, P2, "oil.air_content", "load.mass")]))
    assert (large.ranks, large.right) == ((2.0,), False)


def test_a_class_outweighs_a_single_effect():
    groups = groups_of(report(why=[("load.mass", 0.4), (P1, 0.3), (P2, 0.3)], classes=[(P1, P2)]))
    assert [g.effects for g in groups] == [(P1, P2), ("load.mass",)]


def test_false_alarm_and_silence():
    quiet = answer(truth(suite="none", level="", effects=()), report("no_gap", where=""))
    loud = answer(truth(suite="tolerance", level="", effects=()), report("explained", [(P1, 0.8)]))
    assert (quiet.right, quiet.detected, loud.right, loud.detected) == (True, False, False, True)
    scores = score([quiet, loud])
    assert scores["false_alarm"].value == 0.5
    assert scores["detected"].n == 0 and math.isnan(scores["detected"].value)


def test_missed_effect_does_not_count_as_first():
    a = answer(truth(), report("no_gap", [(P1, 0.2)], where=""))
    assert not a.right and score([a])["first"].value == 0.0


def test_both_of_two():
    case = truth(suite="two", effects=(P1, "load.mass"))
    both = answer(case, report(why=[(P1, 0.9), ("load.mass", 0.8)], hypotheses=[{"effects": [P1, "load.mass"], "probability": 0.8}]))
    one = answer(case, report(why=[(P1, 0.9), (P2, 0.4), ("load.mass", 0.3)]))
    through_a_class = answer(case, report(why=[(P2, 0.9), ("load.mass", 0.8)], classes=[(P1, P2)],
                                          hypotheses=[{"effects": [P2, "load.mass"], "probability": 0.8}]))
    of_one_class = answer(truth(suite="two", effects=(P1, P2)), report(why=[(P1, 0.9), (P2, 0.1)], classes=[(P1, P2)],
                                                                       hypotheses=[{"effects": [P1], "probability": 0.8}]))
    assert (both.both, one.both, through_a_class.both) == (True, False, True)
    assert not of_one_class.both, "one that leads stands for one effect"
    assert score([both])["first"].value == 1.0
    assert score([one])["first"].value == 0.5


def test_unknown_is_found_at_its_component():
    case = truth(suite="outside", effects=("tank.foam_in_motion",), listed=False)
    found = answer(case, report("unknown", [("unknown", 0.9)], where="tank", unknown={"component": "tank"}))
    elsewhere = answer(case, report("unknown", [("unknown", 0.9)], where="pump_1", unknown={"component": "pump_1"}))
    blamed = answer(case, report(why=[(P1, 0.9)]))
    assert [(a.right, a.unknown_component) for a in (found, elsewhere, blamed)] == [(True, True), (True, False), (False, False)]
    assert score([found, elsewhere, blamed])["unknown_found"].value == pytest.approx(2 / 3)


def test_left_out_is_scored_by_its_own_report():
    case = truth(suite="left_out")
    blind = report(why=[(P1, 0.9)])
    right = answer(case, blind, left_out=report("unknown", [("unknown", 0.8)], unknown={"component": "pump_1"}))
    wrong = answer(case, blind, left_out=report(why=[(P2, 0.9)]))
    assert (right.right, wrong.right) == (True, False)
    assert right.true == ()


def test_false_unknown():
    a = answer(truth(), report("unknown", [("unknown", 0.7), (P1, 0.3)], unknown={"component": "pump_1"}))
    assert score([a])["false_unknown"].value == 1.0 and not a.right


def test_crash_counts_as_wrong_and_is_listed():
    fine = answer(truth("case_0001"), report(why=[(P1, 0.9)]))
    broken = answer_of(truth("case_0002"), {"blind": {"error": "exit status 1: MemoryError", "seconds": 3.0}})
    missing = answer_of(truth("case_0003", "none", "", ()), {})
    found = summary([fine, broken, missing])
    assert found["all"]["scores"]["right"]["value"] == pytest.approx(1 / 3)
    assert found["all"]["scores"]["false_alarm"]["value"] == 1.0
    assert [row["name"] for row in found["crashed"]] == ["case_0002", "case_0003"]
    assert found["crashed"][0]["why"] == "exit status 1: MemoryError"


def test_reliability_of_what_was_said():
    answers = [answer(truth(), report(why=[(P1, 0.85), (P2, 0.15)])) for _ in range(3)]
    answers.append(answer(truth(), report(why=[(P2, 0.85), (P1, 0.15)])))
    rows = {row["from"]: row for row in reliability(answers)}
    assert rows[0.8]["right"]["value"] == 0.75 and rows[0.8]["stated"] == pytest.approx(0.85)
    assert rows[0.1]["right"]["value"] == 0.25
    assert rows[0.5]["right"]["n"] == 0


def test_no_gap_is_a_statement_whose_probability_is_held_against_what_was_hidden():
    silent = report("no_gap", where="", hypotheses=[{"effects": [], "probability": 0.95, "gap_after": 1.0}])
    answers = [answer(truth(suite="none", level="", effects=()), silent), answer(truth(level="faint"), silent)]
    row = reliability(answers)[9]
    assert (row["stated"], row["right"]["value"], row["right"]["n"]) == (0.95, 0.5, 2)
    assert replace(answers[0], none=None).stated == ()  # of a score that was kept before


def test_confusion_counts_truth_against_answer():
    rows = confusion([answer(truth(), report(why=[(P2, 0.9)])), answer(truth(), report(why=[(P1, 0.9)])),
                      answer(truth(suite="none", level="", effects=()), report("no_gap", where=""))])
    assert {(r["true"], r["said"]): r["cases"] for r in rows} == {(P1, P2): 1, (P1, P1): 1, ("no_gap", "no_gap"): 1}


def test_wilson_interval():
    found = share([True] * 8 + [False] * 2)
    assert (found.value, found.n) == (0.8, 10)
    assert found.low == pytest.approx(0.4902, abs=1e-4) and found.high == pytest.approx(0.9433, abs=1e-4)
    assert share([False] * 5).low == 0.0 and share([True] * 5).high == 1.0


def test_bootstrap_interval_holds_the_value():
    values = [1.0, 2.0, 3.0, 4.0, 100.0, math.nan]
    found = median(values)
    assert (found.value, found.n) == (3.0, 5)
    assert found.low <= 3.0 <= found.high
    assert mean(values).value == 22.0


def test_aims_take_the_cases_that_they_are_about():
    clear = answer(truth("case_0001"), report(why=[(P1, 0.9)]))
    faint = answer(truth("case_0002", level="faint"), report("no_gap", where=""))
    outside = answer(truth("case_0003", suite="outside", effects=("tank.foam_in_motion",), listed=False), report(why=[(P1, 0.9)]))
    rows = {row["words"]: row["score"] for row in summary([clear, faint, outside])["aims"]}
    first = {words: score["value"] for words, score in rows.items() if words.startswith(("true effect", "the same"))}
    assert first == {"true effect, or its class of at most three, first: clear": 1.0, "the same: moderate": None, "the same: faint": 0.0}
    assert rows["a gap is found, clear and moderate effects"]["n"] == 2
    assert rows["`unknown` where the effect is outside the catalogue or left out of it"]["value"] == 0.0


def test_table_is_written_between_its_marks(tmp_path):
    page = tmp_path / "README.md"
    page.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n")
    found = summary([answer(truth(), report(why=[(P1, 0.9)]))])
    write_table(found, page)
    assert page.read_text() == f"before\n{BEGIN}\n{gap_bench_table(found)}\n{END}\nafter\n"
    assert "| both of two effects found | at least 75 % | – |" in page.read_text()
    page.write_text("no marks")
    with pytest.raises(TableError, match="README.md: no place for the table"):
        write_table(found, page)


@pytest.mark.parametrize("hits, n, said", [(4, 77, "5.2 %"), (1, 20, "5 %"), (4, 82, "4.9 %"), (5, 77, "6 %")])
def test_a_share_is_told_from_its_bound(hits, n, said):
    estimate = {"value": hits / n, "low": 0.02, "high": 0.13, "n": n}
    assert shown("false_alarm", estimate, 0.05) == f"{said} (2–13), {n}"
    assert shown("false_alarm", estimate).startswith(f"{100 * hits / n:.0f} %")


def test_a_score_is_kept_and_pooled_with_another(tmp_path):
    right = answer(truth(), report(why=[(P1, 0.9), (P2, 0.1)]), oracle=report(closed=1.0))
    crashed = answer_of(truth(), {"blind": {"error": "no memory"}})
    file = tmp_path / "scores.json"
    file.write_text(json.dumps(summary([right, crashed])))
    again, waiting = answers_of_all([file])
    assert (again[0], waiting) == (right, 0) and again[0].checks == (("drifted", 0.5, 8.0),)
    assert again[1].crashed == "no memory" and again[1].ranks == (math.inf,) and math.isnan(again[1].seconds)
    assert summary(again) == summary([right, crashed])
    assert answers_of_all([file], ("none",))[0] == []


def test_copied_answers_do_not_count_twice(tmp_path):
    found = summary([answer(truth(), report(why=[(P1, 0.9), (P2, 0.1)]), oracle=report(closed=1.0))])
    files = [tmp_path / "one.json", tmp_path / "copy.json"]
    for file in files:
        file.write_text(json.dumps(found))
    with pytest.raises(ResultError, match="copy.json: the answer to case_0001 is among the others already"):
        answers_of_all(files)
    found["answers"] *= 2
    files[0].write_text(json.dumps(found))
    with pytest.raises(ResultError, match="one.json: the answer to case_0001 is among the others already"):
        answers_of_all(files[:1])


def test_copied_benches_do_not_count_twice(tmp_path):
    for name in ("one", "copy"):
        bench = tmp_path / name
        for folder in ("truth", "results"):
            (bench / folder).mkdir(parents=True)
        (bench / "truth" / "case_0001.yaml").write_text(yaml.safe_dump(truth()))
        (bench / "results" / "case_0001.blind.json").write_text(json.dumps(result(report(why=[(P1, 0.9)]))))
        seal(bench)
    kept = tmp_path / "kept.json"
    kept.write_text(json.dumps(summary(answers_of_all([bench])[0])))
    for first, second in ((bench, bench), (tmp_path / "one", bench), (bench, kept), (kept, bench)):
        with pytest.raises(ResultError, match=f"{second}: the answer to .*case_0001 is among the others already; copies would"):
            answers_of_all([first, second])


@pytest.mark.parametrize(("name", "value"), [
    ("commissioning", [1, 2]), ("seconds", "x"), ("pairs", [[0.5]]), ("right", None), ("true", "x"),
])
def test_a_kept_answer_of_another_kind_is_named(tmp_path, name, value):
    found = summary([answer(truth(), report(why=[(P1, 0.9), (P2, 0.1)]), oracle=report(closed=1.0))])
    found["answers"][0][name] = value
    file = tmp_path / "odd.json"
    file.write_text(json.dumps(found))
    with pytest.raises(ResultError, match=f"odd.json: is no score of a bench .answers 1: {name} is "):
        answers_of_all([file])


@pytest.mark.parametrize(("name", "value", "said"), [
    ("suite", "zzz", "is 'zzz', valid are 'none', 'single'"), ("level", "loud", "is 'loud', valid are '', 'clear'"),
    ("expected", "", "is '', valid are 'explained'"), ("verdict", "zzz", "is 'zzz', valid are"), ("verdict", "", "is '' beside crashed ''"),
    ("seconds", -1.0, "is -1.0, a finite number from 0 is needed"), ("seconds", math.nan, "is nan, a finite"),
    ("megabytes", math.inf, "is inf, a finite"), ("megabytes", 10**400, "is 1000"), ("closed", -math.inf, "is -inf, a finite number is"),
    ("probability", [1.5], "is 1.5, a finite number from 0 to 1 is needed"), ("pairs", [[-0.5, True]], "is -0.5"),
    ("ranks", [0.0], "is 0.0, a finite number from 1"), ("ranks", [1.0, 2.0], "has 2 values, true 1"),
    ("probability", [], "has 0 values, true 1"),
    ("covered", [], "has 0 values, errors 1"),
])  # fmt: skip
def test_a_kept_answer_that_no_case_can_have_is_named(tmp_path, name, value, said):
    found = summary([answer(truth(), report(why=[(P1, 0.9), (P2, 0.1)]), oracle=report(closed=1.0))])
    found["answers"][0][name] = value
    file = tmp_path / "odd.json"
    file.write_text(json.dumps(found))
    with pytest.raises(ResultError) as refused:
        answers_of_all([file])
    assert f"{file}: is no score of a bench (answers 1, case 'case_0001': {name} {said}" in str(refused.value)
    assert len(str(refused.value)) < 500


def test_a_kept_answer_that_is_nested_deeply_is_named_shortly(tmp_path):
    found = summary([answer(truth(), report(why=[(P1, 0.9), (P2, 0.1)]))])
    found["answers"][0]["pairs"] = "deep"
    file = tmp_path / "odd.json"
    file.write_text(json.dumps(found).replace('"deep"', "[" * 700 + "]" * 700))
    with pytest.raises(ResultError, match="answers 1: pairs is "):
        answers_of_all([file])


@pytest.mark.parametrize("file", ["gap_bench_answers.json", "gap_bench_answers_earlier.json"])
def test_the_answers_that_the_project_keeps_can_be_scored(file):
    answers, waiting = answers_of_all([Path(__file__).parents[2] / "docs" / file])
    assert len(answers) > 300 and waiting == 0


@pytest.mark.parametrize(("content", "why"), [
    ("{", "Expecting"), ("[]", "answers not in it"), ('{"answers": []}', "answers not in it"), ('{"answers": [3]}', "answers 1: no row"),
    ('{"answers": [{"name": "a"}]}', "answers 1: .*suite"), ("[" * 100_000, "nested too deep to be read"),
])
def test_what_is_no_score_is_named(tmp_path, content, why):
    file = tmp_path / "other.json"
    file.write_text(content)
    with pytest.raises(ResultError, match=f"other.json: is no score of a bench .*{why}"):
        answers_of_all([file])
