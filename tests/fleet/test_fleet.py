"""A fleet with a stand-in for the diagnosis: what is found, rows, going on after a crash, table, page, cluster."""

import csv
import io
import json
import os
import re
import shutil
import sys
import threading
import types
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.cli.main import main
from ddh_twin_py.diagnosis.process import Outcome
from ddh_twin_py.fleet import run as fleet_run
from ddh_twin_py.fleet.page import fleet_document, newest_gaps, remark, verdict
from ddh_twin_py.fleet.parquet import write_parquet
from ddh_twin_py.fleet.progress import FleetProgress
from ddh_twin_py.fleet.recordings import FleetError, find_recordings
from ddh_twin_py.fleet.results import Results, fingerprints
from ddh_twin_py.fleet.row import COLUMNS, Row, as_csv, row_of, with_one_probability
from ddh_twin_py.fleet.run import Settings, run_fleet
from ddh_twin_py.physics.compiling import COMPILING
from ddh_twin_py.report.page.document import version
from ddh_twin_py.rig.files import held

FAKE = (sys.executable, str(Path(__file__).parents[1] / "support" / "fake_diagnosis.py"))


@pytest.fixture(scope="module")
def second(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 2.0)


@pytest.fixture(scope="module")
def cranes(tmp_path_factory, second):
    """Two cases, a single bag, a case that crashes its diagnosis, one that is refused, and a bag that is none."""
    place = tmp_path_factory.mktemp("written") / "cranes"
    for i, name in enumerate(("a/march/field", "a/march/commissioning", "a/april", "b/crash/field", "b/bad")):
        write_recording(place / name, second.between(0.0, 2.0 - 0.02 * i))
    (place / "b/torn").mkdir()
    (place / "b/torn/torn.mcap").write_bytes(b"\x00" * 100)
    (place / ".hidden").mkdir()
    (place / ".hidden/x.mcap").write_bytes(b"")
    (place / "notes.txt").write_text("no bag")
    return place


@pytest.fixture
def folder(cranes, tmp_path):
    """A copy that a test may change."""
    return shutil.copytree(cranes, tmp_path / "cranes")


def test_cases_and_single_bags_are_found(folder):
    found = {f.name: f.case for f in find_recordings(folder)}
    assert list(found) == ["a/april", "a/march", "b/bad", "b/crash", "b/torn/torn.mcap"]
    assert found["a/march"].field == (folder / "a/march/field",) and found["a/march"].commissioning == folder / "a/march/commissioning"
    assert found["a/march"].validation is None and found["a/april"].field == (folder / "a/april",)
    assert [f.name for f in find_recordings(folder / "a/april")] == ["april"]
    assert [f.name for f in find_recordings(folder, leave_out=folder / "b")] == ["a/april", "a/march"]


def test_parts_of_one_bag_are_one_recording_and_loose_files_are_many(tmp_path):
    for name in ("cut/cut_0.mcap", "cut/cut_1.mcap", "loose/x.mcap", "loose/y_1.db3", "run.2/run.2_0.db3.zstd", "run.2/run.2_1.db3.zstd"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    assert [f.name for f in find_recordings(tmp_path)] == ["cut", "loose/x.mcap", "loose/y_1.db3", "run.2"]


def test_numbered_files_are_one_recording_where_they_go_on_in_time_alone(tmp_path, second):
    """Three days, two cranes at once, and a bag that was split and renamed, of which the tenth part is sorted before the second."""
    def put(name, begin, end, later=0.0):
        moved = replace(second.between(begin, end), epoch_ns=second.epoch_ns + round(later * 1e9), rig=None if begin else second.rig)
        file = write_recording(tmp_path / "made" / name.replace("/", "-"), moved)
        (tmp_path / "fleet" / name).parent.mkdir(parents=True, exist_ok=True)
        (file / f"{file.name}.mcap").rename(tmp_path / "fleet" / f"{name}.mcap")

    for k in (1, 2, 3):
        put(f"days/day_{k}", 0.0, 1.0, 86400.0 * k)
    for k in (1, 2):
        put(f"cranes/crane_{k}", 0.0, 1.9 + 0.01 * k)
    for k in (9, 10, 11):
        put(f"renamed/x_{k}", 0.5 * (k - 9), 0.5 * (k - 8))
    assert [f.name for f in find_recordings(tmp_path / "fleet")] == [
        "cranes/crane_1.mcap", "cranes/crane_2.mcap", "days/day_1.mcap", "days/day_2.mcap", "days/day_3.mcap", "renamed"]


def test_a_folder_without_recordings_is_an_error(tmp_path):
    for path, words in ((tmp_path, "holds no recording"), (tmp_path / "none", "there is no such folder")):
        with pytest.raises(FleetError, match=words):
            find_recordings(path)


def test_a_file_is_said_to_be_one(folder):
    with pytest.raises(FleetError) as caught:
        find_recordings(folder / "b/torn/torn.mcap")
    assert str(caught.value) == f"{folder}/b/torn/torn.mcap: is a file; give a folder of recordings, such as {folder}/b/torn"


def test_no_folder_is_proposed_that_holds_no_recording(tmp_path):
    (tmp_path / "README.md").write_text("no bag")
    with pytest.raises(FleetError) as caught:
        find_recordings(tmp_path / "README.md")
    assert str(caught.value) == f"{tmp_path}/README.md: is a file; give a folder of recordings"


@pytest.mark.parametrize("role", ["commissioning", "validation"])
def test_a_case_without_field_is_a_row_that_says_so_and_alone_an_error(role, folder, tmp_path, second, capsys):
    write_recording(folder / "half" / role, second)
    rows, _ = diagnosed(folder, tmp_path / "out")
    assert f"half/{role}" not in rows and rows["a/march"].verdict == "explained"
    assert rows["half"].error.startswith(f"{folder}/half is a case folder without field: it holds {role}; a case needs field/")
    assert main(["fleet", str(folder / "half"), "--out", str(tmp_path / "alone"), "--quiet"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "half is a case folder without field" in line and not (tmp_path / "alone").exists()


def test_a_folder_of_many_bags_may_be_called_as_a_role(tmp_path, second):
    for name in ("commissioning/a", "commissioning/b", "other/field"):
        write_recording(tmp_path / name, second)
    assert [f.name for f in find_recordings(tmp_path)] == ["commissioning/a", "commissioning/b", "other"]


def test_a_link_to_nowhere_is_a_row_and_stops_nothing(folder, tmp_path):
    (folder / "b/gone.mcap").symlink_to(tmp_path / "nowhere.mcap")
    rows, _ = diagnosed(folder, tmp_path / "out")
    assert "gone.mcap" in rows["b/gone.mcap"].error and rows["a/march"].verdict == "explained"


def test_links_to_recordings_are_followed_once(folder, tmp_path, second):
    before = [f.name for f in find_recordings(folder)]
    elsewhere = tmp_path / "elsewhere"
    write_recording(elsewhere / "bag", second)
    (folder / "linked").symlink_to(elsewhere)
    (folder / "again").symlink_to(folder)
    assert sorted(f.name for f in find_recordings(folder)) == sorted([*before, "linked/bag"])


def test_links_to_files_count_once(tmp_path):
    for name in ("here/deep/x.mcap", "elsewhere/y.mcap"):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_bytes(b"")
    for name, of in (("a.mcap", "here/deep/x.mcap"), ("b.mcap", "elsewhere/y.mcap"), ("c.mcap", "elsewhere/y.mcap")):
        (tmp_path / "here" / name).symlink_to(tmp_path / of)
    assert [f.name for f in find_recordings(tmp_path / "here")] == ["b.mcap", "deep/x.mcap"]


def test_copies_are_one_row_that_names_both(folder, tmp_path, monkeypatch, capsys):
    shutil.copytree(folder / "a/april", folder / "later/april_again")
    shutil.copytree(folder / "a/march", folder / "later/march")
    (data,) = (folder / "b/bad").glob("*.mcap")
    shutil.copy(data, folder / "loose.mcap")
    found = {f.name: f.copies for f in find_recordings(folder)}
    assert found == {"a/april": ("later/april_again",), "a/march": ("later/march",), "b/bad": ("loose.mcap",), "b/crash": (),
                     "b/torn/torn.mcap": ()}
    monkeypatch.setattr(fleet_run.Settings, "__init__", _with_fake(fleet_run.Settings.__init__))
    assert main(["fleet", str(folder), "--out", str(tmp_path), "--html", str(tmp_path / "fleet.html")]) == 0
    rows = {row["recording"]: row["copies"] for row in csv.DictReader((tmp_path / "fleet.csv").open())}
    assert rows == {name: " | ".join(copies) for name, copies in found.items()}
    assert "  a/april = later/april_again: the same recording, one row\n" in capsys.readouterr().out
    assert ">a/april = later/april_again<" in (tmp_path / "fleet.html").read_text()
    shutil.rmtree(folder / "later")
    assert diagnosed(folder, tmp_path / "results")[0]["a/april"].copies == "", "a kept answer names no copy that is gone"


def test_what_differs_in_one_byte_or_another_bag_or_holds_nothing_is_no_copy(folder, tmp_path):
    shutil.copytree(folder / "a/march", folder / "later/march")
    shutil.copytree(folder / "a/april", folder / "later/march/validation")
    shutil.copytree(folder / "a/april", folder / "later/april")
    (data,) = (folder / "later/april").glob("*.mcap")
    content = bytearray(data.read_bytes())
    content[len(content) // 2] ^= 1
    data.write_bytes(content)
    for name in ("x.mcap", "y.mcap"):
        (folder / name).write_bytes(b"")
    assert all(not f.copies for f in find_recordings(folder)) and len(find_recordings(folder)) == 9


@pytest.mark.parametrize("option", ["--csv", "--html", "--json", "--parquet"])
def test_what_a_case_holds_is_not_overwritten(option, folder, tmp_path, second, capsys):
    write_recording(folder / "deep" / "case" / "field", second)
    for file in (folder / "deep/case/field").iterdir():
        before = file.read_bytes()
        with pytest.raises(SystemExit) as left:
            main(["fleet", str(folder), "--out", str(tmp_path / "out"), option, str(file)])
        assert left.value.code == 2 and "would overwrite" in capsys.readouterr().err and file.read_bytes() == before


def test_a_folder_that_cannot_be_looked_into_is_found(folder, monkeypatch):
    real = os.scandir

    def scandir(path):
        if str(path) == str(folder / "b"):
            raise PermissionError(13, "Permission denied", str(path))
        return real(path)

    monkeypatch.setattr(os, "scandir", scandir)
    assert [f.name for f in find_recordings(folder)] == ["a/april", "a/march", "b"]


def test_results_among_the_recordings_are_refused(folder):
    with pytest.raises(FleetError, match="give --out a folder of its own"):
        find_recordings(folder, leave_out=folder / "a" / "..")


def diagnosed(folder, results, **given):
    calls = []
    command = FAKE
    rows = run_fleet(find_recordings(folder), Results(results), Settings(30.0, command), jobs=2,
                     progress=lambda share, running, failed: calls.append(share), **given)
    return {row.recording: row for row in rows}, calls


@pytest.mark.parametrize("out", ["a/april", "a/march"])
def test_results_are_not_written_into_a_recording(out, folder, capsys):
    before = sorted(folder.rglob("*"))
    assert main(["fleet", str(folder), "--out", str(folder / out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"--out: {folder / out} is a recording, nothing is written into it" in line and sorted(folder.rglob("*")) == before


def test_results_are_not_written_below_a_bag_but_beside_loose_files(folder, monkeypatch, capsys):
    monkeypatch.setattr(fleet_run.Settings, "__init__", _with_fake(fleet_run.Settings.__init__))
    assert main(["fleet", str(folder), "--out", str(folder / "a/april/deep/er")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"lies in the recording {folder / 'a/april'}" in line and not (folder / "a/april/deep").exists()
    assert main(["fleet", str(folder), "--out", str(folder / "b/torn/out"), "--quiet"]) == 0


def test_a_result_that_cannot_be_kept_ends_nothing_and_is_told(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fleet_run.Settings, "__init__", _with_fake(fleet_run.Settings.__init__))
    out = tmp_path / "out"
    march = next(f for f in find_recordings(folder) if f.name == "a/march")
    Results(out / "results").path(march.name).mkdir(parents=True)  # where its file would be
    assert main(["fleet", str(folder), "--out", str(out), "--quiet"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("1 of 5 results could not be kept (") and "a-march" in line
    rows = {row["recording"]: row for row in csv.DictReader((out / "fleet.csv").open())}
    assert len(rows) == 5 and rows["a/march"]["effect"] == "pump_1.leakage"
    assert Results(out / "results").finished(march) is None


def test_every_recording_has_a_row_whatever_happens(folder, tmp_path):
    rows, calls = diagnosed(folder, tmp_path / "results")
    march = rows["a/march"]
    assert (march.verdict, march.effect, march.probability, march.size, march.size_std, march.unit) == (
        "explained", "pump_1.leakage", 0.9, 2.5, 0.1, "1")  # fmt: skip
    assert (march.gap_before, march.gap_after, march.error) == (3.0, 1.1, "")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", march.begin) and march.duration == pytest.approx(2.0, abs=0.1)
    assert march.rig == rows["b/bad"].rig == "rig_000" and march.time.utcoffset().total_seconds() == 0.0
    assert "drive/telemetry: no message" in rows["b/bad"].error and "SIGKILL" in rows["b/crash"].error
    assert rows["b/torn/torn.mcap"].error and "\n" not in rows["b/torn/torn.mcap"].error
    assert calls[-1] == 1.0 and calls == sorted(calls)


def test_a_row_has_one_probability(folder, tmp_path, monkeypatch):
    """That of the effect; the set that its sentence is of has another. Where no effect is named the sentence keeps its own."""
    said = "The gap is explained by x: it shrinks from 3.0 to 1.1 times the floor (probability 93 %)."
    real = fleet_run.row_of
    monkeypatch.setattr(fleet_run, "row_of", lambda known, outcome: real(known, replace(outcome, sentence=said)))
    rows, _ = diagnosed(folder, tmp_path / "results")
    again, _ = diagnosed(folder, tmp_path / "results")
    assert rows["a/march"].sentence == again["a/march"].sentence == said.replace(" (probability 93 %)", "")
    none = Row("x", verdict="no_gap", sentence="No gap: nothing is needed (probability 97 %).")
    assert with_one_probability(none) == none


def test_what_is_finished_is_not_run_again_and_what_crashed_is(folder, tmp_path, monkeypatch):
    first, _ = diagnosed(folder, tmp_path / "results")
    ran = []
    real = fleet_run.diagnose_recording

    def counted(found, *rest):
        ran.append(found.name)
        return real(found, *rest)

    monkeypatch.setattr(fleet_run, "diagnose_recording", counted)
    second, _ = diagnosed(folder, tmp_path / "results")
    assert ran == ["b/crash"] and second == first
    ran.clear()
    files = sorted((tmp_path / "results").iterdir())
    content = json.loads(files[0].read_text())
    assert content["report"]["verdict"] == "explained" and content["recording"] == "a/april"
    files[0].write_text(files[0].read_text()[:50])  # cut off
    (folder / "a/march/field/metadata.yaml").touch()  # recorded anew
    assert diagnosed(folder, tmp_path / "results")[0] == first
    assert sorted(ran) == ["a/april", "a/march", "b/crash"]
    ran.clear()
    diagnosed(folder, tmp_path / "results", again=True)
    assert len(ran) == 5


def test_what_the_system_refused_is_tried_again(folder, tmp_path, monkeypatch):
    (folder / "a/april").rename(folder / "a/full")  # no space for what the child makes
    before = diagnosed(folder, tmp_path / "results")[0]
    assert before["a/full"].error == "/tmp: No space left on device"
    assert not Results(tmp_path / "results").path("a/full").exists()
    (folder / "a/full").rename(folder / "a/april")

    def no_space(**_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:  # for what is unpacked to read it here
        patched.setattr("ddh_twin_py.bags.reader.tempfile.TemporaryDirectory", no_space)
        assert "No space left on device" in diagnosed(folder, tmp_path / "results", again=True)[0]["a/march"].error
    after = diagnosed(folder, tmp_path / "results")[0]
    assert after["a/april"].error == after["a/march"].error == "" and after["b/torn/torn.mcap"].error


def test_what_is_replaced_during_its_diagnosis_is_diagnosed_anew(folder, tmp_path, monkeypatch):
    real, ran = fleet_run.diagnose_recording, []

    def replaced(found, *rest):
        answer = real(found, *rest)
        ran.append(found.name)
        if found.name == "a/april" and ran.count("a/april") == 1:
            with open(found.case.field[0] / "april.mcap", "ab") as file:  # still being copied in
                file.write(b"more")
        return answer

    monkeypatch.setattr(fleet_run, "diagnose_recording", replaced)
    for often in (1, 2, 2):
        diagnosed(folder, tmp_path / "results")
        assert (ran.count("a/april"), ran.count("a/march")) == (often, 1)


@pytest.mark.parametrize("wrong", [
    {"begin": 5}, {"begin": "then"}, {"begin": "2026-01-01T00:00:00"}, {"size": "x"}, {"size": True}, {"size": 10**400}, {"verdict": None},
    {"recording": "b"}, {"gap_before": [1.0]}, {"duration": float("nan")},
], ids=str)  # fmt: skip
def test_a_kept_result_of_wrong_types_is_none(wrong, folder, tmp_path):
    results = Results(tmp_path)
    (found,) = (f for f in find_recordings(folder) if f.name == "a/april")
    row = Row("a/april", rig="r", begin="2026-01-01T00:00:00Z", duration=2.0, verdict="no_gap", gap_before=1)
    results.keep(found, fingerprints(found), row, {})
    assert results.finished(found) == row
    content = json.loads(results.path(found.name).read_text())
    results.path(found.name).write_text(json.dumps({**content, "row": content["row"] | wrong}))
    assert results.finished(found) is None
    results.path(found.name).write_text("[" * 100_000)
    assert results.finished(found) is None


def test_a_name_that_is_not_utf8_and_one_with_a_line_end_are_shown_and_end_nothing(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fleet_run.Settings, "__init__", _with_fake(fleet_run.Settings.__init__))
    odd = [os.fsdecode(b"b/h\xe4ngt.mcap"), "b/two\nlines.mcap"]
    for name in odd:
        (folder / name).write_bytes(b"")
    out = tmp_path / "out"
    written = [tmp_path / name for name in ("f.html", "f.json", "f.parquet")]
    asked = ["fleet", str(folder), "--out", str(out), "--jobs", "2"]
    assert main([*asked, "--html", str(written[0]), "--json", str(written[1]), "--parquet", str(written[2])]) == 0
    said = capsys.readouterr().out
    assert "  b/h\\udce4ngt.mcap: " in said and "  b/two\\nlines.mcap: " in said
    assert all(b"h\\udce4ngt" in file.read_bytes() for file in (*written, out / "fleet.csv"))
    assert odd[0] in [row["recording"] for row in json.loads(written[1].read_text())["rows"]]
    assert {f.name for f in find_recordings(folder) if Results(out / "results").finished(f)} >= set(odd)


def test_a_diagnosis_that_takes_too_long_is_given_up_and_tried_again(folder, tmp_path, second):
    write_recording(folder / "slow", second)
    found = [f for f in find_recordings(folder) if f.name == "slow"]
    (row,) = run_fleet(found, Results(tmp_path / "results"), Settings(0.5, FAKE))
    assert "took longer than 0.5 s" in row.error and row.rig == "rig_000"
    assert Results(tmp_path / "results").finished(found[0]) is None


def test_an_interruption_ends_the_processes(folder, tmp_path, second, monkeypatch):
    write_recording(folder / "slow", second)
    stopped = []
    stop = fleet_run.DiagnosisProcess.stop
    monkeypatch.setattr(fleet_run.DiagnosisProcess, "stop", lambda self: (stop(self), stopped.append(self)))
    found = [f for f in find_recordings(folder) if f.name in ("a/april", "slow")]

    def interrupt(share, running, failed):
        if list(running) == ["slow"] and running["slow"][0] > 0.0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_fleet(found, Results(tmp_path / "results"), Settings(60.0, FAKE), jobs=2, progress=interrupt)
    assert len(stopped) == 1 and stopped[0].outcome.error == "the diagnosis was stopped"
    assert not [t for t in threading.enumerate() if t.name.startswith("fleet")]


def test_what_is_under_way_counts_by_its_share_and_is_named(folder, tmp_path, second):
    write_recording(folder / "slow", second)
    found = [f for f in find_recordings(folder) if f.name in ("a/april", "slow")]
    told, far = [], FleetProgress(2, 0, iter((0.0, 60.0, 60.0)).__next__)
    run_fleet(found, Results(tmp_path / "results"), Settings(3.0, FAKE), jobs=2, progress=lambda *one: told.append(one))
    assert any(running == {"slow": (0.5, "fitting")} and share == 0.75 for share, running, _ in told) and told[-1] == (1.0, {}, 1)
    shares = []
    far.then(shares.append)(0.75, {"slow": (0.5, "fitting")}, 0)
    assert shares == [0.75] and far.said(0.75) == "1 of 2 finished, slow: 50 %, about 20 s left"


@pytest.mark.parametrize(("done", "stage", "said"), [
    (0.0, "reading", "reading"), (0.001, COMPILING, COMPILING), (0.5, COMPILING, COMPILING), (0.5, "fitting the rig", "50 %")])
def test_of_a_recording_whose_share_stands_still_the_stage_is_told(done, stage, said):
    far = FleetProgress(1, 0, lambda: 0.0)
    far.then(lambda share: None)(0.0, {"slow": (done, stage)}, 0)
    assert far.said(0.0) == f"0 of 1 finished, slow: {said}"


def test_what_failed_tells_nothing_of_the_time_that_is_left():
    """One of two bags is broken; after 12 s the other is at 5 %, after 60 s at 25 %."""
    now = iter((0.0, 12.0, 60.0, 60.0))
    far = FleetProgress(2, 0, now.__next__)
    for done, left in ((0.05, ""), (0.25, ", about 3 min left")):
        far.then(lambda share: None)(0.5 + done / 2.0, {"slow": (done, "fitting")}, 1)
        assert far.said(0.5) == f"1 of 2 finished, slow: {100.0 * done:.0f} %{left}"


def test_time_that_is_left_goes_down_while_a_share_stands_still_and_is_not_told_once_it_is_over():
    now = [0.0]
    far = FleetProgress(2, 0, lambda: now[0])
    told = []
    for time, done in ((100.0, 0.9), (104.0, 0.9), (106.0, 0.9), (300.0, 0.9), (400.0, 0.95)):
        now[0] = time
        far.then(lambda share: None)(0.5 + done / 2.0, {"slow": (done, "sizing the gap")}, 0)
        told.append(far.said(0.5).partition("%")[2])
    assert told == [", about 5 s left", ", about 1 s left", "", "", ", about 10 s left"]


def report(verdict, why, classes=()):
    return Outcome({"verdict": verdict, "gap": {"before": 2.0, "after": None}, "why": why, "classes": list(classes)}, "Said.")


def test_a_row_names_the_class_and_no_effect_where_there_is_no_gap():
    shares = {"pump_1.friction": 0.5, "motor.bearing_friction": 0.3, "unknown": 0.1}
    why = [{"effect": effect, "probability": share} for effect, share in shares.items()]
    members = ["motor.bearing_friction", "pump_1.friction"]
    row = row_of({"recording": "x"}, report("ambiguous", why, [["tank.cooling", "tank.oil_level"], members]))
    assert row.effect == "motor.bearing_friction | pump_1.friction" and row.probability == pytest.approx(0.8) and row.size is None
    assert row_of({"recording": "x"}, report("no_gap", why)).effect == ""
    assert row_of({"recording": "x"}, report("unknown", why[2:])).effect == "unknown"


def test_what_reading_lost_of_a_recording_stands_first_in_its_row(tmp_path, second):
    write_recording(tmp_path / "cut", second)
    (data,) = (tmp_path / "cut").glob("*.mcap")
    data.write_bytes(data.read_bytes()[: data.stat().st_size // 2])
    (tmp_path / "cut/metadata.yaml").unlink()
    (lost,) = [finding.message for finding in read_recording(tmp_path / "cut").warnings]
    none, bar, told = "The recordings allow no answer: too short.", "kpa: look as if given in bar. No gap.", []
    for said in (none, f"Careful: {bar}", f"Careful: {lost}. No gap."):
        row = row_of({"recording": "cut"}, Outcome({"verdict": "insufficient", "notes": ["too short", lost]}, said))
        assert remark(row) == row.sentence and row.sentence in next(csv.DictReader(as_csv([row]).splitlines()))["sentence"]
        told.append(row.sentence)
    first = f"Careful: {lost}. "
    assert "has no end, the recorder was stopped hard" in lost
    assert told == [first + none, first + bar, f"{first}No gap."]


def test_a_row_names_what_acts_beside_the_effect():
    two = report("explained", [{"effect": "load.geometry", "probability": 0.9}, {"effect": "motor.iron_loss", "probability": 0.8}])
    two.report["hypotheses"] = [{"effects": [], "probability": 0.1}, {"effects": ["load.geometry", "motor.iron_loss"], "probability": 0.8},
                                {"effects": ["load.geometry"], "probability": 0.1}]
    row = row_of({"recording": "x"}, two)
    assert (row.effect, row.also) == ("load.geometry", "motor.iron_loss")


def some_rows():
    leak = {"verdict": "explained", "effect": "pump_1.leakage", "parameter": "leakage_ratio", "size_std": 0.1, "unit": "1", "nominal": 1.0}
    rows = [
        Row(f"a/{n}", "rig_<1>", f"2026-0{n}-01T00:00:00Z", 600.0, **leak, probability=0.9, size=1.0 + 0.5 * n, gap_before=2.0 + n,
            gap_after=1.1, sentence="It leaks.")
        for n in (1, 2, 3)
    ]  # fmt: skip
    well = Row("b/1", "rig_2", "2026-02-01T00:00:00Z", 60.0, "no_gap", gap_before=1.0, gap_after=1.0)
    return [*rows, well, Row("c", error="torn, <all>")]


def test_the_table_as_csv():
    table = list(csv.DictReader(as_csv(some_rows()).splitlines()))
    assert tuple(table[0]) == COLUMNS and len(table) == 5
    assert (float(table[1]["size"]), table[3]["size"], table[4]["error"]) == (2.0, "", "torn, <all>")


@pytest.mark.parametrize("name", ["=cmd|' /C calc'!A0", "+1", "-1", "@SUM(A1)"])
def test_a_name_is_no_formula_of_a_spreadsheet_and_a_number_stays_one(name):
    (row,) = csv.DictReader(io.StringIO(as_csv([Row(name, rig=name, size=-2.5, error=f"{name} is torn")]), newline=""))
    assert (row["recording"], row["rig"], row["error"]) == (f"'{name}", f"'{name}", f"'{name} is torn") and float(row["size"]) == -2.5


def test_the_page_shows_each_rig_over_time_and_all_recordings():
    page = fleet_document("/data/<cranes>", some_rows(), "sheet.yaml").html()
    assert page.count("<svg") == 3  # gap and leakage of one rig, gap of the other
    assert page.count("<circle") == 2 * 3 + 3 + 2
    assert "pump_1.leakage: leakage ratio" in page and "rig_&lt;1&gt;" in page and "<cranes>" not in page and "torn, &lt;all&gt;" in page
    assert 'Gap, <span class="axis">multiples of the floor</span>: ' in page
    assert re.search(r'class="axis">20\d\d-\d\d-\d\d \d\d:\d\d<', fleet_document("x", some_rows()[:1], "").html())
    assert re.search(r'class="nowrap">20\d\d-\d\d-\d\d \d\d:\d\d:\d\d<', page)
    assert verdict(some_rows()) == "3 of 4 diagnosed recordings show a gap, on 1 of 2 rigs; 1 could not be diagnosed."
    failed = [row for row in some_rows() if row.error]
    named = [replace(row, rig="r") for row in failed]
    assert verdict(named) == "no recording has an answer, of 1 rig; 1 could not be diagnosed."
    unclear = [*some_rows(), Row("d", verdict="insufficient")]
    assert "3 of 4 diagnosed recordings" in verdict(unclear) and "; 1 does not allow an answer; 1 could not" in verdict(unclear)
    within = [replace(some_rows()[0], gap_before=0.8), *some_rows()[1:]]
    noise = "some signals show the cause, though all together are off by no more than noise."
    assert verdict(within) == f"{verdict(some_rows())} In 1 of those with a gap {noise}"
    assert verdict([within[0], within[3]]) == f"1 of 2 diagnosed recordings shows a gap, on 1 of 2 rigs. In the one with a gap {noise}"
    assert verdict([within[0]] * 2).endswith(f" show a gap, on 1 of 1 rig. In all with a gap {noise}")
    xs = [float(x) for x in re.findall(r'<circle cx="([\d.]+)"', page)]
    assert all(0.0 <= x <= 620.0 for x in xs)
    assert fleet_document("x", [Row("c", error="torn")], "").html().count("<svg") == 0


def test_charts_of_one_rig_have_one_axis_of_time():
    """The newest recording has a gap and no size."""
    rows = [*some_rows()[:3], Row("a/4", "rig_<1>", "2026-04-01T00:00:00Z", 600.0, "unknown", gap_before=3.0)]
    charts = re.findall(r"<svg.*?</svg>", fleet_document("x", rows, "").html(), re.DOTALL)
    ends = [re.findall(r'class="axis">(2026-\d\d-\d\d)<', chart) for chart in charts]
    assert len(charts) == 2 and ends[0] == ends[1] and (ends[0][0], ends[0][-1]) == ("2026-01-01", "2026-04-01")


def test_verdicts_have_the_words_of_a_gaps_own_page():
    rows = [Row("a", verdict="insufficient", sentence="The recordings allow no answer: x."), Row("b", verdict="unknown"),
            Row("c", verdict="no_gap")]
    page = fleet_document("x", rows, "").html()
    for said in ("Cannot tell", "Unknown cause", "No gap"):
        assert len(re.findall(rf">\s*{said}\s*<", page)) == 2, "in the overview and in the table"
    assert "insufficient" not in re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL)
    assert [row["verdict"] for row in csv.DictReader(as_csv(rows).splitlines())] == ["insufficient", "unknown", "no_gap"]


def test_rigs_whose_newest_recording_shows_a_gap_are_named_with_the_cause():
    old, new = (replace(some_rows()[0], recording=name, rig="crane_1", begin=f"2026-0{n}-01T00:00:00Z") for n, name in ((1, "a"), (2, "b")))
    assert newest_gaps([new, old]) == ["b, crane_1: explained, pump_1.leakage 90 %"]
    mended = replace(new, verdict="no_gap", effect="", probability=None)
    assert newest_gaps([old, mended]) == [] and newest_gaps([old, Row("b", "crane_1", new.begin, error="torn")])[0].startswith("a, crane_1")
    beside = replace(new, rig="", also="motor.iron_loss", verdict="ambiguous", effect="x | y")
    unknown = replace(new, recording="c", rig="", verdict="unknown", effect="unknown", probability=0.8)
    assert newest_gaps([beside, unknown]) == ["b: ambiguous, x | y 90 %, beside it motor.iron_loss", "c: unknown cause 80 %"]
    many = newest_gaps([replace(new, rig=f"crane_{n:02}") for n in range(12)])
    assert len(many) == 11 and many[9].startswith("b, crane_09: ") and many[10] == "and 2 more"


def test_where_no_rig_is_named_none_is_counted():
    rows = [replace(row, rig="") for row in some_rows()]
    assert verdict(rows) == "3 of 4 diagnosed recordings show a gap; 1 could not be diagnosed."
    assert verdict([row for row in rows if row.error]) == "no recording has an answer; 1 could not be diagnosed."
    assert "0 rigs" not in fleet_document("x", rows, "").html()


def test_the_table_says_below_a_row_why_there_is_no_answer_and_one_probability():
    told = "The gap is explained by x: it shrinks from 3.0 to 1.1 times the floor (probability 97 %)."
    rows = [*(replace(row, sentence=told, probability=0.999) if row.sentence else row for row in some_rows()),
            Row("d", verdict="insufficient", sentence="The recordings allow no answer: too short.")]
    page = fleet_document("x", rows, "").html()
    below = re.findall(r'<tr class="told"><th scope="row">([^<]*)</th>.*?</tr><tr class="below"><td colspan="9"><span>([^<]*)</span>', page)
    assert below == [("c", "torn, &lt;all&gt;"), ("d", "The recordings allow no answer: too short.")]
    assert "97 %" not in page and "times the floor." in page and "&gt; 99.5 %" in page
    assert ">1.50 ± 0.10</td>" in page and ">3.00 → 1.10</td>" in page


def test_sizes_are_in_the_units_that_people_read_in_table_and_chart():
    rows = [replace(some_rows()[0], effect="relief_valve.setting", parameter="opening_pressure", unit="Pa", size=155.8e5, size_std=0.9e5,
                    nominal=160.0e5)]
    page = fleet_document("x", rows, "").html()
    assert ">155.8 ± 0.9 bar</td>" in page and 'opening pressure, <span class="axis">bar</span>' in page and "15580000" not in page
    assert ": 155.8 ± 0.9 bar<" in page and "of 1 rig<" in page and verdict(rows).endswith("on 1 of 1 rig.")


def test_parquet(tmp_path):
    path = tmp_path / "deep" / "fleet.parquet"
    write_parquet(path, some_rows())
    table = pyarrow.parquet.read_table(path)
    assert table.column_names == list(COLUMNS) and table.column("size").to_pylist()[3] is None
    assert table.column("begin").to_pylist()[0].isoformat() == "2026-01-01T00:00:00+00:00"


class FakeClient:
    """What is used of distributed.Client; the worker of `b/bad` is lost."""

    def __init__(self, address, timeout):
        if address != "tcp://here:1":
            raise OSError("timed out")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def submit(self, function, found, settings, pure):
        future = Future()
        if found.name == "b/bad":
            future.set_exception(RuntimeError("worker lost"))
        else:
            future.set_result(function(found, settings))
        return future


def test_on_a_cluster(folder, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", types.SimpleNamespace(Client=FakeClient, as_completed=lambda futures: futures))
    rows, _ = diagnosed(folder, tmp_path / "results", cluster="tcp://here:1")
    assert rows["a/march"].verdict == "explained" and rows["b/bad"].error == "on the cluster: RuntimeError: worker lost"
    with pytest.raises(FleetError, match="--cluster tcp://there:1: no scheduler answers"):
        diagnosed(folder, tmp_path / "other", cluster="tcp://there:1")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(FleetError, match="pip install distributed"):
        diagnosed(folder, tmp_path / "other", cluster="tcp://here:1")


def test_the_verb_writes_table_and_page_and_says_what_failed(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fleet_run.Settings, "__init__", _with_fake(fleet_run.Settings.__init__))
    page = tmp_path / "fleet.html"
    out = folder / "out"
    assert main(["fleet", str(folder), "--out", str(out), "--jobs", "2", "--html", str(page)]) == 0
    said = capsys.readouterr().out
    assert "2 of 2 diagnosed recordings show a gap, on 1 of 1 rig; 3 could not be diagnosed.\n" in said and "b/bad: " in said
    assert "diagnosed.\n  a/march, rig_000: explained, pump_1.leakage 90 %\n" in said
    table = list(csv.DictReader((out / "fleet.csv").read_text().splitlines()))
    assert [row["recording"] for row in table] == ["a/april", "a/march", "b/bad", "b/crash", "b/torn/torn.mcap"]
    assert "<svg" in page.read_text()
    assert main(["fleet", str(folder), "--out", str(out), "--quiet", "--csv", str(tmp_path / "t.csv")]) == 0
    assert capsys.readouterr().out == "" and (tmp_path / "t.csv").read_text() == (out / "fleet.csv").read_text()


def test_what_warns_of_a_recording_is_told_beside_the_count():
    bar = "Careful: kpa: look as if given in bar. No gap: with its parameters"
    told = [remark(row) for row in (Row("a", error="torn"), Row("b", verdict="insufficient", sentence="The recordings allow no answer: x."),
                                    Row("c", verdict="no_gap", sentence=bar), Row("d", verdict="no_gap", sentence="No gap: with"))]
    assert told == ["torn", "The recordings allow no answer: x.", bar, ""]


def test_two_fleets_do_not_share_results(folder, tmp_path, capsys):
    with held(tmp_path / "out", ".fleet.lock", FleetError("busy")):
        assert main(["fleet", str(folder), "--out", str(tmp_path / "out"), "--quiet"]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert f"{tmp_path / 'out'}: another ddh-twin fleet writes its results there" in line


def test_an_interrupted_fleet_says_what_is_kept(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fleet_run.Settings, "__init__", _with_fake(fleet_run.Settings.__init__))
    asked = ["fleet", str(folder), "--out", str(tmp_path), "--quiet"]
    assert main(asked) == 0
    capsys.readouterr()

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(fleet_run, "diagnose_recording", interrupt)
    assert main([*asked, "--again"]) == 130
    said = capsys.readouterr().err
    assert re.search(rf"\d of 5 recordings are finished and kept in {tmp_path}/results; started again, it goes on", said)


def test_answers_of_other_versions_are_counted(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fleet_run.Settings, "__init__", _with_fake(fleet_run.Settings.__init__))
    asked = ["fleet", str(folder), "--out", str(tmp_path), "--jobs", "2"]
    assert main(asked) == 0 and "other versions" not in capsys.readouterr().out
    table = list(csv.DictReader((tmp_path / "fleet.csv").read_text().splitlines()))
    assert {row["version"] for row in table} == {version()}
    for name, older in (("a-april", {"version": "0.1+abc"}), ("a-march", {})):
        (file,) = (tmp_path / "results").glob(f"{name}-*.json")
        content = json.loads(file.read_text())
        del content["row"]["version"]
        file.write_text(json.dumps({**content, "row": content["row"] | older}))
    assert main([*asked, "--html", str(tmp_path / "fleet.html")]) == 0
    assert "answers of other versions: 1 of 0.1+abc, 1 of one that is not known; --again makes them anew\n" in capsys.readouterr().out
    assert "1 of 0.1+abc, 1 of one that is not known" in (tmp_path / "fleet.html").read_text()
    assert main([*asked, "--again"]) == 0 and "other versions" not in capsys.readouterr().out


@pytest.fixture
def two_rigs(tmp_path, second):
    """Recordings of three rigs and one without a name, and files of two of the rigs."""
    for name in ("crane_1", "crane_2", "crane_3", ""):
        write_recording(tmp_path / "fleet" / (name or "nameless"), replace(second, rig=replace(second.rig, rig_id=name)))
    files = [tmp_path / f"{name}.yaml" for name in ("crane_1", "crane_2")]
    for file in files:
        file.write_text(f"rig_id: {file.stem}\n")
    return tmp_path / "fleet", files


def asked_against(out):
    kept = [json.loads(file.read_text()) for file in (out / "results").iterdir()]
    return {one["recording"]: one["report"]["asked"]["rig"] for one in kept}


def test_each_recording_is_held_against_the_file_of_its_rig(two_rigs, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fleet_run.Settings, "__init__", _with_fake(fleet_run.Settings.__init__))
    folder, (first, other) = two_rigs
    out = tmp_path / "out"
    asked = ["fleet", str(folder), "--out", str(out), "--rig", str(first), "--rig", str(other), "--html", str(tmp_path / "f.html")]
    assert main(asked) == 0
    said = capsys.readouterr().out
    assert asked_against(out) == {"crane_1": str(first), "crane_2": str(other), "crane_3": None, "nameless": None}
    assert "  crane_3: Held against the reference sheet: none of the rig files is of crane_3.\n" in said
    assert "  nameless: Held against the reference sheet: the recording names no rig.\n" in said
    against = "2 of 4 recordings were held against the reference sheet: a machine that differs from it by design"
    assert against in said and against in (tmp_path / "f.html").read_text()
    assert "crane_1: " not in said.partition("(--rig)")[2] and "none of the rig files is of crane_3." in (tmp_path / "f.html").read_text()
    rows = {row["recording"]: row["sheet"] for row in csv.DictReader((out / "fleet.csv").open())}
    assert (rows["crane_1"], rows["crane_3"]) == (str(first), "reference sheet: none of the rig files is of crane_3")
    ran = []
    real = fleet_run.diagnose_recording
    monkeypatch.setattr(fleet_run, "diagnose_recording", lambda found, *rest: (ran.append(found.name), real(found, *rest))[1])
    assert main(asked) == 0 and ran == []
    other.write_text("rig_id: crane_2\npump_1:\n  leakage: {value: 2.0e-12, unit: m3/(s*Pa)}\n")
    assert main(asked) == 0 and ran == ["crane_2"], "what is of another file is not diagnosed again"
    assert main([*asked[:6], "--again"]) == 0 and set(asked_against(out).values()) == {str(first)}, "one file is for all"
    assert main([*asked[:4], "--again"]) == 0 and set(asked_against(out).values()) == {None}
    assert {row["sheet"] for row in csv.DictReader((out / "fleet.csv").open())} == {"reference sheet"}
    assert "4 of 4 recordings were held against the reference sheet: a machine that differs" in capsys.readouterr().out


@pytest.mark.parametrize(("content", "words"), [
    ("rig_id: crane_1\n", "crane_1.yaml and {other} both have the rig_id crane_1; give one of them"),
    ("cylinder:\n  stroke: {value: 0.3, unit: m}\n", "{other} has no rig_id of its own; of several rig files each is for")])
def test_of_several_rig_files_each_has_a_rig_id_of_its_own(content, words, two_rigs, capsys):
    folder, (first, other) = two_rigs
    other.write_text(content)
    assert main(["fleet", str(folder), "--rig", str(first), "--rig", str(other)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words.format(other=other) in line


def _with_fake(real):
    def made(self, longest=60.0, command=FAKE):
        real(self, longest, command)

    return made


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["/nowhere"], "/nowhere: there is no such folder"),
        ([".", "--jobs", "0"], "'0' is no whole number from 1 to 256"),
        ([".", "--rig", "/nowhere.yaml"], "/nowhere.yaml"),
        ([".", "--out", __file__], "is no folder"),
        ([".", "--out", "/dev/null/results"], "cannot be written: /dev/null is no folder"),
        ([""], "FOLDER is ''"),
        ([".", "--out", " "], "--out is ' '"),
    ],
)
def test_arguments_that_cannot_be_used(arguments, words, capsys):
    try:
        code = main(["fleet", *arguments])
    except SystemExit as left:
        code = left.code
    assert code == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert words in line
