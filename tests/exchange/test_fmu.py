"""The FMU in another tool: valid, and the same numbers as the simulated rig that the twin's own code runs."""

import json
import os
import subprocess
import sys
import zipfile
from dataclasses import asdict
from types import FunctionType, ModuleType
from xml.etree import ElementTree

import numpy as np
import pytest
from ddh_twin_py.cli.main import main
from ddh_twin_py.cli.simulated import collect
from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.exchange.fmu import archive
from ddh_twin_py.exchange.fmu.variables import PARAMETER, variables
from ddh_twin_py.physics.cylinder import holding_pressure
from ddh_twin_py.physics.free_run import free_run, settle
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.sheet import FIELD_OF_PATH
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.simulated_rig import CONTROL_PERIOD, SimulatedRig


@pytest.fixture(scope="module")
def tools_python(repo_root):
    python = repo_root / ".venv/tools/bin/python"
    if not python.exists():
        pytest.skip("no FMPy here: scripts/tools.sh puts it into .venv/tools")
    return python


@pytest.fixture(scope="module")
def driven(repo_root):
    """A simulated rig after 40 s of the paper's cycle, with what it was told and what it measured; it lifts more than is declared."""
    duty = load_duty(repo_root / "ddh_twin_py/config/duty/paper_cycle.yaml")
    rig = SimulatedRig(load_rig().with_values({"load.payload_ratio": 1.1}), duty, 3)
    return rig, duty, collect(rig.run(40.0), 0)


@pytest.fixture(scope="module")
def fmu(driven, tmp_path_factory):
    return archive.write_fmu(tmp_path_factory.mktemp("fmu") / "rig.fmu", driven[0].rig)


def test_another_tool_gets_the_same_numbers(driven, fmu, tools_python, repo_root, tmp_path):
    rig, duty, recording = driven
    held = float(holding_pressure(duty.start_position, 0.0, rig.rig.parameters[0]))
    wanted = {
        "command": recording.drive.column("speed_command").tolist(), "step": CONTROL_PERIOD,
        "starts": {
            "start.temperature": duty.ambient[0], "start.rod_position": duty.start_position, "payload_mass": duty.payload,
            "start.pressure_piston_side": 0.8 * held, "ambient_temperature": duty.ambient[0],
            "solver.longest_interval": CONTROL_PERIOD / 4, "solver.hydraulic_step": 2.5e-4,  # as the simulated rig has them
        },
    }
    done = subprocess.run([tools_python, "-I", repo_root / "tests/exchange/run_fmu.py", fmu], input=json.dumps(wanted),
                          capture_output=True, text=True, env={**os.environ, "TMPDIR": str(tmp_path)})  # it leaves what it unpacks
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout[done.stdout.index('{"problems"'):])
    assert told["problems"] == []
    outputs = {name: np.array(values) for name, values in told["outputs"].items()}
    found = np.array([outputs[f"temperature.{node}"][-1] for node in NODES])
    np.testing.assert_allclose(found, rig.truth(), rtol=0.0, atol=1e-9)  # K; nothing of it is a measurement
    noise = {name: spec.noise for name, spec in rig.rig.sensors.items()}
    for name, stream, kind in (
        ("rod_position", recording.hydraulic, "rod_position"), ("rod_velocity", recording.hydraulic, "rod_velocity"),
        ("speed", recording.drive, "speed"),
    ):
        residual = stream.column(name) - outputs[name][1:]
        assert abs(residual.mean()) < 5.0 * noise[kind] / np.sqrt(residual.size), name
        assert residual.std() == pytest.approx(noise[kind], rel=0.1), name
    for name, value in zip(outputs, told["again"], strict=True):
        assert value == outputs[name][-1], name  # a state that was kept goes on in the same way
    assert told["errors"] == [
        "setting an output", "no payload", "degrees Celsius", "a leak that runs backwards", "a rod beyond its stroke",
        "a pressure beyond all", "a payload that falls below none", "another GUID",
    ]
    assert told["lifted"]["rising"] == told["lifted"]["middle"] != told["lifted"]["constant"]
    assert told["units"]["temperature.tank_oil"] == "K" and told["units"]["pressure_rod_side"] == "Pa"
    assert told["plain"]["time"] == pytest.approx(5.0) and told["plain"]["rod_velocity"] > 0.0


def test_what_is_inside(driven, fmu):
    with zipfile.ZipFile(fmu) as content:
        assert set(content.namelist()) == {
            "modelDescription.xml", "binaries/linux64/ddh_twin.so", "resources/rig.yaml", "documentation/index.html"}
        (rig_file,) = [content.read(name).decode() for name in content.namelist() if name.endswith(".yaml")]
        binary = content.read("binaries/linux64/ddh_twin.so")
    assert "rig_id" in rig_file and b"libpython" not in binary and len(binary) < 1_000_000


def names_within(function, seen):
    """All names that a kernel and those that it calls use, fields of the rig's record among them."""
    own = getattr(function, "py_func", function)
    if not isinstance(own, FunctionType) or own in seen:
        return set()
    seen.add(own)
    names, room = set(own.__code__.co_names), own.__globals__
    modules = [room[name] for name in names if isinstance(room.get(name), ModuleType)]
    called = [room[name] for name in names if name in room] + [getattr(m, name) for m in modules for name in names if hasattr(m, name)]
    return names.union(*(names_within(one, seen) for one in called))


def test_every_number_of_the_rig_file_that_the_free_run_reads_is_a_parameter():
    rig = load_rig()
    several = {variable.name: variable for variable in variables(rig)}
    read = names_within(free_run, set()) | names_within(settle, set())
    wanted = {path for path, field in FIELD_OF_PATH.items() if field in read} - {"load.payload_mass"}  # an input
    listed = {variable.name for variable in several.values() if variable.group == PARAMETER}
    assert listed == wanted and "motor.voltage_constant" in listed and "measurement.current_gain" not in listed
    assert several["pump_1.leakage"].start == rig["pump_1.leakage"] and several["payload_mass"].start == rig["load.payload_mass"]
    assert len({variable.reference for variable in several.values()}) == len(several) == len(variables(rig))
    assert all(variable.about for variable in several.values())
    bounded = [variable for variable in several.values() if variable.lowest is not None]
    assert {variable.name for variable in bounded} == listed
    assert all(variable.lowest <= variable.start <= variable.highest for variable in bounded)


def test_temperatures_are_shown_in_degC_and_their_differences_in_K():
    listed = ElementTree.fromstring(archive.model_description(load_rig(), variables(load_rig()), "{0}")).iter("ScalarVariable")
    shown = {variable.get("name"): real.get("displayUnit") for variable in listed for real in variable if real.get("unit") == "K"}
    differences = {name for name, unit in shown.items() if unit is None}
    assert differences == {"surroundings.enclosure_rise"} and set(shown.values()) == {"degC", None}


def test_the_verb(tmp_path, capsys, monkeypatch):
    assert main(["fmu", str(tmp_path / "x.zip")]) == 2
    assert "the name of an FMU ends in .fmu" in capsys.readouterr().err
    assert main(["fmu", str(tmp_path / "a.fmu"), "--json", "-", "--quiet"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["variables"][0] == asdict(variables(load_rig())[0]) and (tmp_path / "a.fmu").stat().st_size > 10_000
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    assert main(["fmu", str(tmp_path / "b.fmu"), "--quiet"]) == 2
    assert "needs a C compiler" in capsys.readouterr().err and not (tmp_path / "b.fmu").exists()


def test_a_compiler_that_fails_is_quoted(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", f"{sys.executable} -c raise\tSystemExit('no-such-thing:\terror')")
    with pytest.raises(ExchangeError, match="the FMU's binary cannot be made"):
        archive.write_fmu(tmp_path / "a.fmu", load_rig())
