"""`ddh-twin gap` from bags to report: an effect of the independent plant is found, and what cannot be used is refused."""

import json
from dataclasses import replace

import jsonschema
import pytest
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.cli.main import main
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import RigInfo, Stream
from support.drifted import recorded

pytestmark = pytest.mark.long

EFFECT, SIZE = "sensor.pressure_rod_side_offset", 2.0e5
"""Pa; ten times the noise of a sample."""


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("case")
    write_recording(folder / "commissioning", recorded(120.0))
    write_recording(folder / "field", recorded(150.0, EFFECT, SIZE))
    return folder


@pytest.fixture(scope="module")
def answered(case):
    """Exit code and what was written for the whole case."""
    out = case / "out"
    written = ["--json", str(out / "g.json"), "--html", str(out / "g.html"), "-o", str(out / "rig.yaml")]
    return main(["gap", str(case), *written, "--quiet"]), out


@pytest.fixture
def schema(shared_dir):
    return json.loads((shared_dir / "gap_report.schema.json").read_text())


def test_the_effect_is_found_with_its_size_and_closes_the_gap(answered):
    code, out = answered
    report = json.loads((out / "g.json").read_text())
    assert code == 0 and report["verdict"] in ("explained", "ambiguous")  # beside it a relief valve may or may not have moved
    first = report["why"][0]
    assert first["effect"] == EFFECT and first["probability"] > 0.9
    offset = first["parameters"]["offset"]
    assert abs(offset["value"] - SIZE) < 4.0 * offset["std"] and offset["std"] < 0.2 * SIZE
    assert report["gap"]["before"] > 1.5 > report["gap"]["after"] and report["gap"]["closed_fraction"] > 0.6
    rod = report["shrink"]["pressure_rod_side"]
    for when in ("before", "after"):
        low, high = rod[f"{when}_interval"]
        assert low < rod[when] < high
    assert rod["before"] > 3.0 * rod["after"] and rod["unit"] == "Pa"
    assert sum(row["share"] for row in report["where"]) == pytest.approx(1.0)
    assert report["where"][0]["component"] == "sensor" and report["where"][0]["missing"] == pytest.approx(SIZE, rel=0.3)
    assert "from" in report["held_out"] and sum(h["probability"] for h in report["hypotheses"]) <= 1.0 + 1e-9


def test_the_report_keeps_to_the_contract(answered, schema):
    jsonschema.validate(json.loads((answered[1] / "g.json").read_text(), parse_constant=pytest.fail), schema)


def test_page_and_rig_file_say_the_same(answered):
    _, out = answered
    assert EFFECT in (out / "g.html").read_text()
    report = json.loads((out / "g.json").read_text())
    rig = load_rig(out / "rig.yaml")
    path = "measurement.pressure_rod_side_offset"
    assert rig[path] == pytest.approx(report["why"][0]["parameters"]["offset"]["value"], abs=0.5 * SIZE)
    assert EFFECT in rig.quantities[path].source


def refused(arguments, capsys):
    assert main(["gap", *map(str, arguments), "--quiet"]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    return line


def test_bags_of_two_rigs_are_refused(case, tmp_path, capsys):
    other = write_recording(tmp_path / "other", replace(recorded(120.0), rig=RigInfo("crane_2", "ISO VG 32", 150.0)))
    assert "rig_id is 'drifted'" in (line := refused([case / "field", "--commissioning", other], capsys)) and "crane_2" in line


def test_a_bag_of_another_thing_is_refused(tmp_path, capsys):
    bag = write_recording(tmp_path / "bag", replace(recorded(120.0).between(0.0, 20.0), drive=None))
    assert "drive/telemetry" in refused([bag], capsys)


def test_a_recording_without_pressure_telemetry_is_refused(tmp_path, capsys):
    bag = write_recording(tmp_path / "bag", replace(recorded(120.0).between(0.0, 20.0), hydraulic=None))
    assert "hydraulics/telemetry" in refused([bag], capsys)


def test_a_recording_in_which_nothing_moves_has_a_report_that_says_so(case, tmp_path, capsys, schema):
    new = recorded(120.0).between(0.0, 60.0)
    drive = Stream(new.drive.time, 0.0 * new.drive.values, new.drive.fields)
    hydraulic = Stream(new.hydraulic.time, 0.0 * new.hydraulic.values + new.hydraulic.values[0], new.hydraulic.fields)
    bag = write_recording(tmp_path / "still", replace(new, drive=drive, hydraulic=hydraulic))
    assert main(["gap", str(bag), "--commissioning", str(case / "commissioning"), "--json", "-", "--quiet"]) == 0
    report = json.loads(capsys.readouterr().out)
    jsonschema.validate(report, schema)
    assert report["verdict"] == "insufficient" and any("the drive turns for 0.0 s only" in note for note in report["notes"])
    assert "the drive turns for 0.0 s only" in refused([case / "field", "--commissioning", bag], capsys)
