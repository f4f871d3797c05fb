"""`make clean` removes what make itself made, and nothing that people keep in out."""

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.skipif(shutil.which("make") is None, reason="no make here")
def test_recordings_states_and_reports_of_people_stay(tmp_path):
    shutil.copy(ROOT / "Makefile", tmp_path)
    kept = ["out/recordings/twin/twin.mcap", "out/crane_1.npz", "out/fleet/results/x.json", "out/bench/cases/x", ".venv/x", "bags/x"]
    made = ["out/logs/x.log", "out/site/index.html", "out/doctrees/x", "out/demo/report.html", "out/bench.json", "ros2_ws/build/x",
            "ddh_twin_py/__pycache__/x", "tests/__pycache__/x", ".ruff_cache/x"]
    for name in kept + made:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    subprocess.run(["make", "-C", str(tmp_path), "clean"], check=True, capture_output=True)
    assert [name for name in kept + made if (tmp_path / name).exists()] == kept
    shutil.rmtree(tmp_path / "out")
    (tmp_path / "out/logs").mkdir(parents=True)
    subprocess.run(["make", "-C", str(tmp_path), "clean"], check=True, capture_output=True)
    assert not (tmp_path / "out").exists(), "empty"
