"""`ddh-twin gap-design`: a short duty, page, table and JSON."""

import json

import pytest
from ddh_twin_py.cli.main import main

DUTY = """
payload_kg: 150
repeat: 0
cycle:
  - lift: {speed_rpm: 600, to_m: 0.3}
  - dwell: {duration_s: 1}
  - lower: {speed_rpm: 600, to_m: 0.02}
"""


@pytest.fixture
def duty(tmp_path):
    path = tmp_path / "short.yaml"
    path.write_text(DUTY)
    return path


def test_page_table_and_json_agree(tmp_path, duty, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    page, numbers = tmp_path / "design.html", tmp_path / "design.json"
    assert main(["gap-design", str(duty), "--duration", "45", "--sensors", "motor_housing", "--without-commissioning",
                 "--html", str(page), "--json", str(numbers)]) == 0
    out = capsys.readouterr().out
    data = json.loads(numbers.read_text())
    html = page.read_text()
    assert data["verdict"] in " ".join(out.split()) and data["verdict"] in html
    assert data["sensors"] == ["motor_housing"] and data["pressures"] and data["commissioning_s"] == 0.0
    assert max(len(line) for line in out.splitlines()) <= 80
    for row in data["effects"]:
        component, _, name = row["effect"].partition(".")
        assert row["effect"] in out or f"\n{component}. " in out and f"\n {name} " in out
    n = len(data["separation"]["effects"])
    assert 10 < n <= len(data["effects"]) and len(data["separation"]["expected_log_bayes_factor"]) == n
    assert html.count("<rect") == n * n and "src=" not in html
    seen = {row["effect"] for row in data["effects"] if row["detected"]["moderate"]}
    assert all(set(members) <= seen for members in data["classes"])
    assert 0 < len(seen) < len(data["effects"])


@pytest.mark.parametrize("given, expected", [
    (["--sensors", " ,"], "names no sensor; `none` says that there is none"),
    (["--sensors", "tank_oill"], "no temperature sensor 'tank_oill'; the nearest is 'tank_oil'"),
    (["--duration", "5"], "'5' is no number from 30 to 3600 s"),
    (["--duration", "-5"], "'-5' is no number from 30 to 3600 s"), (["--duration", "long"], "'long' is no number from 30 to 3600 s"),
    (["--commissioning", "mixed", "--without-commissioning"], "--commissioning mixed and --without-commissioning exclude each other"),
    (["--commissioning", "mixd"], "no duty 'mixd'; the nearest is 'mixed'"),
])
def test_what_cannot_be_used_is_named(duty, capsys, given, expected):
    try:
        code = main(["gap-design", str(duty), *given])
    except SystemExit as left:
        code = left.code
    said = capsys.readouterr().err.splitlines()[-1]
    assert code == 2 and expected in said
