"""`ddh-twin paper`: table, JSON and page."""

import json

from ddh_twin_py.cli.main import main


def test_table_json_and_page_agree(tmp_path, capsys):
    page, numbers = tmp_path / "paper.html", tmp_path / "paper.json"
    assert main(["paper", "--html", str(page), "--json", str(numbers)]) == 0
    out = capsys.readouterr().out
    rows = json.loads(numbers.read_text())["rows"]
    assert len(rows) > 20
    for row in rows:
        assert {"result", "paper", "twin", "unit", "explanation"} <= set(row)
    html = page.read_text()
    for figure in (3, 4, 5, 6):
        assert f"Figure {figure}:" in html
    torque = next(row for row in rows if row["result"].startswith("Torque in the lift, 149.5"))
    assert torque["paper"] == 16.0 and f"{torque['twin']:.2f}" in out and f"{torque['twin']:.2f}" in html
    assert torque["explanation"].split(";")[0][:30] in " ".join(out.split()) and "http://" not in html.replace("http://www.w3.org", "")


def test_json_to_standard_output_is_alone_there(capsys):
    assert main(["paper", "--json", "-", "--quiet"]) == 0
    assert len(json.loads(capsys.readouterr().out)["rows"]) > 20


def test_a_rig_file_that_is_missing_is_one_line(capsys):
    assert main(["paper", "--rig", "no_such.yaml"]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == "ddh-twin paper: error: no_such.yaml: no such rig file"
