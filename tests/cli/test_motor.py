"""`ddh-twin motor`: files that it writes, what it says."""

import json
from types import SimpleNamespace

from ddh_twin_py.cli.console import output
from ddh_twin_py.cli.main import main
from ddh_twin_py.report.studies.motor_comparison import Row
from ddh_twin_py.report.studies.motor_page import print_motor
from ddh_twin_py.rig import load_rig


def test_everything_that_it_writes(capsys, tmp_path):
    html, numbers, rig = tmp_path / "m.html", tmp_path / "m.json", tmp_path / "rig.yaml"
    assert main(["motor", "--layers", "4", "--html", str(html), "--json", str(numbers), "-o", str(rig)]) == 0
    said = capsys.readouterr().out
    assert "slot_to_end_winding" in said and "order of convergence" in said
    data = json.loads(numbers.read_text())
    assert abs(data["rated"]["heat_W"] - data["rated"]["lost_W"]) < 1e-3
    assert [s["layers"] for s in data["convergence"]] == [1, 2, 4, 8]
    assert data["rated"]["hot_spot_degC"] > data["rated"]["means_degC"]["slot_winding"]
    generated = {row["path"]: row["generated"] for row in data["quantities"]}
    loaded = load_rig(rig)
    assert all(abs(loaded[path] / value - 1.0) < 1e-4 for path, value in generated.items())
    page = html.read_text()
    assert page.count("<polygon") == 2 * (1 + 4 * 3 + 2 * 3)  # tip, four rows of three, two rows of yoke; mirrored
    assert all(path in page for path in generated)


def test_a_description_of_another_machine(capsys, tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("machine_id: mine\nwinding:\n  impregnation: {value: 0.2}\n")
    output = tmp_path / "rig.yaml"
    assert main(["motor", "--layers", "2", "--description", str(file), "-o", str(output)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("mine: ") and "(0 of them explained)" in said
    assert "The description gives no explanation." in said  # notes speak of the machine that they stand with
    assert f"generated from mine with 2 layers ({file})" in load_rig(output).quantities["motor.thermal.slot_to_teeth"].source


def test_notes_are_printed_as_they_were_written(capsys):
    row = Row("motor.thermal.x", "W/K", 1.0, 2.0, 0.1, -5.0, "outside", "wider than the drawing [see sheet 3], taken from [/lab]")
    print_motor(SimpleNamespace(machine=SimpleNamespace(machine_id="mine [2]")), SimpleNamespace(misfit=0.01), [row], [], output())
    said = " ".join(capsys.readouterr().out.split())
    assert said.startswith("mine [2]: ") and f"motor.thermal.x: {row.note}" in said and " -5.0 " in said


def test_interrupted_before_the_end_nothing_is_written(monkeypatch, tmp_path):
    def interrupt(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr("ddh_twin_py.report.studies.motor_comparison.cycles", lambda *given: [])
    monkeypatch.setattr("ddh_twin_py.report.studies.motor_comparison.sensitivities", interrupt)
    out = tmp_path / "out"
    files = ["--html", str(out / "m.html"), "--json", str(out / "m.json"), "-o", str(out / "rig.yaml")]
    assert main(["motor", "--layers", "1", "--quiet", *files]) == 130
    assert not out.exists()


def test_errors_are_one_line(capsys, tmp_path):
    file = tmp_path / "odd.yaml"
    file.write_text("stator:\n  bore: {value: 58, unit: m}\n")
    assert main(["motor", "--description", str(file)]) == 2
    assert "stator.bore: value is 58 m" in capsys.readouterr().err
    file.write_text("housing:\n  emissivity: {value: 0.0}\n  rib_count: {value: 0}\nwinding:\n  fill: {value: 0.2}\n")
    assert main(["motor", "--description", str(file), "--layers", "2", "--quiet"]) == 2
    assert f"{file}: no steady state at 5.06 A" in capsys.readouterr().err
    output = tmp_path / "rig.yaml"
    file.write_text("bearings:\n  seal_torque: {value: 5.0, unit: N*m}\n")  # a hundred times the sheet's friction
    assert main(["motor", "--description", str(file), "--layers", "2", "--quiet", "-o", str(output)]) == 2
    assert f"{output}: motor.friction_coulomb: value is" in capsys.readouterr().err and not output.exists()
    for given, expected in (("0", "no whole number from 1 to 24"), ("x", "no whole number")):
        try:
            main(["motor", "--layers", given])
        except SystemExit as leaving:
            assert leaving.code == 2
        assert expected in capsys.readouterr().err
