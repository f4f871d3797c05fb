"""Processes: one per question, finished ones are kept, a crash loses one case only."""

import json
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import yaml
from ddh_twin_py.gap_bench import running
from ddh_twin_py.gap_bench.running import BenchError, executor, result_file, run_bench
from ddh_twin_py.gap_bench.scoring import answers_of_all
from ddh_twin_py.gap_bench.sealing import SealError, seal, verify
from ddh_twin_py.rig.files import held
from support.gap_reports import truth


@pytest.fixture
def bench(tmp_path):
    out = tmp_path / "bench"
    (out / "truth").mkdir(parents=True)
    rows = [truth("case_0001"), truth("case_0002"), truth("case_0003", "left_out"), truth("case_0004", "none", "", ())]
    for row in rows:
        (out / "truth" / f"{row['name']}.yaml").write_text(yaml.safe_dump(row))
        (out / "cases" / row["name"] / "field").mkdir(parents=True)
    seal(out)
    return out


def test_all_questions_are_asked_once(bench, engine):
    name, asked = engine
    shares = []
    assert run_bench(bench, jobs=2, engine=name, progress=lambda *told: shares.append(told)) == ["case_0002"]
    assert shares[-1] == (1.0, {}, 1) and [share for share, *_ in shares] == sorted(share for share, *_ in shares)
    first = sorted(asked.read_text().splitlines())
    assert first == sorted([
        "case_0001 [] None", "case_0001 [] ['pump_1.leakage']", "case_0002 [] None", "case_0002 [] ['pump_1.leakage']",
        "case_0003 [] None", "case_0003 ['pump_1.leakage', 'pump_2.leakage'] None", "case_0004 [] None",
    ])
    assert run_bench(bench, engine=name) == ["case_0002"]
    assert sorted(asked.read_text().splitlines()) == first


def test_an_unfinished_case_is_run(bench, engine):
    name, asked = engine
    run_bench(bench, engine=name)
    asked.unlink()
    result_file(bench, "case_0004", "blind").unlink()
    run_bench(bench, engine=name)
    assert asked.read_text() == "case_0004 [] None\n"


def test_who_comes_second_is_refused_and_forgets_nothing(bench, engine):
    name, asked = engine
    run_bench(bench, engine=name, oracle=False)
    asked.unlink()
    with held(bench, ".run.lock", BenchError("first")), pytest.raises(BenchError, match="another ddh-twin gap-bench is running there"):
        run_bench(bench, engine=name, oracle=False, again="all")
    assert result_file(bench, "case_0001", "blind").is_file() and not asked.exists()


def test_asked_again(bench, engine):
    name, asked = engine
    run_bench(bench, engine=name, oracle=False)
    asked.unlink()
    run_bench(bench, engine=name, oracle=False, again="crashed")
    assert asked.read_text() == "case_0002 [] None\n"
    run_bench(bench, engine=name, oracle=False, suites=("none",), again="all")
    assert asked.read_text().splitlines()[1:] == ["case_0004 [] None"]


def test_crash_is_kept_with_its_reason(bench, engine):
    run_bench(bench, engine=engine[0], oracle=False)
    kept = json.loads(result_file(bench, "case_0002", "blind").read_text())
    assert kept["error"] == "the diagnosis ended with exit code 1 and no report: ValueError: this one breaks"
    by_name = {a.name: a for a in answers_of_all([bench])[0]}
    assert by_name["case_0002"].crashed and not by_name["case_0002"].right
    assert by_name["case_0001"].right and by_name["case_0001"].megabytes > 10.0


def test_suites_and_number_of_cases(bench, engine):
    name, asked = engine
    run_bench(bench, suites=("none",), engine=name)
    assert asked.read_text() == "case_0004 [] None\n"
    run_bench(bench, cases=1, engine=name, oracle=False)
    assert asked.read_text().splitlines()[1:] == ["case_0001 [] None"]
    with pytest.raises(BenchError, match="no case of suite two"):
        run_bench(bench, suites=("two",), engine=name)


def test_changed_truth_is_not_run(bench, engine):
    file = bench / "truth" / "case_0001.yaml"
    file.write_text(file.read_text() + "# later\n")
    with pytest.raises(SealError, match="case_0001"):
        run_bench(bench, engine=engine[0])
    assert not engine[1].exists()


def test_cluster_without_dask_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BenchError, match="pip install distributed"):
        executor(1, "tcp://nowhere:8786")


def test_half_an_answer_is_asked_for_once_more(bench, engine):
    name, asked = engine
    run_bench(bench, suites=("none",), engine=name)
    file = result_file(bench, "case_0004", "blind")
    file.write_text(file.read_text()[:30])
    asked.unlink()
    run_bench(bench, suites=("none",), engine=name)
    assert asked.read_text() == "case_0004 [] None\n" and "report" in json.loads(file.read_text())
    file.write_text("{")
    run_bench(bench, suites=("none",), engine=name, again="crashed")
    assert "report" in json.loads(file.read_text())


def test_a_score_looks_at_the_seals_once_and_counts_who_waits(bench, engine, monkeypatch):
    run_bench(bench, suites=("none",), engine=engine[0])
    looked = []
    monkeypatch.setattr(running, "verify", lambda out: looked.append(out) or verify(out))
    answers, waiting = answers_of_all([bench])
    assert ([a.name for a in answers], waiting, looked) == (["case_0004"], 3, [bench])


def test_where_a_task_fails_those_that_have_not_begun_are_not_begun():
    begun, go_on = [], threading.Event()

    def task(number):
        begun.append(number)
        if number == 0:
            raise OSError(28, "No space left on device")
        go_on.wait(10.0)
        return number

    with ThreadPoolExecutor(2) as pool, pytest.raises(OSError, match="No space left"):
        waiting = [pool.submit(task, number) for number in range(8)]
        try:
            list(running.results(waiting))
        finally:
            go_on.set()
    assert len(begun) <= 4


MAKER = """
import sys, time
from concurrent.futures import wait
from ddh_twin_py.gap_bench.bench import _makers

if __name__ == "__main__":
    pool = _makers(1, None)
    print(*[pool.submit(__import__("os").getpid).result()], flush=True)
    time.sleep(60.0)
"""


def test_who_makes_cases_ends_with_a_parent_that_is_killed(tmp_path):
    script = tmp_path / "maker.py"
    script.write_text(MAKER)
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True) as parent:
        worker = int(parent.stdout.readline())
        parent.kill()
    deadline = time.monotonic() + 20.0
    while Path(f"/proc/{worker}").exists() and Path(f"/proc/{worker}/stat").read_text().split()[2] != "Z":
        assert time.monotonic() < deadline, "the worker goes on"
        time.sleep(0.1)
