"""The doctor beside a simulated machine, through the middleware."""

import json

import pytest
from ddh_twin_py.cli.main import main
from nodes.processes import NodeProcess, wait_for

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
