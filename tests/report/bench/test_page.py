"""The page of a sealed bench: an aim is reached only where the cases are enough to say so."""

import re

import pytest
from ddh_twin_py.gap_bench.scoring import answers_of_all, summary
from ddh_twin_py.report.bench.page import gap_bench_document, reached, verdict


def a_row(value, low, high, n, bound, most=False):
    return {"score": {"value": value, "low": low, "high": high, "n": n}, "bound": bound, "most": most}


@pytest.mark.parametrize(("row", "said"), [
    (a_row(1.0, 0.21, 1.0, 1, 0.5), "too few cases"),
    (a_row(0.0, 0.0, 0.79, 1, 0.05, most=True), "too few cases"),
    (a_row(1.0, 0.82, 1.0, 18, 0.5), "yes"),
    (a_row(0.96, 0.88, 0.99, 60, 0.95), "yes"),
    (a_row(0.9, 0.8, 0.96, 60, 0.95), "no"),
    (a_row(0.1, 0.02, 0.4, 10, 0.5), "no"),
])
def test_few_cases_say_neither_yes_nor_no(row, said):
    assert said in reached(row)


def test_nothing_is_said_where_no_case_tells():
    assert reached(a_row(None, None, None, 0, 0.5)) == "–"


def test_the_sentence_says_how_many_aims_are_met_and_of_how_many_cases():
    share = {"value": 0.8, "low": 0.7, "high": 0.9, "n": 60}
    none = {"value": None, "low": None, "high": None, "n": 0}
    aims = [a_row(0.96, 0.88, 0.99, 60, 0.95), a_row(0.9, 0.8, 0.96, 60, 0.95), a_row(1.0, 0.21, 1.0, 1, 0.5)]
    said = verdict({"all": {"scores": {"right": share, "first": share, "false_alarm": none}}, "crashed": [], "aims": aims})
    assert said == "Of 60 sealed cases 80 % (70–90) are answered rightly; true effect first in 80 % (70–90) of 60; 1 of 2 aims is met."


def test_scores_stand_in_a_table_for_each_suite_that_is_no_wider_than_its_levels(repo_root):
    scored = summary(answers_of_all([repo_root / "docs" / "gap_bench_answers.json"])[0])
    page = str(gap_bench_document(scored, "docs").html())
    widest = max(sum(row["suite"] == suite for row in scored["suites"]) for suite in {row["suite"] for row in scored["suites"]})
    heads = [head.count("<th ") for head in re.findall("<thead>.*?</thead>", page.partition(">Scores<")[2].partition(">Reliability<")[0])]
    assert len(heads) == 1 + len({row["suite"] for row in scored["suites"]}) and max(heads) == 1 + widest <= 5
    assert all(f"Suite {row['suite']}, by level" in page for row in scored["suites"])
