"""`ddh-twin view` as a process: beside a machine, and of a recording that it plays."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import urllib.request

import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.cli.main import main
from ddh_twin_py.cli.page_port import refuse_taken
from nodes.processes import HeldProcess, runs, wait_for


class View(HeldProcess):
    def __init__(self, folder, *arguments, before=None):
        self._out = folder / "out"
        with self._out.open("w") as out:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "ddh_twin_py.cli.main", "view", "--port", "0", "--no-browser", "--log", str(folder / "log"),
                 *arguments],
                stdout=subprocess.PIPE, stderr=out, text=True, env=os.environ, preexec_fn=before,
            )  # fmt: skip
        line = self.process.stdout.readline()
        self.page = (re.search(r"page: (http://\S+)", line) or pytest.fail(f"{line!r} {self._out.read_text()}"))[1]

    def state(self):
        with urllib.request.urlopen(f"{self.page}state", timeout=10.0) as answer:
            return json.load(answer)

    def nodes(self):
        with open(f"/proc/{self.process.pid}/task/{self.process.pid}/children") as file:
            return [int(pid) for pid in file.read().split()]

    def stop(self, number=signal.SIGINT):
        nodes = self.nodes()
        self.process.send_signal(number)
        code = self.process.wait(30.0)
        assert not any(runs(pid) for pid in nodes)
        return code


@pytest.mark.live
def test_a_recording_is_played_to_its_end_and_again(paper_cycle_bag, tmp_path):
    bag = write_recording(tmp_path / "bag", read_recording(paper_cycle_bag).between(0.0, 8.0))
    with View(tmp_path, str(bag), "--rate", "4") as view:
        wait_for(lambda: (p := view.state().get("player")) and p["ended"], 120.0, "the end of the recording")
        told = view.state()
        assert told["player"]["rate"] == 4.0 and told["rig"]["rig_id"] == "rig_000"
        assert told["values"]["drive.speed"] is not None and told["values"]["estimate.tank_oil.temperature"] is not None
        assert view.process.poll() is None and len(view.nodes()) == 6  # it stays, for another look
        assert view.stop() == 0
    assert "Traceback" not in (tmp_path / "log").read_text()


@pytest.mark.live
def test_beside_a_machine_the_page_alone_is_started(tmp_path):
    with View(tmp_path, "--namespace", "rig_9", "--json", str(tmp_path / "page.json")) as view:
        told = wait_for(lambda: (s := view.state()).get("sensors") and s, 20.0, "sensors")
        assert told["page"]["namespace"] == "/rig_9" and {row["state"] for row in told["sensors"]} == {"absent"}
        assert len(view.nodes()) == 1
        written = json.loads((tmp_path / "page.json").read_text())
        assert (written["page"], written["namespace"], written["recording"]) == (view.page, "/rig_9", None)
        assert view.stop(signal.SIGTERM) == 128 + signal.SIGTERM


def _as_a_job_of_a_script():
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@pytest.mark.live
def test_it_hears_of_an_interruption_that_its_shell_ignores(tmp_path):
    with View(tmp_path, "--namespace", "rig_9", before=_as_a_job_of_a_script) as view:
        assert view.stop(signal.SIGINT) == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["/nowhere"], "view: error: /nowhere does not exist; a bag is a rosbag2 folder"),
        (["--rate", "2"], "--rate is for a recording, and none is named"),
        (["--rate", "0"], "--rate is for a recording, and none is named"),
        (["--paused"], "--paused is for a recording"),
        (["--rig", "/nowhere"], "--rig: there is no /nowhere"),
        (["--port", "70000"], "'70000' is no whole number from 0 to 65535"),
        (["--port", "http"], "'http' is no whole number from 0"),
        (["--namespace", "/7rig"], "--namespace is '/7rig'"),
        (["BAG", "--rate", "fast"], "'fast' is no number"),
    ],
)
def test_arguments_that_cannot_be_used(arguments, words, capsys, paper_cycle_bag):
    try:
        code = main(["view", *(str(paper_cycle_bag) if a == "BAG" else a for a in arguments)])
    except SystemExit as error:
        code = error.code
    assert code == 2
    assert words in capsys.readouterr().err


def test_a_port_that_is_taken_is_said_in_one_line_before_any_node_starts(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("ddh_twin_py.cli.live_graph.LiveGraph.start", lambda *_: pytest.fail("a node is started"))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["view", "--port", str(port), "--no-browser", "--log", str(tmp_path / "log")]) == 2
    said = f"ddh-twin view: error: --port {port}: the address is in use; choose another, or 0 for any free one\n"
    assert capsys.readouterr().err == said


def test_a_port_that_is_free_or_that_the_system_chooses_is_not_refused():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        refuse_taken("127.0.0.1", 0, "", "")
    for host in ("127.0.0.1", "localhost", "0.0.0.0", "no such host.", "192.0.2.1"):
        refuse_taken(host, port, "", "")
