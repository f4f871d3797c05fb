"""`ddh-twin study cold-start`: small sweeps."""

import csv
import json

import pytest
from ddh_twin_py.cli.main import main
from ddh_twin_py.cli.study import ambients
from ddh_twin_py.report.page.heatmap import CIVIDIS, Cell, heatmap, on_scale


def test_a_sweep_writes_page_csv_and_json_that_agree(tmp_path, capsys):
    page, lines, numbers = (tmp_path / f"cold.{end}" for end in ("html", "csv", "json"))
    given = ["study", "cold-start", "--ambient", "-30:20:25", "--grades", "15,68", "--duty", "paper_cycle_fast", "--hours", "0.5"]
    assert main([*given, "--html", str(page), "--csv", str(lines), "--json", str(numbers)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    data = json.loads(numbers.read_text())
    assert [(r["grade"], r["ambient_degC"]) for r in data["rows"]] == [(g, t) for g in ("ISO VG 15", "ISO VG 68") for t in (-30, -5, 20)]
    assert data["verdict"] in out and data["verdict"] in page.read_text()
    assert "extrapolated" in out and any("extrapolated for the starts at -30" in a for a in data["end_matter"]["assumptions"])
    table = list(csv.DictReader(lines.read_text().splitlines()))
    assert [row["verdict"] for row in table] == [row["verdict"] for row in data["rows"]]
    assert len({row["verdict"] for row in table}) >= 2
    html = page.read_text()
    assert html.count("<svg") == 3 and 'class="flip"' in html and "<figure" not in html
    for flip in data["flips"]:
        assert flip["what_happens"] in html


def test_the_same_sweep_twice_is_the_same(capsys):
    found = []
    for _ in range(2):
        assert main(["study", "cold-start", "--ambient=-5", "--grades", "HVLP 32", "--duty", "paper_cycle", "--hours", "0.3",
                     "--json", "-", "--quiet"]) == 0
        found.append(json.loads(capsys.readouterr().out)["rows"])
    assert found[0] == found[1]


@pytest.mark.parametrize("given, expected", [
    (["study", "cold"], "no study 'cold'; the nearest is 'cold-start'"),
    (["study", "cold-start", "--ambient", "1:2"], "'1:2' is neither FROM:TO:STEP nor a list"),
    (["study", "cold-start", "--ambient", "200"], "an ambient of 200 degC, allowed are -60 to 80 degC"),
    (["study", "cold-start", "--grades", "VG 33"], "no oil grade 'VG 33'; the nearest is 'ISO VG 32'"),
    (["study", "cold-start", "--duty", "paper"], "paper: no such duty file, and no duty 'paper'; the nearest is 'paper_cycle'"),
    (["study", "cold-start", "--ambient=-60:80:0.02"], "'-60:80:0.02' are more than 5000 ambients"),
    (["study", "cold-start", "--ambient", "-30:40:nan"], "'-30:40:nan' is neither FROM:TO:STEP nor a list"),
    (["study", "cold-start", "--rig", ""], "argument --rig: an empty name"),
    (["study", "cold-start", "--hours", "0"], "'0' is no number above 0"),
    (["study", "cold-start", "--hours", "1e9"], "argument --hours: '1e9' is above 1000 h"),
])
def test_what_cannot_be_used_is_one_line(given, expected, capsys):
    try:
        code = main(given)
    except SystemExit as left:
        code = left.code
    assert code == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert expected in line


def test_ranges_of_ambient():
    assert ambients("-30:40:5") == [float(t) for t in range(-30, 41, 5)]
    assert ambients("20,-10") == [-10.0, 20.0]


def test_a_map_has_lines_where_groups_change_and_nowhere_else():
    a, b = (Cell("#ffffff", name, name, name) for name in "ab")
    assert heatmap(["1", "2"], ["x", "y"], [[a, a], [a, a]], "x", "same").count('d=""') == 2
    assert heatmap(["1", "2"], ["x"], [[a, b]], "x", "differs").count("v34") == 2
    assert on_scale(0.0, 0.0, 1.0) == CIVIDIS[0] and on_scale(1.0, 0.0, 1.0) == CIVIDIS[-1]


def test_duties_that_stand_or_share_a_name_and_outputs_over_them_are_refused(tmp_path, capsys):
    still, twin = tmp_path / "still.yaml", tmp_path / "more" / "still.yaml"
    still.write_text("cycle:\n  - dwell: {duration_s: 10}\n  - speed: {speed_rpm: 0, duration_s: 5}\n")
    twin.parent.mkdir()
    twin.write_text("cycle:\n  - lift: {speed_rpm: 500, to_m: 0.3}\n")
    for options, expected in (
        (["--duty", str(still)], f"{still}: cycle: nothing moves"),
        (["--duty", f"{twin},{still}"], f"{twin} and {still} have the same name"),
        (["--duty", str(twin), "--json", str(twin)], f"--json would overwrite '{twin}'"),
    ):
        before = twin.read_text()
        try:
            code = main(["study", "cold-start", "--ambient", "20", "--grades", "32", "--hours", "0.1", "--quiet", *options])
        except SystemExit as left:
            code = left.code
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert code == 2 and expected in line and twin.read_text() == before
