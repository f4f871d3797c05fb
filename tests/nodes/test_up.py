"""`ddh-twin up` as a process, with its nodes."""

import json
import os
import signal
import socket
import subprocess
import sys

import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.cli.twin_nodes import TWIN
from nodes.processes import HeldProcess, runs, wait_for

pytestmark = pytest.mark.live


class Up(HeldProcess):
    """`ddh-twin up` with a log."""

    def __init__(self, log, *arguments):
        self._log = log
        self.process = subprocess.Popen(
            [sys.executable, "-m", "ddh_twin_py.cli.main", "up", "--log", str(log), "--quiet", *map(str, arguments)],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=os.environ,
        )

    @property
    def text(self):
        return self._log.read_text() if self._log.exists() else ""

    def says(self, words, seconds=60.0):
        def said():
            assert words in self.text or self.process.poll() is None, self.text
            return words in self.text

        wait_for(said, seconds, f"up says {words!r}")

    def nodes(self):
        """Process ids of the nodes by name."""
        with open(f"/proc/{self.process.pid}/task/{self.process.pid}/children") as file:
            children = [int(pid) for pid in file.read().split()]
        names = {}
        for pid in children:
            with open(f"/proc/{pid}/cmdline") as file:
                arguments = file.read().split("\0")
            names |= {argument.rpartition("/")[2]: pid for argument in arguments if "/lib/ddh_twin_py/" in argument}
        return names


def test_a_crashed_node_is_started_again_and_ctrl_c_stops_all(short_bag, tmp_path):
    with Up(tmp_path / "log", "--source", "bag", "--bag", short_bag, "--namespace", "site/rig_b", "--loop") as up:
        up.says("bag_player         | INFO playing at 1 times real time; waiting for /site/rig_b/gap_monitor, /site/rig_b/hydraulic_model")
        nodes = up.nodes()
        assert set(nodes) == {"hydraulic_model", "machine_thermal", "temperature_fusion", "gap_monitor", "bag_player"}
        os.kill(nodes["machine_thermal"], signal.SIGKILL)
        up.says("machine_thermal ended (signal SIGKILL)")
        up.says("starting it again in 1 s")
        up.says("machine_thermal started again (restart 1)")
        # and hears the rig, which was told before it was born
        wait_for(lambda: up.text.count("machine_thermal    | INFO rig rig_000") == 2, 20.0, "the rig, again")
        nodes = up.nodes()
        up.process.send_signal(signal.SIGINT)
        assert up.process.wait(20.0) == 0, up.text
    assert not any(runs(pid) for pid in nodes.values())
    assert "Traceback" not in up.text and "did not stop" not in up.text


def test_the_end_of_the_bag_is_the_end(short_bag, tmp_path):
    with Up(tmp_path / "log", "--source", "bag", "--bag", short_bag, "--rate", 0, "--record", tmp_path / "out", "--state-file",
            tmp_path / "state", "--json", tmp_path / "ran.json") as up:  # fmt: skip
        assert up.process.wait(60.0) == 0, up.text
    assert "the source has come to its end, stopping" in up.text
    recording = read_recording(tmp_path / "out")
    assert len(recording.drive) == 2001 and len(recording.temperatures) == 10
    assert (tmp_path / "state").stat().st_size > 1000
    ran = json.loads((tmp_path / "ran.json").read_text())
    assert ran["exit_code"] == 0 and ran["files"]["record"] == str(tmp_path / "out")
    assert ran["files"]["records"] == [str(tmp_path / "out")]
    assert {node["name"] for node in ran["nodes"]} == {*TWIN, "bag_recorder", "bag_player"}


def test_no_node_outlives_a_twin_that_is_killed(tmp_path):
    with Up(tmp_path / "log", "--source", "simulation", "--duty", "mixed") as up:
        up.says("rig simulated_1")
        nodes = up.nodes()
        assert {"drive_telemetry", "pressure_telemetry"} <= set(nodes) and len(nodes) == 6
        up.process.kill()
        up.process.wait()
        wait_for(lambda: not any(runs(pid) for pid in nodes.values()), 30.0, "the end of all nodes")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--source", "bag"], "--source bag needs --bag"),
        (["--source", "simulation", "--duty", "nowhere.yaml"], "--duty: there is no nowhere.yaml"),
        (["--bag", "x"], "--bag was given, but --source is none"),
        (["--source", "bag", "--bag", "/nowhere"], "there is no /nowhere"),
        (["--rig", "/nowhere"], "--rig: there is no /nowhere"),
        (["--state-file", "/dev/full"], "argument --state-file: '/dev/full' is no regular file"),
        (["--normal-file", "/tmp"], "argument --normal-file: '/tmp' is a folder and no file"),
        (["--record", "/tmp"], "argument --record: '/tmp' exists; nothing is overwritten"),
        (["--record", "/dev/null/x"], "argument --record: '/dev/null/x' cannot be written: /dev/null is no folder"),
        (["--log", "/tmp"], "argument --log: '/tmp' is a folder and no file"),
        (["--log", "/proc/x/log"], "argument --log: '/proc/x/log' cannot be written: /proc: "),
        (["--log", "x", "--state-file", "./x"], "--state-file and --log both write to 'x'"),
        (["--rate", "fast"], "'fast' is no number"),
        (["--params", ""], "argument --params: an empty name"),
        (["--source", "bag", "--bag", __file__], f"{__file__} is no bag: its name ends in '.py'"),
        (["--source", "simulation", "--duty", __file__], f"{__file__}: is not YAML (line"),
        (["--namespace", "/bad ns!"], "--namespace is '/bad ns!'; allowed are names of letters"),
        (["--namespace", "/rig//b"], "--namespace is '/rig//b'"),
        (["--namespace", "/7rig"], "--namespace is '/7rig'"),
        (["--namespace", "/rig\n"], "--namespace is '/rig\\n'"),
        (["--namespace", "x" * 400], "--namespace has 401 characters"),
    ],
)
def test_arguments_that_cannot_be_used(arguments, words, capsys):
    from ddh_twin_py.cli.main import main

    try:
        code = main(["up", *arguments])
    except SystemExit as error:
        code = error.code
    assert code == 2
    assert words in capsys.readouterr().err


def test_a_page_whose_port_is_taken_is_refused_before_any_node_starts(tmp_path, monkeypatch, capsys):
    from ddh_twin_py.cli.main import main

    monkeypatch.setattr("ddh_twin_py.cli.supervisor.Supervisor.run", lambda _: pytest.fail("a node is started"))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        params = tmp_path / "twin.yaml"
        params.write_text(f"/**/web_view:\n  ros__parameters:\n    port: {port}\n")
        assert main(["up", "--view", "--params", str(params)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert f"--view: port {port}: the address is in use; end what is served there" in line
        monkeypatch.setattr("ddh_twin_py.web.access.PORT", port)
        assert main(["up", "--view"]) == 2 and f"--view: port {port}: " in capsys.readouterr().err
