"""Tables and bags hold what the replay says, in the units that they name."""

import csv
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from ddh_twin_py.bags.damage import truncate
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import BagWriter, write_recording
from ddh_twin_py.cli.main import main
from ddh_twin_py.exchange.bulk_messages import BulkMessages, Numbers
from ddh_twin_py.exchange.import_log import import_logs
from ddh_twin_py.exchange.mapping import read_mapping
from ddh_twin_py.exchange.output_bag import write_output_bag
from ddh_twin_py.exchange.replay_columns import replay_columns
from ddh_twin_py.exchange.tables import write_csv, write_parquet
from ddh_twin_py.exchange.telemetry_tables import write_telemetry
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.report.replay.agreement import measured_values
from ddh_twin_py.sources.raw_bag import RawBag
from ddh_twin_py.telemetry.signals import signal_named
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore


@pytest.fixture(scope="module")
def columns(replayed):
    return {column.name: column for column in replay_columns(replayed)}


def test_columns_are_the_replays(replayed, columns):
    tank = NODES.index("tank_oil")
    np.testing.assert_allclose(columns["estimate/tank_oil/temperature"].values + 273.15, replayed.fused[:, tank])
    band = columns["estimate/tank_oil/upper"].values - columns["estimate/tank_oil/lower"].values
    np.testing.assert_allclose(band, 4.0 * replayed.fused_std[:, tank])
    np.testing.assert_array_equal(
        columns["pressure_rod_side/measured"].values, measured_values(replayed, signal_named("pressure_rod_side")))
    np.testing.assert_array_equal(columns["current/soft_sensor"].values, replayed.soft["current"])
    assert "speed/soft_sensor" not in columns  # an input of the soft sensor
    assert np.diff(columns["stamp"].values).tolist() == [50_000_000] * (replayed.time.size - 1)
    assert all(column.values.shape == replayed.time.shape and column.unit and column.about for column in columns.values())


def test_a_reading_stands_in_its_interval(replayed, columns):
    found = replayed.sensors["tank_oil"]
    values = columns["temperature/tank_oil/measured"].values
    assert np.isfinite(values).sum() == found.measured.size
    rows = np.flatnonzero(np.isfinite(values))
    assert ((replayed.time[rows] >= found.time) & (replayed.time[rows] - found.time < 0.05 + 1e-9)).all()


def test_csv_and_parquet_hold_the_same(replayed, columns, tmp_path):
    several = list(columns.values())
    write_csv(tmp_path / "a.csv", several)
    write_parquet(tmp_path / "a.parquet", several, {"rig_file": replayed.rig.file})
    with open(tmp_path / "a.csv", newline="") as stream:
        heading, *rows = csv.reader(stream)
    table = pyarrow.parquet.read_table(tmp_path / "a.parquet")
    assert heading == [column.heading for column in several] and table.column_names == [column.name for column in several]
    assert json.loads(table.schema.metadata[b"ddh_twin"]) == {"rig_file": replayed.rig.file}
    for i, column in enumerate(several):
        told = np.array([float(row[i] or "nan") for row in rows])
        kept = table.column(i).to_numpy().astype(float)
        np.testing.assert_array_equal(np.isnan(kept), np.isnan(column.values.astype(float)), err_msg=column.name)
        np.testing.assert_allclose(told, kept, rtol=1e-6, atol=1e-300, err_msg=column.name)
        assert table.schema.field(i).metadata[b"unit"].decode() == column.unit
    assert [int(row[0]) for row in rows] == several[0].values.tolist()  # ns, every digit


def test_the_bag_is_read_by_others_and_holds_recording_and_outputs(replayed, short_bag, tmp_path):
    assert write_output_bag(tmp_path / "out", short_bag, replayed) == []
    count, stamps = {}, []
    with AnyReader([tmp_path / "out"], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        for connection, log_time, raw in reader.messages():
            count[connection.topic] = count.get(connection.topic, 0) + 1
            stamps.append(log_time)
            if connection.topic == "/ddh/estimate/tank_oil":
                estimate = reader.deserialize(raw, connection.msgtype)
            elif connection.topic == "/ddh/temperature/estimates":
                array = reader.deserialize(raw, connection.msgtype)
            elif connection.topic == "/ddh/hydraulics/prediction":
                state = reader.deserialize(raw, connection.msgtype)
            elif connection.topic == "/ddh/hydraulics/residuals":
                residuals = reader.deserialize(raw, connection.msgtype)
    n, tank = replayed.time.size, NODES.index("tank_oil")
    assert stamps == sorted(stamps)
    assert {count[f"/ddh/{topic}"] for topic in ("estimate/tank_oil", "temperature/estimates", "hydraulics/state")} == {n}
    assert count["/ddh/hydraulics/residuals"] == 2 * n and count["/ddh/smoothed/tank_oil"] == replayed.smoothed_row.size
    assert estimate.temperature + 273.15 == pytest.approx(replayed.fused[-1, tank])
    assert estimate.variance == pytest.approx(replayed.fused_std[-1, tank] ** 2) and estimate.header.frame_id == "tank_oil"
    entry = array.estimates[tank]
    assert entry.location == "tank_oil" and entry.predicted + 273.15 == pytest.approx(replayed.free_temperature[-1, tank])
    assert entry.measured == pytest.approx(replayed.sensors["tank_oil"].measured[-1] - 273.15) and 0.0 <= entry.measured_age < 0.6
    assert state.mode == "free_run" and state.pressure_rod_side == replayed.free["pressure_rod_side"][-1]
    assert state.telemetry_known and state.temperature[tank] + 273.15 == pytest.approx(replayed.free_temperature[-1, tank])
    assert residuals.source == "free_run" and residuals.residuals[0].signal == "speed"
    assert residuals.residuals[0].measured - residuals.residuals[0].predicted == pytest.approx(residuals.residuals[0].residual)
    before, after = read_recording(short_bag), read_recording(tmp_path / "out")
    for (topic, one), (_, same) in zip(before.streams(), after.streams(), strict=True):
        np.testing.assert_array_equal(one.values, same.values, err_msg=topic)


def test_a_bag_that_cannot_be_written_leaves_the_recording_closed(replayed, short_bag, tmp_path, monkeypatch):
    closed = []
    monkeypatch.setattr(RawBag, "close", lambda bag: closed.append(bag.path))
    monkeypatch.setattr(BagWriter, "write_raw", lambda *_: (_ for _ in ()).throw(BagError("full")))
    with pytest.raises(BagError, match="full"):
        write_output_bag(tmp_path / "out", short_bag, replayed)
    assert closed == [str(short_bag)]


def test_outputs_of_an_earlier_twin_give_way(replayed, short_bag, tmp_path):
    write_output_bag(tmp_path / "first", short_bag, replayed)
    write_output_bag(tmp_path / "second", tmp_path / "first", replayed)
    sizes = []
    for name in ("first", "second"):
        with AnyReader([tmp_path / name], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
            sizes.append({connection.topic: connection.msgcount for connection in reader.connections})
    assert sizes[0] == sizes[1]


def test_bulk_messages_are_those_of_the_serialiser():
    bulk = BulkMessages("ddh_msgs/msg/HydraulicState", "x", {
        "mode": "m", "losses": [{"component": "pump_1"}, {"component": "a longer name"}], "heat_nodes": ["one"], "heat": Numbers(3),
        "flow_paths": [], "flow": np.empty(0), "temperature_nodes": [], "temperature": np.empty(0),
    })
    values = {name: float(i) for i, name in enumerate(bulk.names)} | {"telemetry_known": True}
    values |= {"losses.power": np.array([[7.0, 8.0]]), "heat": np.array([[1.0, 2.0, 3.0]])}
    (message,) = bulk.compose(np.array([12_000_000_034]), values)
    from ddh_twin_py.bags.message_types import know

    store = know("ddh_msgs/msg/HydraulicState")
    read = store.deserialize_cdr(message, "ddh_msgs/msg/HydraulicState")
    assert bytes(store.serialize_cdr(read, "ddh_msgs/msg/HydraulicState")) == message
    assert (read.header.stamp.sec, read.header.stamp.nanosec, read.header.frame_id, read.mode) == (12, 34, "x", "m")
    assert [loss.power for loss in read.losses] == [7.0, 8.0] and read.heat.tolist() == [1.0, 2.0, 3.0]
    assert read.pump_1_flow == values["pump_1_flow"] and read.telemetry_known is True
    with pytest.raises(KeyError, match="'speeed' is none of its values"):
        bulk.compose(np.array([0]), values | {"speeed": 1.0})
    with pytest.raises(KeyError, match="'speed' is not given"):
        bulk.compose(np.array([0]), {name: value for name, value in values.items() if name != "speed"})


def test_the_verb_writes_what_was_asked_for(short_bag, tmp_path, capsys):
    csv_file, parquet, bag, samples = (tmp_path / name for name in ("a/t.csv", "t.parquet", "bag", "samples"))
    argv = ["export", str(short_bag), "--csv", str(csv_file), "--parquet", str(parquet), "--mcap", str(bag), "--telemetry", str(samples)]
    assert main([*argv, "--json", "-", "--interval", "0.2", "--no-smoothing", "--quiet"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rows"] == len(csv_file.read_text().splitlines()) - 1 == pyarrow.parquet.read_metadata(parquet).num_rows
    assert told["rows"] in (150, 151)  # 30 s
    assert {"data_split", "rig_file", "assumptions", "versions"} <= told["end_matter"].keys()
    assert (bag / "metadata.yaml").is_file() and (samples / "mapping.yaml").is_file()
    assert not any("smoothed" in column["name"] for column in told["columns"])
    assert main(["export", str(short_bag)]) == 2
    assert "nothing to write: say --csv" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["export", str(short_bag), "--mcap", str(bag)])
    assert f"'{bag}' exists; nothing is overwritten" in capsys.readouterr().err
    assert Path(csv_file).read_text().startswith("stamp [ns],time [s],speed_command/measured [rad/s],")


@pytest.mark.parametrize("option", ["--mcap", "--telemetry"])
def test_of_a_folder_that_does_not_fit_on_the_disk_nothing_is_left(short_bag, tmp_path, monkeypatch, capsys, option):
    full = OSError(28, "No space left on device")
    monkeypatch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(full))
    target = tmp_path / "tiny" / "z"
    assert main(["export", str(short_bag), option, str(target), "--interval", "0.2", "--no-smoothing", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert f"error: {target}" in said and "No space left on device" in said
    assert list(tmp_path.iterdir()) == []


def test_a_mapping_is_read_whatever_the_recording_is_called(short_bag, tmp_path):
    recording = replace(read_recording(short_bag).between(0.0, 1.0), path="a\nb: [c")
    *logs, mapping = write_telemetry(tmp_path / "samples", recording)
    assert len(import_logs(logs, read_mapping(mapping)).drive) == len(recording.drive)


def test_samples_of_a_recording_that_was_cut_off_come_with_a_warning(short_bag, tmp_path, capsys):
    bag = write_recording(tmp_path / "cut", read_recording(short_bag).between(0.0, 2.0))
    truncate(bag, 0.5)
    assert main(["export", str(bag), "--telemetry", str(tmp_path / "half"), "--quiet"]) == 0
    assert "has no end, the recorder was stopped hard: it is whole up to byte" in capsys.readouterr().err
    assert list((tmp_path / "half").glob("*.csv"))


def test_a_rig_file_of_another_rig_is_told(short_bag, tmp_path, capsys):
    (tmp_path / "crane_1.yaml").write_text("rig_id: crane_1\n")
    options = ["--json", "-", "--interval", "0.2", "--no-smoothing", "--quiet"]
    another = "the rig file describes crane_1 and the recording is of rig_000"
    for rig, said in ([], []), (["--rig", str(tmp_path / "crane_1.yaml")], [another]):
        assert main(["export", str(short_bag), *options, *rig]) == 0
        out, err = capsys.readouterr()
        assert json.loads(out)["doubts"] == said
        assert err.splitlines() == [f"warning: {short_bag}: {text}" for text in said]
