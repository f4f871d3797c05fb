"""A diagnosis in its own process: answer, progress, stop, crash, refusal, and no process that is left behind."""

import io
import json
import os
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

import pytest
from ddh_twin_py.bags.case import case_of
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.diagnosis import child, of_bags
from ddh_twin_py.diagnosis.process import DiagnosisProcess
from ddh_twin_py.physics.compiling import COMPILING
from numba.core import event

FAKE = (sys.executable, str(Path(__file__).parents[1] / "support" / "fake_diagnosis.py"))


def begun(tmp_path, name):
    path = tmp_path / name
    path.mkdir()
    return DiagnosisProcess(case_of([path]), command=FAKE)


def until(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_report_comes_back_with_what_was_asked(tmp_path):
    for part in ("field", "validation"):
        (tmp_path / "case" / part).mkdir(parents=True)
    process = DiagnosisProcess(case_of([tmp_path / "case"]), nice=3, command=FAKE, without=["load.mass"])
    outcome = process.wait(20.0)
    assert not outcome.error and outcome.sentence.startswith("Pump 1") and outcome.report["verdict"] == "explained"
    case = tmp_path / "case"
    assert outcome.report["asked"] == {
        "field": [str(case / "field")], "nice": 3, "commissioning": None, "validation": str(case / "validation"), "rig": None,
        "without": ["load.mass"], "only": None, "engine": "",
    }  # fmt: skip
    assert (process.done, process.stage) == (1.0, "done")


@pytest.mark.parametrize(("longest", "ends"), [(1.5, True), (0.3, False)])
def test_what_compiling_takes_is_not_waited_for(longest, ends, tmp_path):
    """Of a diagnosis that takes 1 s, and 2 s more in which it compiles."""
    code = ("import json, sys, time\nsys.stdin.readline()\n"
            f"for stage, seconds in (('reading', 0.5), ({COMPILING!r}, 2.0), ('fitting', 0.5)):\n"
            "    print(json.dumps({'done': 0.1, 'stage': stage}), flush=True)\n    time.sleep(seconds)\n"
            "print(json.dumps({'error': 'done'}))")
    process = DiagnosisProcess(case_of([tmp_path]), command=(sys.executable, "-S", "-c", code))
    outcome = process.wait(longest)
    process.stop()
    assert (outcome is not None and outcome.error == "done") is ends


def test_a_stop_that_is_asked_for_ends_the_waiting(tmp_path):
    process, asked = begun(tmp_path, "slow"), threading.Event()
    assert process.wait(60.0, lambda done, stage: asked.set(), asked) is None and process.outcome is None
    process.stop()


def test_progress_is_told_and_a_stop_ends_the_process(tmp_path):
    process = begun(tmp_path, "slow")
    until(lambda: process.done == 0.5)
    assert process.stage == "fitting" and process.outcome is None and process.wait(0.0) is None
    told = []
    assert process.wait(0.5, lambda *far: told.append(far)) is None and told == [(0.5, "fitting")] * 2
    process.stop()
    assert process.outcome.error == "the diagnosis was stopped"
    with pytest.raises(ProcessLookupError):
        os.kill(process.pid, 0)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("crash", "ended with signal SIGKILL and no report"),
        ("fault", "ended with exit code 1 and no report: RuntimeError: a fault of ours"),
        ("bad", "bad: drive/telemetry: no message"),
    ],
)
def test_what_went_wrong_is_one_line(tmp_path, name, words):
    outcome = begun(tmp_path, name).wait(20.0)
    assert words in outcome.error and "\n" not in outcome.error and not outcome.report


@pytest.mark.parametrize(("line", "words"), [
    ("5", "e"), ("[1]", "e"), ('{"report": 3}', "e"),
    ('{"done": "soon"}', "the diagnosis answered what cannot be read"), ('{"done": null}', "the diagnosis answered what cannot be read"),
])  # fmt: skip
def test_a_line_that_nobody_understands_hangs_nothing(tmp_path, line, words):
    command = "sh", "-c", f"echo '{line}'; echo '{{\"error\": \"e\"}}'"
    process = DiagnosisProcess(case_of([tmp_path]), command=command)
    outcome = process.wait(20.0)
    assert outcome is not None and outcome.error == words
    own = process._process
    assert own.poll() is not None and own.stdin.closed and own.stdout.closed, "nothing of it stays"


def test_a_stop_ends_what_outlives_the_process_that_started_it(tmp_path):
    process = DiagnosisProcess(case_of([tmp_path]), command=("sh", "-c", "(trap '' TERM; echo '{\"done\": 0.5}'; sleep 60) & wait"))
    until(lambda: process.done == 0.5)
    process.stop()
    assert process.outcome is not None, "its end of the pipe is closed once it is gone"
    assert process.outcome.error == "the diagnosis was stopped"


def test_a_command_that_cannot_be_started(tmp_path):
    process = DiagnosisProcess(case_of([tmp_path]), command=("/nowhere/python",))
    assert "/nowhere/python: cannot be started" in process.wait(1.0).error
    process.stop()


def test_no_process_outlives_a_parent_that_is_killed(tmp_path):
    (tmp_path / "slow").mkdir()
    code = (
        "import sys, time; from ddh_twin_py.bags.case import case_of; from ddh_twin_py.diagnosis.process import *\n"
        f"p = DiagnosisProcess(case_of([{str(tmp_path / 'slow')!r}]), command={FAKE!r})\n"
        "while p.done < 0.5: time.sleep(0.01)\n"
        "print(p.pid, flush=True); time.sleep(60)"
    )
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    pid = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    parent.stdout.close()

    def gone():
        try:
            return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
        except FileNotFoundError:
            return True

    until(gone)


def test_blas_has_one_thread_unless_told_otherwise_and_the_code_is_this_one(tmp_path, monkeypatch):
    code = ("import json, os, ddh_twin_py; e = os.environ; "
            "print(json.dumps({'report': {'threads': e['OPENBLAS_NUM_THREADS'], 'code': os.path.realpath(ddh_twin_py.__file__)}}))")
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    monkeypatch.setenv("PYTHONPATH", "/nowhere")
    report = DiagnosisProcess(case_of([tmp_path]), command=(sys.executable, "-c", code)).wait(20.0).report
    assert report == {"threads": "1", "code": os.path.realpath(child.__file__).replace("diagnosis/child", "__init__")}
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    assert DiagnosisProcess(case_of([tmp_path]), command=(sys.executable, "-c", code)).wait(20.0).report["threads"] == "3"


def run_main(monkeypatch, request, engine, **more):
    """The process's own main with an engine in place of the real one; exit code and what it told."""
    module = types.ModuleType("made_engine")
    module.diagnose = engine
    vars(module).update(more)
    monkeypatch.setitem(sys.modules, "made_engine", module)
    monkeypatch.setattr(child, "_end_with_input", lambda: None)
    request = {**request, "engine": "made_engine:diagnose"}
    monkeypatch.setattr(sys, "stdin", io.StringIO(json.dumps(request) + "\n"))
    read, write = os.pipe()
    kept = os.dup(1)
    os.dup2(write, 1)
    os.close(write)
    try:
        code = child.main()
    finally:
        os.dup2(kept, 1)
        os.close(kept)
    with os.fdopen(read) as told:
        return code, [json.loads(line) for line in told]


def test_the_process_calls_the_engine_and_tells_progress_and_report(monkeypatch, tmp_path):
    calls = []

    def engine(field, commissioning, validation, rig, without, only, progress):
        calls.append((field, commissioning, validation, rig["motor.torque_constant"], without, only))
        progress(0.5)
        progress(0.75, "weighing")
        return types.SimpleNamespace(report={"verdict": "no_gap"}, sentence="No gap.")

    for name in ("old", "new"):
        (tmp_path / name).mkdir()
    asked = {"field": [str(tmp_path / "old")], "commissioning": str(tmp_path / "new"), "without": ["load.mass"], "only": None}
    code, told = run_main(monkeypatch, asked, engine)
    assert code == 0 and calls == [((tmp_path / "old",), tmp_path / "new", None, 1.6, ("load.mass",), None)]
    assert told[:2] == [{"done": 0.5, "stage": ""}, {"done": 0.75, "stage": "weighing"}]
    assert told[2].pop("seconds") >= 0.0 and told[2].pop("megabytes") > 1.0
    assert told[2:] == [{"report": {"verdict": "no_gap"}, "sentence": "No gap."}]
    _, told = run_main(monkeypatch, asked, engine, stage_of=of_bags.stage_of)
    assert [t["stage"] for t in told[:2]] == ["weighing effects", "weighing"]


def test_the_process_tells_while_it_compiles(monkeypatch, tmp_path):
    def engine(*given, progress, **more):
        for share in (None, 0.25):
            if share is not None:
                progress(share, "weighing")
            with event.trigger_event("numba:compile"):
                pass
        raise BagError("enough")

    (tmp_path / "old").mkdir()
    _, told = run_main(monkeypatch, {"field": [str(tmp_path / "old")]}, engine)
    assert [(t["done"], t["stage"]) for t in told[:-1]] == [
        (0.0, COMPILING), (0.0, "reading"), (0.25, "weighing"), (0.25, COMPILING), (0.25, "weighing")]


def test_stages_follow_the_share_of_the_work():
    stages = [of_bags.stage_of(done) for done in (0.0, 0.09, 0.1, 0.74, 0.75, 0.99, 1.0)]
    assert stages == ["fitting the rig"] * 2 + ["weighing effects"] * 2 + ["sizing the gap"] * 2 + ["done"]


def test_the_process_tells_an_input_that_cannot_be_used_and_not_a_fault(monkeypatch, tmp_path):
    def refusing(*_, **__):
        raise BagError("field.mcap:\n drive/telemetry is empty")

    assert run_main(monkeypatch, {"field": [str(tmp_path)]}, refusing) == (
        2, [{"error": "field.mcap: drive/telemetry is empty", "passing": False}])

    def full(*_, **__):
        raise OSError(28, "No space left on device", "/tmp/x")

    assert run_main(monkeypatch, {"field": [str(tmp_path)]}, full)[1] == [{"error": "/tmp/x: No space left on device", "passing": True}]

    def faulty(*_, **__):
        raise ValueError("shapes do not fit")

    with pytest.raises(ValueError, match="shapes"):
        run_main(monkeypatch, {"field": [str(tmp_path)]}, faulty)
