"""Progress where no terminal shows a bar."""

import re
import time

import numba
import numpy as np
from ddh_twin_py.cli import console


def test_a_long_stage_tells_how_far_it_is_now_and_then(monkeypatch, capsys):
    now = iter([0.0, 4.0, 16.0, 20.0, 33.0, 40.0])
    monkeypatch.setattr(console.time, "perf_counter", lambda: next(now))
    with console.stage("weighing") as told:
        for share in (0.1, 0.4, 0.5, 0.8):
            told(share)
    assert capsys.readouterr().err.splitlines() == ["weighing: 40 % after 16 s", "weighing: 80 % after 33 s", "weighing: 40.0 s"]


def test_a_stage_whose_share_stands_still_is_seen_to_live(monkeypatch, capsys):
    monkeypatch.setattr(console, "_ALIVE", 0.2)
    with console.stage("weighing") as told:
        time.sleep(0.3)
        told(0.4)
        time.sleep(0.5)
    *lines, last = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("weighing: going on after ") and lines[-1].startswith("weighing: 40 % after ")
    assert len(lines) >= 3 and last.startswith("weighing: ") and "after" not in last


def test_what_is_under_way_is_named(monkeypatch, capsys):
    now = iter([0.0, 16.0, 40.0])
    monkeypatch.setattr(console.time, "perf_counter", lambda: next(now))
    with console.stage("diagnosing", part=lambda share: "weighing effects" if share < 0.9 else "sizing the gap") as told:
        told(0.4)
    assert capsys.readouterr().err.splitlines() == ["diagnosing: 40 %, weighing effects, after 16 s", "diagnosing: 40.0 s"]


def test_a_kernel_that_is_compiled_is_told(monkeypatch, capsys):
    monkeypatch.setattr(console, "_ALIVE", 0.05)

    @numba.njit
    def slow(x):
        for i in range(3):
            x += np.linalg.solve(np.eye(3) + i, np.ones(3)).sum()
        return x

    with console.stage("running") as told:
        slow(1.0)
        told(0.4)
        time.sleep(0.2)
    *lines, _ = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"running: going on, compiling a part of the model, once per version, after \d+ s", lines[0])
    assert re.fullmatch(r"running: 40 % after \d+ s", lines[-1])


def test_quiet_tells_nothing(capsys):
    with console.stage("weighing", quiet=True) as told:
        told(0.5)
    assert capsys.readouterr().err == ""
