"""What keeps the graph running, tried on small shell programs."""

import io
import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from ddh_twin_py.cli import supervisor as module
from ddh_twin_py.cli.supervisor import Child, Supervisor, combined_log
from nodes.processes import runs, wait_for


def shell(script):
    return ["/bin/sh", "-c", script]


class Run:
    """A supervisor at work; `lines` is its log."""

    def __init__(self, *children, linger=0.2):
        self.lines = []
        self.supervisor = Supervisor(children, self.lines.append, os.environ, linger=linger)

    def until(self, words, seconds=10.0):
        """Run, and ask to stop when the log holds these words (None: until it ends by itself)."""
        if words is None:
            return self.supervisor.run()

        def watch():
            deadline = time.monotonic() + seconds
            while time.monotonic() < deadline and not self.said(words):
                time.sleep(0.02)
            self.supervisor.ask_to_stop()

        thread = threading.Thread(target=watch)
        thread.start()
        code = self.supervisor.run()
        thread.join()
        assert self.said(words), "\n".join(self.lines)
        return code

    def said(self, words):
        return [line for line in list(self.lines) if words in line]


@pytest.fixture(autouse=True)
def short_back_off(monkeypatch):
    monkeypatch.setattr(module, "BACK_OFF", (0.05, 0.1, 0.2))


def test_a_child_that_stands_still_is_named_once_and_when_it_goes_on(monkeypatch):
    monkeypatch.setattr(module, "SILENT", 2)
    works = "while :; do sleep 0.1; done"
    stopped, other = Child("stopped", shell(works)), Child("other", shell(works))
    run = Run(stopped, other)

    def stop_and_go_on():
        wait_for(lambda: stopped.process is not None, 5.0, "its start")
        stopped.process.send_signal(signal.SIGSTOP)
        wait_for(lambda: run.said("does not answer"), 10.0, "the warning")
        time.sleep(2.5)
        stopped.process.send_signal(signal.SIGCONT)

    thread = threading.Thread(target=stop_and_go_on)
    thread.start()
    assert run.until("stopped answers again", 20.0) == 0
    thread.join()
    (said,) = run.said("does not answer")
    assert f"WARN stopped (process {stopped.process.pid}) does not answer: it has done nothing for 2 s" in said


def test_a_crashed_child_is_started_again_with_growing_pauses():
    run = Run(Child("weak", shell("echo up; exit 3")))
    assert run.until("weak started again (restart 4)") == 0
    pauses = [line.rpartition("again in ")[2] for line in run.said("weak ended (exit code 3)")][:4]
    assert pauses == ["0.05 s", "0.1 s", "0.2 s", "0.2 s"]


def test_what_would_begin_from_the_start_is_not_started_again_and_ends_the_whole():
    model = Child("model", shell("trap 'exit 0' TERM; while :; do sleep 0.05; done"))
    run = Run(model, Child("player", shell("echo plays; kill -9 $$"), source=True, once=True))
    assert run.until("player ended (signal SIGKILL)") == 1
    assert not run.said("started again (") and not model.running


def test_a_child_that_ran_long_begins_with_the_shortest_pause_again(monkeypatch):
    monkeypatch.setattr(module, "STEADY", 0.0)
    run = Run(Child("weak", shell("exit 3")))
    run.until("restart 3")
    assert {line.rpartition("again in ")[2] for line in run.said("starting it again")} == {"0.05 s"}


def test_a_child_that_is_killed_is_named_with_its_signal():
    run = Run(Child("victim", shell("kill -9 $$")))
    run.until("victim started again")
    assert run.said("victim ended (signal SIGKILL)")


def test_a_child_that_cannot_use_its_input_ends_all():
    run = Run(Child("steady", shell("trap 'exit 0' TERM; while :; do sleep 0.05; done")), Child("wrong", shell("echo no such bag; exit 2")))
    assert run.until(None) == 2
    assert run.said("wrong              | no such bag")
    assert not any(child.running for child in run.supervisor.children)


def test_all_stop_when_the_source_has_ended():
    model = Child("model", shell("trap 'echo bye; exit 0' TERM; while :; do sleep 0.05; done"))
    run = Run(model, Child("source", shell("sleep 0.3"), source=True))
    assert run.until(None) == 0
    assert run.said("the source has come to its end")
    assert run.said("model              | bye")


def test_a_source_that_crashes_is_no_end():
    run = Run(Child("source", shell("exit 1"), source=True))
    run.until("source started again")
    assert not run.said("come to its end")


def test_a_child_that_does_not_stop_is_made_to(monkeypatch):
    monkeypatch.setattr(module, "_GRACE", ((signal.SIGTERM, 0.2), (signal.SIGKILL, 2.0)))
    run = Run(Child("stubborn", shell("trap '' INT TERM; echo here; while :; do sleep 0.05; done")))
    assert run.until("stubborn           | here") == module.KILLED
    assert run.said("ERROR stubborn did not stop within 0.2 s, sending SIGKILL")
    assert not run.supervisor.children[0].running


def test_those_marked_last_are_stopped_last():
    stopping = "trap 'sleep {}; echo stopped; exit 0' TERM; echo here; while :; do sleep 0.05; done"
    run = Run(Child("recorder", shell(stopping.format(0)), last=True), Child("model", shell(stopping.format(0.5))))
    run.until("here")
    order = [line.split("|")[0].split()[-1] for line in run.said("stopped")]
    assert order[-1] == "recorder"


def test_every_line_is_logged_with_time_and_name():
    run = Run(Child("talker", shell("echo one; echo two >&2; printf three; exit 0"), source=True))
    run.until(None)
    said = [line for line in run.lines if line.split()[1] == "talker"]
    assert [line.split("| ")[1] for line in said] == ["one", "two", "three"]
    time.strptime(said[0].split(".")[0], "%H:%M:%S")


def test_what_another_child_warns_of_in_the_same_words_is_in_the_file_alone():
    file, errors = io.StringIO(), io.StringIO()
    log = combined_log(file, None, errors)
    lines = [f"12:00:00.000 {who:<18} | WARN {text}" for who, text in
             (("one", "odd"), ("two", "odd"), ("one", "odd"), ("two", "odder"), ("three", "odd"))]
    for line in lines:
        log(line)
    assert errors.getvalue().splitlines() == [lines[0], lines[2], lines[3]]
    assert file.getvalue().splitlines() == lines


@pytest.mark.parametrize("quiet", [False, True])
def test_warnings_and_errors_go_to_standard_error_whether_quiet_or_not(quiet, capsys):
    file = io.StringIO()
    bad = "echo INFO begun; echo error: no such file; exit 2"
    crashing = "echo Traceback of a call; echo '  File'; echo 'KeyError: x'; echo WARN late; echo INFO done; echo 'KeyError: y'; sleep 0.3"
    log = combined_log(file, None if quiet else sys.stdout)
    children = [Child("crashing", shell(crashing)), Child("one", shell("sleep 0.3; " + bad)), Child("two", shell("sleep 0.3; " + bad))]
    assert Supervisor(children, log, os.environ).run() == 2
    out, err = capsys.readouterr()
    said = [line.split(" | ")[1] for line in err.splitlines()]
    assert said[:4] == ["Traceback of a call", "  File", "KeyError: x", "WARN late"]
    assert said.count("error: no such file") == 1 and any("cannot use what it was given, stopping" in line for line in said)
    assert ("KeyError: y" in out) != quiet and "KeyError: y" not in err and "no such" not in out
    assert {*out.splitlines(), *err.splitlines()} <= {*file.getvalue().splitlines()}


def test_children_do_not_outlive_a_supervisor_that_is_killed(tmp_path):
    code = (
        "import os, sys\nfrom ddh_twin_py.cli.supervisor import Child, Supervisor, combined_log\n"
        "Supervisor([Child('sleeper', ['sleep', '60'])], combined_log(None), os.environ).run()\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", code])
    try:
        children = wait_for(lambda: _children(parent.pid), 20.0, "a child")
    finally:
        parent.kill()
        parent.wait()
    wait_for(lambda: not any(runs(child) for child in children), 10.0, "the end of the child")


def _children(pid):
    try:
        with open(f"/proc/{pid}/task/{pid}/children") as file:
            return [int(child) for child in file.read().split()]
    except FileNotFoundError:
        return []
