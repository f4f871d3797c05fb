"""`ddh-twin gap-bench` as people call it."""

import json
import shutil

import pytest
import yaml
from ddh_twin_py.cli.main import main
from ddh_twin_py.gap_bench.sealing import seal
from support.gap_reports import report, result, truth


@pytest.fixture
def answered(tmp_path):
    """A sealed bench of three cases, two of them answered."""
    for folder in ("truth", "results"):
        (tmp_path / folder).mkdir()
    rows = [truth("case_0001"), truth("case_0002", "none", "", ()), truth("case_0003", "two", "faint", ("pump_1.leakage", "load.mass"))]
    for row in rows:
        (tmp_path / "truth" / f"{row['name']}.yaml").write_text(yaml.safe_dump(row))
    said = {"case_0001": report(why=[("pump_1.leakage", 0.9)]), "case_0002": report("no_gap", where="")}
    for name, given in said.items():
        (tmp_path / "results" / f"{name}.blind.json").write_text(json.dumps(result(given)))
    seal(tmp_path)
    return tmp_path


@pytest.fixture
def other(answered):
    """Another sealed bench of the same cases, whose answers took another time."""
    folder = answered / "other"
    shutil.copytree(answered, folder, ignore=shutil.ignore_patterns("other"))
    for file in (folder / "results").iterdir():
        file.write_text(json.dumps({**json.loads(file.read_text()), "seconds": 77.0}))
    return folder


def test_what_has_no_answer_yet_is_left_out(answered, capsys):
    assert main(["gap-bench", "score", str(answered)]) == 0
    said = capsys.readouterr()
    assert "Of 2 sealed cases 100 %" in said.out and "1 cases have no answer yet" in said.out + said.err
    for file in (answered / "results").iterdir():
        file.unlink()
    assert main(["gap-bench", "score", str(answered)]) == 2
    assert f"{answered}: no case has an answer yet" in capsys.readouterr().err


def test_score_prints_and_writes(answered, capsys):
    (answered / "results" / "case_0003.blind.json").write_text(json.dumps({"error": "was killed", "seconds": 1.0}))
    assert main(["gap-bench", "score", str(answered)]) == 0
    said = capsys.readouterr().out
    assert "Of 3 sealed cases 67 %" in said
    assert "crashed: case_0003: was killed" in said
    scores = json.loads((answered / "scores.json").read_text())
    assert scores["all"]["scores"]["right"]["value"] == pytest.approx(2 / 3)
    page = (answered / "scores.html").read_text()
    assert "<svg" in page and "case_0003" in page and "stated probability" in page


def test_several_benches_are_scored_together(answered, other, tmp_path, capsys):
    assert main(["gap-bench", "score", str(answered), str(other), "--html", str(tmp_path / "both.html")]) == 0
    assert "Of 4 sealed cases 100 %" in capsys.readouterr().out
    assert "other/case_0001" in (tmp_path / "both.html").read_text() and not (other / "scores.json").exists()


def test_a_bench_among_several_is_scored_alone(answered, other, capsys):
    asked = ["gap-bench", "score", str(answered), str(other), "--json", "-", "--quiet"]
    assert main([*asked, "--bench", "other"]) == 0
    scored = json.loads(capsys.readouterr().out)
    assert scored["cases"] == len(scored["answers"]) > 0 and {row["name"].split("/")[0] for row in scored["answers"]} == {"other"}
    assert main([*asked, "--bench", "othr"]) == 2
    assert "--bench: no bench 'othr'; the nearest is 'other'" in capsys.readouterr().err
    assert main(["gap-bench", "run", str(answered), "--bench", "other"]) == 2
    assert "--bench: is for the step score, which run is not" in capsys.readouterr().err


def test_score_of_one_suite_as_json(answered, capsys):
    assert main(["gap-bench", "score", str(answered), "--suite", "none", "--json", "-", "--quiet"]) == 0
    assert json.loads(capsys.readouterr().out)["cases"] == 1


def test_changed_truth_is_refused_in_one_line(answered, capsys):
    file = answered / "truth" / "case_0001.yaml"
    file.write_text(file.read_text().replace("single", "none"))
    assert main(["gap-bench", "score", str(answered)]) == 2
    assert capsys.readouterr().err == f"ddh-twin gap-bench: error: {file}: was changed after it was sealed\n"


@pytest.mark.parametrize(("words", "said"), [
    (["frob", "out"], "'frob' is no step, valid are make, run, score"),
    (["run", "a", "b"], "run: 2 folders were given, one is needed"),
    (["score", "a", "--suite", "nne"], "--suite: no suite 'nne'; the nearest is 'none', valid are none, single, two"),
    (["score", "nowhere"], "nowhere/plan.sha256: no seal"),
])
def test_wrong_words(words, said, capsys):
    assert main(["gap-bench", *words]) == 2
    assert said in capsys.readouterr().err


def test_a_damaged_answer_is_named_and_no_score_is_made_of_it(answered, capsys):
    file = answered / "results" / "case_0001.blind.json"
    for damage in (file.read_text()[:40], "[]", '{"report": {"verdict": "no_gap"}, "seconds": 1.0, "megabytes": 1.0}'):
        file.write_text(damage)
        assert main(["gap-bench", "score", str(answered)]) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1 and f"{file}: is no answer to a case" in said and f"gap-bench run {answered}" in said
    assert not (answered / "scores.json").exists()


@pytest.mark.parametrize(("page", "said"), [
    ("no marks", "no place for the table"), (b"\xff\xfe", "is no text in UTF-8"), (None, "No such file"),
])
def test_a_page_without_a_place_for_the_table_is_refused_before_any_work(page, said, answered, capsys):
    file = answered / "page.md"
    if page is not None:
        file.write_bytes(page if isinstance(page, bytes) else page.encode())
    assert main(["gap-bench", "score", str(answered), "--table", str(file)]) == 2
    told = capsys.readouterr().err
    assert said in told and told.count("\n") == 1 and not (answered / "scores.json").exists()


def test_outputs_that_would_not_be_written_or_written_twice(answered, capsys):
    assert main(["gap-bench", "run", str(answered), "--json", str(answered / "s.json")]) == 2
    assert "--json: is for the step score, which run is not" in capsys.readouterr().err
    page = answered / "page.md"
    page.write_text("<!-- gap-bench: begin -->\n<!-- gap-bench: end -->\n")
    assert main(["gap-bench", "score", str(answered), "--table", str(page), "--html", str(page)]) == 2
    assert "--table and --html both write to" in capsys.readouterr().err and "begin -->" in page.read_text()


def test_a_folder_that_is_of_no_bench_is_not_overwritten(tmp_path, capsys):
    kept = tmp_path / "cases" / "case_0001" / "field"
    kept.mkdir(parents=True)
    assert main(["gap-bench", "make", str(tmp_path), "--cases", "1", "--suite", "none"]) == 2
    assert f"{tmp_path}/cases: is of no bench" in capsys.readouterr().err and kept.is_dir()
    (tmp_path / "recipe.json").write_text('{"cases": 1')
    assert main(["gap-bench", "make", str(tmp_path), "--cases", "1", "--suite", "none"]) == 2
    assert "recipe.json: is no recipe of a bench" in capsys.readouterr().err and kept.is_dir()
