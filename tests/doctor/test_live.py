"""The doctor beside a simulated machine, through the middleware."""

import json

import pytest
from ddh_twin_py.cli.main import main
from diagnostic_msgs.msg import DiagnosticArray
from nodes.processes import Listener, NodeProcess, wait_for

pytestmark = pytest.mark.live


def test_beside_a_machine(repo_root, capsys):
    duty = str(repo_root / "ddh_twin_py/config/duty/mixed.yaml")
    options = {"source": "simulation", "simulation__duty": duty}
    with NodeProcess("drive_telemetry", "/press", **options), NodeProcess("pressure_telemetry", "/press", **options):
        wait_for(lambda: main(["doctor", "--seconds", "1", "--machine", "--quiet"]) == 0, 90.0, "the machine is there")
        capsys.readouterr()
        code = main(["doctor", "--json", "-", "--seconds", "6", "--machine", "--quiet"])
    told = json.loads(capsys.readouterr().out)
    checks = {(check["group"], check["name"]): check for check in told["checks"]}
    assert code == 0, [check for check in told["checks"] if check["level"] == "error"]
    assert checks["middleware", "between processes"]["level"] in ("ok", "warning")
    for topic in ("drive/telemetry", "hydraulics/telemetry", "temperature/tank_oil"):
        assert checks["machine", f"/press/{topic}"]["level"] == "ok", checks["machine", f"/press/{topic}"]
    assert checks["machine", "/press/rig"]["found"].startswith("simulated_1")
    assert checks["twin", "/press/"]["found"] == "no node of the twin runs"


def test_without_a_machine(capsys):
    assert main(["doctor", "--json", "-", "--seconds", "1", "--quiet"]) == 0
    assert main(["doctor", "--seconds", "1", "--quiet", "--machine"]) == 1
    assert "nobody publishes drive/telemetry" in capsys.readouterr().out


def test_diagnostics_that_are_cut_off_are_left_out(capsys):
    listener = Listener()
    publisher = listener.node.create_publisher(DiagnosticArray, "/diagnostics", 10)
    timer = listener.node.create_timer(0.1, lambda: publisher.publish(b"\0\1\0\0\1\0"))
    try:
        main(["doctor", "--json", "-", "--seconds", "2", "--quiet"])
    finally:
        listener.here(timer.cancel)
        listener.close()
    told, said = capsys.readouterr()
    names = {check["name"] for check in json.loads(told)["checks"] if check["group"] == "middleware"}
    assert "between processes" in names and "start" not in names, told + said
