"""Verbs at work on the example recording."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.cli.benchmarks import Figure
from ddh_twin_py.cli.main import main
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import RigInfo, Stream
from ddh_twin_py.telemetry.signals import DRIVE_FIELDS


def test_replay_writes_report_and_json_that_agree(paper_cycle_bag, tmp_path, capsys):
    page, numbers = tmp_path / "a" / "report.html", tmp_path / "a" / "report.json"
    assert main(["replay", str(paper_cycle_bag), "--html", str(page), "--json", str(numbers)]) == 0
    out, err = capsys.readouterr()
    data = json.loads(numbers.read_text())
    assert data["verdict"] in " ".join(out.split()) and data["verdict"] in page.read_text()
    assert len(data["temperatures"]) == 9 and len(data["signals"]) == 9
    assert "warning" not in err
    # the recording is of the nominal rig: the free run is close to the sensors' noise
    assert all(row["free_in_noise"] < 3.0 for row in data["signals"])
    assert page.stat().st_size < 2_000_000


def test_replay_is_the_same_twice(paper_cycle_bag, capsys):
    runs = []
    for _ in range(2):
        assert main(["replay", str(paper_cycle_bag), "--json", "-", "--quiet"]) == 0
        data = json.loads(capsys.readouterr().out)
        data["end_matter"].pop("computing_time_s")
        runs.append(data)
    assert runs[0] == runs[1]


def test_leaving_sensors_out_is_a_harder_test(paper_cycle_bag, tmp_path, capsys):
    short = tmp_path / "short"
    write_recording(short, read_recording(paper_cycle_bag).between(0.0, 40.0))
    assert main(["replay", str(short), "--json", "-", "--leave-one-out"]) == 0
    rows = json.loads(capsys.readouterr().out)["temperatures"]
    assert all(row["rms_left_out_K"] is not None for row in rows)
    assert all(row["std_left_out_K"] > row["fused_final_std_K"] for row in rows)


def test_simulate_then_info_then_replay(tmp_path, capsys):
    first, second, other = (tmp_path / name for name in ("first", "second", "other"))
    for bag, seed in ((first, "5"), (second, "5"), (other, "6")):
        assert main(["simulate", "paper_cycle", "-o", str(bag), "--seed", seed, "--duration", "20"]) == 0
    a, b, c = (read_recording(bag) for bag in (first, second, other))
    for (topic, one), (_, same), (_, another) in zip(a.streams(), b.streams(), c.streams(), strict=True):
        np.testing.assert_array_equal(one.values, same.values, err_msg=topic)
        np.testing.assert_array_equal(one.time, same.time, err_msg=topic)
        assert not np.array_equal(one.values[:, 0], another.values[:, 0]) or topic == "drive/telemetry"
    assert a.duration == pytest.approx(20.0, abs=0.6)
    capsys.readouterr()
    assert main(["info", str(first), "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rig"]["rig_id"] == "simulated_5"
    assert {stream["topic"] for stream in told["streams"]} >= {"drive/telemetry", "temperature/tank_oil"}
    rates = {stream["topic"]: stream["rate_Hz"] for stream in told["streams"]}
    assert rates["drive/telemetry"] == pytest.approx(100.0, rel=0.01)
    assert main(["replay", str(first), "--json", "-"]) == 0


def test_simulate_tells_of_its_bag_what_info_tells_of_it(tmp_path, capsys):
    bag = str(tmp_path / "bag")
    assert main(["simulate", "paper_cycle", "-o", bag, "--duration", "2", "--quiet", "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert main(["info", bag, "--json", "-"]) == 0
    assert told == json.loads(capsys.readouterr().out) and told["path"] == bag and told["namespace"] == "/ddh"


def test_a_folder_with_the_name_of_a_duty_hides_none(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("mixed", "other"):
        (tmp_path / name).mkdir()
    assert main(["simulate", "mixed", "-o", "bag", "--duration", "1", "--quiet"]) == 0
    assert main(["simulate", "other", "-o", "none", "--duration", "1", "--quiet"]) == 2
    assert "other: cannot be read as a duty file: Is a directory" in capsys.readouterr().err


def test_the_same_rig_is_recorded_again_at_another_time(tmp_path):
    first, again = tmp_path / "first", tmp_path / "again"
    command = ["simulate", "paper_cycle", "--seed", "5", "--duration", "20", "--quiet", "-o"]
    assert main([*command, str(first)]) == 0
    assert main([*command, str(again), "--noise-seed", "6", "--begin", "2026-01-02T09:00:00+01:00"]) == 0
    a, b = read_recording(first), read_recording(again)
    assert b.epoch_ns - a.epoch_ns == pytest.approx(32 * 3600e9, abs=1e6)
    pressure, other = (recording.hydraulic.column("pressure_piston_side") for recording in (a, b))
    assert not np.any(pressure == other)  # noise of its own
    noise = load_rig().sensors["pressure"].noise
    assert np.mean(pressure - other) == pytest.approx(0.0, abs=0.2 * noise)  # of the same rig, with the same zero
    assert np.std(pressure - other) == pytest.approx(np.sqrt(2.0) * noise, rel=0.1)


def test_info_holds_channels_against_each_other(paper_cycle_bag, tmp_path, capsys):
    recording = read_recording(paper_cycle_bag).between(0.0, 60.0)
    oil = recording.temperatures["tank_oil"]
    degf = replace(oil, values=np.column_stack([1.8 * (oil.values[:, 0] - 273.15) + 32.0 + 273.15, oil.values[:, 1]]))
    bag = write_recording(tmp_path / "bag", replace(recording, temperatures={**recording.temperatures, "tank_oil": degf}))
    assert main(["info", str(bag)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "temperature/tank_oil temperature looks as if given in degF" in said and "nothing wrong was found" not in said


def test_info_names_what_is_wrong(paper_cycle_bag, tmp_path, capsys):
    recording = read_recording(paper_cycle_bag).between(0.0, 20.0)
    recording.hydraulic.values[500:600, 0] = np.nan
    del recording.temperatures["ambient"]
    bag = tmp_path / "odd"
    write_recording(bag, recording)
    assert main(["info", str(bag)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "pressure_piston_side" in out and "temperature/ambient" in out and "warning" in out
    for options in (["--quiet"], ["--json", "-"]):
        assert main(["info", str(bag), *options]) == 0
        out, err = capsys.readouterr()
        assert re.search("^warning: .*pressure_piston_side", err, re.MULTILINE) and "warning:" not in out
    assert main(["replay", str(bag), "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert "pressure_piston_side" in err and "100" in err
    assert any("Ambient 23" in line for line in json.loads(out)["end_matter"]["assumptions"])


def test_info_prints_names_as_they_were_given(paper_cycle_bag, tmp_path, capsys):
    recording = read_recording(paper_cycle_bag).between(0.0, 2.0)
    for rig_id in ("press [old]", "press[/x]", "press :bug:"):
        bag = write_recording(tmp_path / rig_id[5:].replace("/", ""), replace(recording, rig=RigInfo(rig_id, "ISO VG 32", 100.0)))
        assert main(["info", str(bag)]) == 0
        assert f"rig: {rig_id}, ISO VG 32" in capsys.readouterr().out


def test_what_a_log_never_had_is_not_measured_and_not_rejected(paper_cycle_bag, tmp_path, capsys):
    recording = read_recording(paper_cycle_bag).between(0.0, 20.0)
    recording.drive.values[:, DRIVE_FIELDS.index("voltage")] = np.nan
    recording.hydraulic.values[500:600, 0] = np.nan
    bag = write_recording(tmp_path / "log", recording)
    assert main(["info", str(bag)]) == 0
    said = capsys.readouterr().out
    rejected = dict(re.findall(r"^(drive|hydraulics)/telemetry +\d+ +\S+ +\S+ +\S+ *(\d*) *$", said, re.MULTILINE))
    assert rejected == {"drive": "", "hydraulics": "100"} and "not measured: drive/telemetry voltage\n" in said


def test_a_ratio_above_one_is_better():
    assert Figure("t", 1.0, "s", 2.0).ratio == 2.0
    assert Figure("r", 6.0, "x", 3.0, smaller=False).ratio == 2.0
    assert Figure("t", 1.0, "s", None).ratio is None and Figure("lost", 0, "", 0.0).ratio is None
    assert set(Figure("t", 1.0, "s", 2.0).row()) == {"name", "value", "unit", "against", "ratio", "source"}


def test_two_machines_on_one_topic_are_one_line(paper_cycle_bag, tmp_path, capsys):
    recording = read_recording(paper_cycle_bag).between(0.0, 40.0)
    drive = recording.drive
    # as they arrive: one sample of this machine, one of another whose clock is an hour behind
    time = np.repeat(drive.time, 2)
    time[1::2] -= 3600.0
    both = Stream(time, np.repeat(drive.values, 2, axis=0), drive.fields)
    bag = tmp_path / "two"
    write_recording(bag, replace(recording, drive=both))
    assert main(["replay", str(bag), "--quiet"]) == 2
    err = capsys.readouterr().err
    assert len(err.splitlines()) == 1 and "do two machines publish on the same topic?" in err and str(bag) in err
