"""The command line: help that costs nothing, errors in one line, exit codes."""

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from dataclasses import replace
from importlib import import_module

import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.cli import main as cli
from ddh_twin_py.cli.main import main
from ddh_twin_py.rig.files import write_whole

VERBS = ("replay", "calibrate", "info", "simulate", "bench", "verify", "demo", "up", "motor", "paper", "study", "gap",
         "gap-design", "fleet", "gap-bench", "real", "export", "import", "doctor", "fmu", "layouts", "view", "completion")


def failure(capsys, *argv: str) -> str:
    """The one line of a run that must leave with 2."""
    try:
        code = main(list(argv))
    except SystemExit as leaving:
        code = leaving.code
    assert code == 2
    lines = capsys.readouterr().err.splitlines()
    said = [line for line in lines if not line.startswith(("loading", "reading", "running"))]
    assert len(said) == 1 and "error: " in said[0], said
    return said[0]


@pytest.mark.parametrize("argv", [["--help"], *([verb, "--help"] for verb in VERBS)])
def test_help_imports_nothing_heavy(argv):
    code = (
        "import sys\nfrom ddh_twin_py.cli.main import main\n"
        f"try: main({argv!r})\nexcept SystemExit as leaving: assert leaving.code == 0\n"
        "heavy = {'numpy', 'numba', 'scipy', 'rclpy', 'rosbags', 'rich', 'yaml'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "example" in done.stdout
    if len(argv) == 1:
        assert all(f"\n    {verb} " in done.stdout.replace("\n              ", " ") for verb in VERBS)
        assert "exit codes: 0" in done.stdout
    else:
        assert f"  ddh-twin {argv[0]}" in done.stdout  # an example that can be copied


def test_unknown_verb_names_the_nearest(capsys):
    assert "no verb 'reply'; the nearest is 'replay'" in failure(capsys, "reply")


def test_unknown_option_names_the_nearest(capsys):
    assert "no option '--htlm'; the nearest is '--html'" in failure(capsys, "replay", "bag", "--htlm=x")
    assert "no option '--sed'; the nearest is '--seed'" in failure(capsys, "simulate", "d", "-o", "x", "--sed", "3")
    assert "no option '--verson'; the nearest is '--version'" in failure(capsys, "--verson")


def test_what_is_missing_or_too_much(capsys):
    assert "BAG" in failure(capsys, "replay")
    assert "'b' is one too many" in failure(capsys, "info", "a", "b")
    assert "'-1' is no number above 0" in failure(capsys, "fleet", "bags", "--longest=-1")


@pytest.mark.parametrize("verb", ["replay", "export"])
@pytest.mark.parametrize("tick", ["-1", "0.009", "0.21", "1", "1e9", "nan"])
def test_a_tick_with_which_the_twin_would_be_wrong_is_refused(capsys, verb, tick):
    said = failure(capsys, verb, "bag", f"--interval={tick}")
    assert f"argument --interval: '{tick}' is no number from 0.01 to 0.2 s" in said


def test_a_bag_that_is_none(capsys, tmp_path):
    said = failure(capsys, "replay", str(tmp_path / "nowhere"))
    assert said.startswith("ddh-twin replay: error: ") and "nowhere does not exist" in said
    assert "is no bag" in failure(capsys, "info", str(tmp_path))


def test_a_rig_file_with_a_typing_error(capsys, tmp_path, paper_cycle_bag):
    rig = tmp_path / "rig.yaml"
    rig.write_text("pump_1:\n  leakeage: {value: 1.0e-12}\n")
    said = failure(capsys, "replay", str(paper_cycle_bag), "--rig", str(rig))
    assert str(rig) in said and "pump_1.leakage" in said


@pytest.mark.parametrize("option, expected", [
    ("--seeds=0", "argument --seeds: '0' is no whole number from 1 to 10000"),
    ("--seeds=10001", "argument --seeds: '10001' is no whole number"),
    ("--first=-1", "argument --first: '-1' is no whole number from 0 to 1000000000"),
    ("--duration=59", "argument --duration: '59' is no number from 60 to 86400 s"),
    ("--duration=1e9", "argument --duration: '1e9' is no number from 60 to 86400 s"),
    ("--duration=nan", "argument --duration: 'nan' is no number"),
])
def test_numbers_that_a_verification_cannot_use(capsys, option, expected):
    assert expected in failure(capsys, "verify", option)


def test_an_unknown_duty_names_the_nearest(capsys, tmp_path):
    assert "the nearest is 'paper_cycle'" in failure(capsys, "simulate", "papercycle", "-o", str(tmp_path / "b"))
    assert "--duration" in failure(capsys, "simulate", "paper_cycle", "-o", str(tmp_path / "b"))
    there = failure(capsys, "simulate", "paper_cycle", "-o", str(tmp_path), "--duration", "1")
    assert "nothing is overwritten" in there


@pytest.mark.parametrize("option, expected", [
    ("--seed=-1", "argument --seed: '-1' is no whole number from 0 on"),
    ("--seed=x", "argument --seed: 'x' is no whole number"),
    ("--duration=0", "argument --duration: '0' is no number from 0.05 to 86400 s"),
    ("--duration=-5", "argument --duration: '-5' is no number from 0.05 to 86400 s"),
    ("--duration=1e12", "argument --duration: '1e12' is no number from 0.05 to 86400 s"),
    (f"--seed={'9' * 5000}", f"argument --seed: '{'9' * 40}' is no whole number from 0 on of at most 18 digits"),
    ("--noise-seed=-1", "argument --noise-seed: '-1' is no whole number"),
    ("--begin=monday", "argument --begin: 'monday' is no moment such as 2026-05-01T08:00:00Z"),
    ("--begin=2039-01-01", "argument --begin: '2039-01-01' is beyond what a stamp can say"),
])
def test_numbers_that_a_simulation_cannot_use(capsys, tmp_path, option, expected):
    assert expected in failure(capsys, "simulate", "paper_cycle", "-o", str(tmp_path / "b"), option)


def test_a_file_that_cannot_be_written(capsys, paper_cycle_bag, tmp_path):
    target = tmp_path / "file"
    target.write_text("")
    said = failure(capsys, "info", str(paper_cycle_bag), "--json", str(target / "x.json"))
    assert f"argument --json: '{target}/x.json' cannot be written: {target} is no folder" in said


@pytest.mark.parametrize("verb, option", [
    *((verb, "--json") for verb in ("study", "paper", "calibrate", "motor", "verify", "bench", "gap")),
    *((verb, "--html") for verb in ("study", "paper", "calibrate", "motor", "gap")),
    ("study", "--csv"), ("calibrate", "-o"), ("motor", "-o"), ("gap", "-o"),
])
def test_an_output_that_is_a_folder_is_refused_before_the_run(capsys, tmp_path, verb, option):
    more = {"study": ["cold-start"], "calibrate": ["bag"], "gap": ["bag"]}.get(verb, [])
    said = failure(capsys, verb, *more, option, str(tmp_path))
    assert f"{option}" in said and f"'{tmp_path}' is a folder and no file" in said


def test_other_outputs_that_cannot_be_written(capsys, tmp_path):
    for name, expected in (
        (f"{tmp_path}/new/", "is a folder"), ("/dev/null", "is no regular file"), ("/proc/x/y.json", "cannot be written: /proc: "),
        (str(tmp_path / ("x" * 252)), "too long"),
    ):
        said = failure(capsys, "paper", "--json", name)
        assert "argument --json: " + repr(name) in said and expected in said and ".part" not in said


def test_a_write_that_fails_leaves_nothing_and_names_what_was_given(tmp_path):
    target = tmp_path / "x.json"
    target.mkdir()
    with pytest.raises(OSError) as said:
        write_whole(target, "text")
    assert said.value.filename == str(target) and list(tmp_path.iterdir()) == [target]


def test_a_name_that_is_not_utf8_is_written_as_an_escape(tmp_path):
    assert write_whole(tmp_path / "x.json", '"h\udce4ngt ä"').read_bytes() == '"h\\udce4ngt ä"'.encode()


def test_info_warns_of_a_rig_file_of_another_rig(paper_cycle_bag, tmp_path, capsys):
    (tmp_path / "crane_1.yaml").write_text("rig_id: crane_1\n")
    assert main(["info", str(paper_cycle_bag), "--quiet", "--rig", str(tmp_path / "crane_1.yaml")]) == 0
    assert "the rig file describes crane_1 and the recording is of rig_000" in capsys.readouterr().err


@pytest.mark.parametrize("summary", [[], ["--quiet"], ["--json", "-"]])
def test_replay_warns_of_a_rig_file_of_another_rig_once(summary, paper_cycle_bag, tmp_path, capsys):
    bag = write_recording(tmp_path / "bag", read_recording(paper_cycle_bag).between(0.0, 20.0))
    (tmp_path / "crane_1.yaml").write_text("rig_id: crane_1\n")
    assert main(["replay", str(bag), "--no-smoothing", *summary, "--rig", str(tmp_path / "crane_1.yaml")]) == 0
    out, err = capsys.readouterr()
    said = "the rig file describes crane_1 and the recording is of rig_000"
    assert (f"warning: {bag}: {said}" in err) == bool(summary) and (said in " ".join(out.split())) == (summary != ["--quiet"])


@pytest.mark.parametrize(("recorded", "given"), [("46", "46"), ("32", "46"), ("46", "32"), ("68", "46")])
def test_info_warns_of_another_oil_than_the_rig_file_s(recorded, given, paper_cycle_bag, tmp_path, capsys):
    short = read_recording(paper_cycle_bag).between(0.0, 20.0)
    bag = write_recording(tmp_path / "oil", replace(short, rig=replace(short.rig, oil_grade=f"ISO VG {recorded}")))
    (tmp_path / "rig.yaml").write_text(f"oil: {{grade: ISO VG {given}}}\n")
    assert main(["info", str(bag), "--rig", str(tmp_path / "rig.yaml"), "--json", "-"]) == 0
    findings = json.loads(capsys.readouterr().out)["findings"]
    assert [finding["value"] for finding in findings if finding["field"] == "oil_grade"] == [f"ISO VG {recorded}"] * (recorded != given)


@pytest.mark.parametrize("argv", [["info"], ["info", "--json", "-"]])
def test_a_closed_pipe_is_no_answer(argv, paper_cycle_bag):
    command = [sys.executable, "-m", "ddh_twin_py.cli.main", *argv, str(paper_cycle_bag)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.close()
    assert (process.stderr.read(), process.wait(60)) == ("", 0)


@pytest.mark.parametrize(("argv", "unbuffered"), [
    (["info", "--json", "-", "BAG"], ""), (["info", "BAG"], ""), (["info", "BAG"], "1"), (["import", "--example"], ""),
    (["layouts", "FOLDER"], "1"), (["info", "--help"], "1"), (["--help"], ""), (["--version"], ""), ([], "1"),
])
def test_standard_output_that_is_full_is_named(argv, unbuffered, paper_cycle_bag, tmp_path):
    argv = [str({"BAG": paper_cycle_bag, "FOLDER": tmp_path / "new"}.get(word, word)) for word in argv]
    with open("/dev/full", "w") as full:
        done = subprocess.run([sys.executable, "-m", "ddh_twin_py.cli.main", *argv], stdout=full, stderr=subprocess.PIPE, text=True,
                              env={**os.environ, "PYTHONUNBUFFERED": unbuffered})
    name = " ".join(["ddh-twin", *argv[:1]]) if argv and argv[0] in VERBS and "--help" not in argv else "ddh-twin"
    assert done.returncode == 2 and done.stderr.splitlines()[-1] == f"{name}: error: standard output: No space left on device"
    assert "Traceback" not in done.stderr and "rror" not in "".join(done.stderr.splitlines()[:-1])


def test_standard_output_that_is_closed_takes_everything(paper_cycle_bag):
    command = f"exec {shlex.quote(sys.executable)} -m ddh_twin_py.cli.main "
    for verb in ("import --example", f"info {shlex.quote(str(paper_cycle_bag))}"):
        done = subprocess.run(["sh", "-c", f"{command}{verb} >&-"], stderr=subprocess.PIPE, text=True)
        assert (done.returncode, done.stderr) == (0, "")


def test_interrupted(capsys, monkeypatch):
    def interrupt(args):
        raise KeyboardInterrupt

    monkeypatch.setattr("ddh_twin_py.cli.info.run", interrupt)
    assert main(["info", "bag"]) == 130
    assert capsys.readouterr().err == "ddh-twin info: interrupted\n"


@pytest.mark.parametrize("at_work", [
    "\n        for _ in range(10**9): pass",
    "ctypes.CDLL(None).sleep(60)",
    "\n        for _ in range(1000): ctypes.CFUNCTYPE(None)(lambda: time.sleep(0.05))()",
    "threading.Thread(target=time.sleep, args=(60,)).start(); time.sleep(60)",
], ids=["python", "a call that takes long", "a callback that swallows it", "another thread"])
@pytest.mark.parametrize(("number", "word"), [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated")])
def test_interrupted_at_anything(at_work, number, word):
    code = (
        "import ctypes, sys, threading, time\nfrom ddh_twin_py.cli import info, main\n"
        f"def run(args):\n    print('at work', flush=True)\n    if True: {at_work}\n"
        "info.run = run\nsys.exit(main.main(['info', 'bag']))"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "at work\n"
    time.sleep(0.1)
    process.send_signal(number)
    said = process.communicate(timeout=20)[1]
    assert process.returncode == 128 + number and said == f"ddh-twin info: {word}\n"


def test_a_fault_of_the_program_is_not_passed_off_as_bad_input(monkeypatch):
    def fault(args):
        raise ValueError("shapes do not match")

    monkeypatch.setattr("ddh_twin_py.cli.info.run", fault)
    with pytest.raises(ValueError, match="shapes"):
        main(["info", "bag"])


def test_without_ros_the_live_verbs_say_what_to_do(capsys, monkeypatch, paper_cycle_bag):
    def missing(args):
        raise ModuleNotFoundError("No module named 'rclpy.serialization'", name="rclpy.serialization")

    monkeypatch.setattr("ddh_twin_py.cli.demo.run", missing)
    assert "source the ROS 2 workspace" in failure(capsys, "demo")


def test_what_one_verb_needs_is_named_with_how_to_get_it(capsys, monkeypatch):
    def missing(args):
        raise ModuleNotFoundError("No module named 'aiohttp'", name="aiohttp")

    with monkeypatch.context() as patched:
        patched.setattr("ddh_twin_py.cli.bench.run", missing)
        assert failure(capsys, "bench").endswith("aiohttp is not here: run .venv/bin/ddh-twin, or pip install aiohttp")
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert failure(capsys, "completion", "bash").endswith("shtab is not here: run .venv/bin/ddh-twin, or pip install shtab")


def test_version_and_no_verb(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("ddh_twin_py ")
    assert main([]) == 0
    assert "verbs:" in capsys.readouterr().out


def test_every_verb_is_a_module_with_a_docstring():
    assert set(cli.VERBS) == set(VERBS)
    for name in VERBS:
        module = import_module(cli._module(name))
        assert module.__doc__.startswith(f"`ddh-twin {name}`") and callable(module.run)
