"""What every node answers, whatever it does."""

import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import pytest
from ddh_twin_py.nodes.base.node_base import TwinNode, run
from ddh_twin_py.nodes.drive_telemetry import DriveTelemetryNode
from ddh_twin_py.nodes.gap_monitor import GapMonitorNode
from nodes.processes import NodeProcess, executable, wait_for


@pytest.mark.parametrize("node, parameter", [(GapMonitorNode, "false_alarm_hours"), (DriveTelemetryNode, "")])
@pytest.mark.parametrize("asked", ["--help", "-h"])
def test_help_is_told_and_no_node_starts(node, parameter, asked, capsys):
    assert run(node, [asked]) == 0
    told = capsys.readouterr().out
    assert told.startswith("Node: ") and "usage: ros2 run ddh_twin_py" in told and parameter in told


def test_what_comes_again_is_said_again_but_not_each_time():
    said = []
    node = SimpleNamespace(_met={}, wall=lambda: at, get_logger=lambda: SimpleNamespace(warning=said.append))
    for at in (0.0, 30.0, 50.0, 61.0, 200.0):
        TwinNode.warn_again(node, "jump", f"jumped at {at:g} s")
    TwinNode.warn_again(node, "pause", "paused")
    assert said == ["jumped at 0 s", "jumped at 61 s (and 2 times since this was last said)", "jumped at 200 s", "paused"]


@pytest.mark.live
@pytest.mark.parametrize(("node", "topics"), [
    ("temperature_fusion", "hydraulics/state, motor/thermal_state"),
    ("gap_monitor", "hydraulics/residuals, temperature/estimates, temperature/residuals"),
])  # fmt: skip
def test_a_node_says_that_it_is_ready_and_what_it_waits_for(node, topics):
    with NodeProcess(node, "/crane_1") as process:
        wait_for(lambda: f"ready in /crane_1 with the reference sheet, waiting for {topics}\n" in process.text, 90.0, node)


@pytest.mark.live
def test_a_node_says_which_rig_sheet_it_uses(tmp_path):
    sheet = tmp_path / "crane_1.yaml"
    sheet.write_text("rig_id: crane_1\n")
    with NodeProcess("gap_monitor", "/crane_1", rig=str(sheet)) as process:
        assert f"ready in /crane_1 with rig sheet {sheet}, waiting for " in process.says("ready in", 90.0)


@pytest.mark.parametrize("name", [path.name for path in Path(executable("gap_monitor")).parent.iterdir() if path.name != "ddh-twin"])
@pytest.mark.parametrize("given", [["crane_1.yaml"], ["-p", "rig:=crane_1.yaml", "--ros-args", "-r", "__ns:=/crane_1"]])
def test_an_argument_that_is_none_of_ros_is_refused(name, given, capsys, monkeypatch):
    monkeypatch.setattr("ddh_twin_py.nodes.base.node_base._Stop", SimpleNamespace)  # the signals stay those of pytest
    main = import_module(f"ddh_twin_py.nodes.{name}").main
    assert main(given) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"error: {name} takes no argument '{given[0]}'") and "--ros-args -p" in told and told.count("\n") == 1


@pytest.mark.live
def test_a_stray_argument_of_the_command_line_ends_a_node():
    done = subprocess.run([executable("hydraulic_model"), "crane_1.yaml"], capture_output=True, text=True, timeout=90.0)
    assert done.returncode == 2 and done.stderr.startswith("error: hydraulic_model takes no argument 'crane_1.yaml'")


FAILING = """
import sys
from ddh_twin_py.nodes.base.node_base import TwinNode, run


class Failing(TwinNode):
    def __init__(self):
        super().__init__("failing")
        self.every(0.01, self._fail)

    def _fail(self):
        raise ValueError("cannot go on")

    def close(self):
        print("kept what it has", flush=True)
        raise OSError("disk full")


run(Failing)
"""


@pytest.mark.live
def test_a_node_that_fails_keeps_what_it_has():
    done = subprocess.run([sys.executable, "-c", FAILING], capture_output=True, text=True, timeout=90.0)
    assert done.returncode == 1 and done.stdout.count("kept what it has") == 1
    assert "not all could be kept at the end: disk full" in done.stdout + done.stderr
    assert done.stderr.rstrip().endswith("ValueError: cannot go on")
