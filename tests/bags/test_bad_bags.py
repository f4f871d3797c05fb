"""Bags that are not as they should be: each a message that names file, topic and value."""

import os
import re
import shutil
import sqlite3
import struct
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from ddh_twin_py.bags import damage
from ddh_twin_py.bags.compression import unpack_chunk, zstd
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.mcap_storage import CHUNK, DATA_END, FOOTER, MAGIC
from ddh_twin_py.bags.message_types import telemetry_typestore
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import BagWriter, write_recording
from ddh_twin_py.sources.raw_bag import RawBag
from ddh_twin_py.telemetry.recording import RigInfo
from ddh_twin_py.telemetry.screening.screening import screen_recording
from ddh_twin_py.telemetry.signals import BESIDE_SENSORS
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from support.bag_rows import write_rows

DRIVE = "/ddh/drive/telemetry"


def refusal(path, **options):
    """The one line with which a bag is refused."""
    with pytest.raises(BagError) as caught:
        read_recording(path, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert str(path) in message
    return message


def rewritten(bag, target, types=None, topic=lambda t: t, storage=StoragePlugin.MCAP):
    """The bag again, with other message types (topic: store and name) or topic names."""
    with AnyReader([bag]) as reader, Writer(target, version=9, storage_plugin=storage) as writer:
        ids = {}
        for c in reader.connections:
            store, name = (types or {}).get(c.topic, (reader.typestore, c.msgtype))
            ids[c.id] = writer.add_connection(topic(c.topic), name, typestore=store)
        for connection, at, raw in reader.messages():
            writer.write(ids[connection.id], at, raw)
    return target


def messages(bag):
    with AnyReader([bag]) as reader:
        yield from reader.messages()


def type_of(name, text):
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(text, name))
    return store, name


# No bag at all


def test_nothing_there(tmp_path):
    assert "does not exist" in refusal(tmp_path / "absent")


def test_a_link_to_nowhere_is_said_to_be_one(tmp_path):
    link = tmp_path / "dangling.mcap"
    link.symlink_to("gone.mcap")
    told = f"{link} does not exist; it is a link to gone.mcap, which does not exist"
    assert refusal(link) == told and refusal(tmp_path) == told


def test_a_link_to_itself_is_said_to_be_one(tmp_path):
    link = tmp_path / "round"
    link.symlink_to("round")
    assert refusal(link) == f"{link} does not exist; it is a link to round, which leads back to it"


@pytest.mark.parametrize("metadata", [False, True])
def test_a_pipe_is_no_bag_and_no_file_of_one(tmp_path, bag, metadata):
    pipe = tmp_path / "piped" / "field.mcap"
    pipe.parent.mkdir()
    os.mkfifo(pipe)
    if metadata:
        shutil.copy(bag / "metadata.yaml", pipe.parent)
    assert refusal(pipe) == f"{pipe} is no bag but a named pipe; a bag is a rosbag2 folder or one .mcap or .db3 file"
    assert refusal(pipe.parent) == f"{pipe} is no file of a bag but a named pipe; a regular file is needed"


def test_a_folder_named_as_a_file_of_a_bag_is_said_to_be_one(tmp_path):
    (tmp_path / "x.mcap").mkdir()
    assert refusal(tmp_path) == f"{tmp_path / 'x.mcap'} is no file of a bag but a folder; a regular file is needed"


def test_a_folder_that_is_no_bag(tmp_path):
    (tmp_path / "notes.txt").write_text("no bag")
    assert "is no bag: the folder has no metadata.yaml and no .mcap or .db3 file" in refusal(tmp_path)


def test_a_case_folder_names_its_bags(tmp_path, short):
    for name in ("field", "validation"):
        write_recording(tmp_path / name, short)
    assert f"give {tmp_path / 'field'} or {tmp_path / 'validation'}" in refusal(tmp_path)


def test_a_file_that_may_not_be_read(bag, monkeypatch):
    allowed = Path.open

    def deny(path, *args, **options):
        if path.suffix == ".mcap":
            raise PermissionError(13, "Permission denied", str(path))
        return allowed(path, *args, **options)

    monkeypatch.setattr(Path, "open", deny)
    assert "field.mcap cannot be read: Permission denied" in refusal(bag)
    with pytest.raises(BagError, match=r"field\.mcap cannot be read: Permission denied"):
        RawBag(bag)


def test_a_file_that_is_no_bag(tmp_path):
    path = tmp_path / "data.csv"
    path.write_text("1,2,3")
    assert "ends in '.csv', not in .mcap or .db3" in refusal(path)


@pytest.mark.parametrize("suffix", ["mcap", "db3"])
def test_a_file_with_other_contents(tmp_path, suffix):
    path = tmp_path / f"data.{suffix}"
    path.write_bytes(b"PK\3\4 this is something else" * 100)
    message = refusal(path)
    assert "is no MCAP file: its first bytes are 50 4b" in message or "is no SQLite3 file of rosbag2" in message


@pytest.mark.parametrize("suffix", ["mcap", "db3"])
def test_an_empty_file(tmp_path, suffix):
    path = tmp_path / f"data.{suffix}"
    path.touch()
    assert "is empty: 0 bytes" in refusal(path)


def test_a_bag_without_messages(tmp_path):
    with BagWriter(tmp_path / "empty"):
        pass
    assert "holds no messages" in refusal(tmp_path / "empty")


def test_a_bag_of_which_no_listed_message_can_be_read_is_damaged_and_not_empty(tmp_path):
    with BagWriter(tmp_path / "empty"):
        pass
    metadata = tmp_path / "empty" / "metadata.yaml"
    entry = {"topic_metadata": {"name": "/ddh/drive/telemetry", "type": "ddh_msgs/msg/DriveTelemetry", "serialization_format": "cdr",
                                "offered_qos_profiles": [], "type_description_hash": ""}, "message_count": 2700}
    content = yaml.safe_load(metadata.read_text())
    content["rosbag2_bagfile_information"]["topics_with_message_count"] = [entry]
    metadata.write_text(yaml.safe_dump(content))
    assert "is damaged: its metadata.yaml lists 2700 messages, of which none can be read" in refusal(tmp_path / "empty")


def test_a_bag_without_telemetry(tmp_path, bag):
    other = rewritten(bag, tmp_path / "other", topic=lambda t: t.replace("/ddh/", "/arm/x_"))
    message = refusal(other)
    assert "has no telemetry: expected topics such as /ddh/drive/telemetry; it has /arm/x_" in message


# metadata.yaml


def test_metadata_missing_is_recovered(bag, short):
    (bag / "metadata.yaml").unlink()
    read = read_recording(bag)
    (finding,) = read.findings
    assert finding.severity == "warning"
    total = 1 + sum(len(s) for _, s in short.streams())
    assert f"has no metadata.yaml, the recorder was stopped hard; recovered {total} messages, 12.0 s" in finding.message
    assert len(read.drive) == len(short.drive)


@pytest.mark.parametrize(("text", "why"), [
    ("rosbag2_bagfile_information: [", "is not YAML (line 1): a bracket is not closed"),
    ("a: !!int ''\n", "is not YAML (line 1): '' is no int"),
    ("rosbag2_bagfile_information: {}\nrosbag2_bagfile_information: {}\n", "rosbag2_bagfile_information: given twice, in lines 1 and 2"),
    ("", "is empty; a description of a bag is a mapping of entries"),
    ("- a\n", "holds a list; a description of a bag is a mapping of entries"),
    ("rosbag2_bagfile_information:\n", "rosbag2_bagfile_information: is empty; a description of a bag is a mapping of entries"),
    ("rosbag2_bagfile_information: {storage_identifier: mcap, topics_with_message_count: }",
     "topics_with_message_count holds nothing, a list of topics is needed"),
    ("rosbag2_bagfile_information: {storage_identifier: mcap, topics_with_message_count: [], relative_file_paths: [1]}",
     "relative_file_paths holds [1], a list of names is needed"),
    ("bag: 1\n", "no entry 'rosbag2_bagfile_information'"),
])
def test_metadata_that_is_no_yaml_is_recovered(bag, short, text, why):
    (bag / "metadata.yaml").write_text(text)
    read = read_recording(bag)
    assert f"has a metadata.yaml that cannot be used ({why}); recovered" in read.findings[0].message
    assert len(read.drive) == len(short.drive)


def test_metadata_that_is_all_there_is_says_what_is_wrong_with_it(tmp_path):
    (tmp_path / "metadata.yaml").touch()
    with pytest.raises(BagError) as error:
        read_recording(tmp_path)
    assert str(error.value) == (f"{tmp_path}/metadata.yaml cannot be used (is empty; a description of a bag is a mapping of entries) "
                                "and the folder has no .mcap or .db3 file")


@pytest.mark.parametrize(("entry", "value"), [("message_count", "lots"), ("message_count", float("inf")), ("message_count", float("nan")),
                                              ("type", [1]), ("type_description_hash", [1])])
def test_metadata_of_a_wrong_type_is_recovered(bag, short, entry, value):
    path = bag / "metadata.yaml"
    content = yaml.safe_load(path.read_text())
    topic = content["rosbag2_bagfile_information"]["topics_with_message_count"][0]
    (topic if entry == "message_count" else topic["topic_metadata"])[entry] = value
    path.write_text(yaml.safe_dump(content))
    read = read_recording(bag)
    assert "has a metadata.yaml that cannot be used" in read.findings[0].message and len(read.drive) == len(short.drive)
    name = topic["topic_metadata"]["name"]
    assert entry != "message_count" or f"message_count of {name} is " in read.findings[0].message
    assert "invalid literal" not in read.findings[0].message


def test_metadata_of_an_endless_duration_is_lived_with(bag, short):
    path = bag / "metadata.yaml"
    content = yaml.safe_load(path.read_text())
    content["rosbag2_bagfile_information"]["duration"]["nanoseconds"] = float("inf")
    path.write_text(yaml.safe_dump(content))
    assert len(read_recording(bag).drive) == len(short.drive)


def test_rows_of_sqlite_that_are_no_messages_are_left_out_and_told(tmp_path, short):
    bag = write_recording(tmp_path / "odd", short)
    rewritten(bag, tmp_path / "lite", storage=StoragePlugin.SQLITE3)
    (file,) = (tmp_path / "lite").glob("*.db3")
    with sqlite3.connect(file) as database:
        database.execute("update messages set data = 'text' where id = 5")
        database.execute("update messages set timestamp = 'noon' where id = 6")
    read = read_recording(tmp_path / "lite")
    assert any("2 of its messages have no whole number as time or no bytes as content" in f.message for f in read.findings)


def test_metadata_without_an_entry_is_recovered(bag):
    text = (bag / "metadata.yaml").read_text().replace("relative_file_paths", "paths")
    (bag / "metadata.yaml").write_text(text)
    assert "no entry 'relative_file_paths'" in read_recording(bag).findings[0].message


def test_named_file_missing(bag):
    (bag / "field.mcap").unlink()
    assert "has none of the files that its metadata.yaml names: field.mcap" in refusal(bag)


def test_renamed_file_is_found(bag, short):
    (bag / "field.mcap").rename(bag / "renamed.mcap")
    read = read_recording(bag)
    assert "lacks the file field.mcap that metadata.yaml names" in read.findings[0].message
    assert len(read.drive) == len(short.drive)


def told_by_metadata(bag, change):
    """What is said of a bag whose metadata.yaml was changed, by all that read or play it."""
    path = bag / "metadata.yaml"
    tree = yaml.safe_load(path.read_text())
    change(tree["rosbag2_bagfile_information"])
    path.write_text(yaml.safe_dump(tree))
    findings = read_recording(bag).warnings
    assert {finding.severity for finding in findings} <= {"warning"}
    played = RawBag(bag)
    assert [f"{bag} {note}" for note in played.notes] == [finding.message.removesuffix("; all of them are read") for finding in findings]
    return [finding.message for finding in findings]


def test_metadata_with_another_number_of_messages_is_told_with_the_real_one(bag, short):
    def change(information):
        (drive,) = (entry for entry in information["topics_with_message_count"] if entry["topic_metadata"]["name"] == DRIVE)
        drive["message_count"] = 7

    assert told_by_metadata(bag, change) == [
        f"{bag} has a metadata.yaml in which message_count of {DRIVE} is 7 and the bag holds {len(short.drive)}; all of them are read"]


def test_metadata_with_other_totals_or_without_a_topic_is_told(bag):
    total = sum(1 for _ in messages(bag))
    (said,) = told_by_metadata(bag, lambda information: information.update(message_count=3))
    assert f"in which message_count is 3 and the bag holds {total};" in said
    (said,) = told_by_metadata(bag, lambda information: information.update(files=[{"message_count": 5}], message_count=total))
    assert f"in which message_count of all files is 5 and the bag holds {total};" in said
    (said,) = told_by_metadata(bag, lambda information: information.update(files=[], topics_with_message_count=[]))
    assert said.count("topics_with_message_count does not list") == 3 and " more; all of them are read" in said


def test_counts_of_a_bag_that_holds_fewer_are_named(bag, short):
    path = bag / "metadata.yaml"
    path.write_text(path.read_text().replace(f"message_count: {len(short.drive)}\n", "message_count: 99999\n"))
    (finding,) = read_recording(bag).warnings
    assert finding.severity == "error" and f"message_count of {DRIVE} is 99999 and the bag holds {len(short.drive)}" in finding.message


@pytest.mark.parametrize("absolute", [False, True])
def test_a_file_outside_of_the_bag_is_read_and_told(tmp_path, bag, short, absolute):
    other = write_recording(tmp_path / "other", short)
    name = str(other / "other.mcap") if absolute else "../other/other.mcap"
    damage.storage_file(bag).unlink()
    (said,) = told_by_metadata(bag, lambda information: information.update(relative_file_paths=[name]))
    assert said == (f"{bag} has a metadata.yaml in which relative_file_paths names {name!r}, which lies outside of the bag; "
                    f"{other / 'other.mcap' if absolute else bag / name} is read")


@pytest.mark.parametrize(("entries", "said"), [
    ({"storage_identifier": "sqlite3"}, "storage_identifier is 'sqlite3', while field.mcap is read as its name says"),
    ({"compression_mode": "FILE", "compression_format": "zstd"},
     "compression_mode is 'file', while field.mcap is not packed and is read as it is"),
    ({"duration": {"nanoseconds": -5}}, "duration is -5 ns, which no recording lasts; it is not used"),
])  # fmt: skip
def test_metadata_that_its_files_contradict_is_told_and_the_files_are_read(bag, short, entries, said):
    assert told_by_metadata(bag, lambda information: information.update(entries)) == [f"{bag} has a metadata.yaml in which {said}"]
    assert len(read_recording(bag).drive) == len(short.drive)


def test_metadata_with_another_type_or_time_than_the_messages_is_told_by_all_that_read_or_play(bag, short):
    def change(information):
        topics = [entry["topic_metadata"] for entry in information["topics_with_message_count"]]
        next(topic for topic in topics if topic["name"] == "/ddh/drive/telemetry")["type"] = "std_msgs/msg/String"
        information["starting_time"]["nanoseconds_since_epoch"] += 3600 * 10**9
        information["duration"]["nanoseconds"] *= 2

    kinds, began, lasted = told_by_metadata(bag, change)
    assert kinds == (f"{bag} has a metadata.yaml in which type of /ddh/drive/telemetry is 'std_msgs/msg/String' and the messages are of "
                     "'ddh_msgs/msg/DriveTelemetry', as which they are read")
    assert re.search(r"in which starting_time is \d+\.\d{3} s and the first message is of \d+\.\d{3} s$", began)
    assert re.search(r"in which duration is \d+\.\d{3} s and the messages last \d+\.\d{3} s$", lasted)
    assert len(read_recording(bag).drive) == len(short.drive)


def test_a_missing_file_outside_of_the_bag_is_named_with_its_folders(bag):
    told = "../../../nowhere/passwd"
    path = bag / "metadata.yaml"
    path.write_text(path.read_text().replace("  - field.mcap\n", f"  - field.mcap\n  - {told}\n"))
    assert f"lacks the file {told} that metadata.yaml names" in read_recording(bag).warnings[-1].message
    damage.storage_file(bag).unlink()
    assert refusal(bag).endswith(f"names: field.mcap, {told}")


@pytest.mark.parametrize("lost", [1, 9, 30])
def test_an_mcap_file_without_its_very_end_is_read_whole_and_told(bag, short, lost):
    file = damage.storage_file(bag)
    file.write_bytes(file.read_bytes()[:-lost])
    read = read_recording(bag)
    (finding,) = read.warnings
    assert finding.message.startswith(f"{bag} has lost its end, which holds the index") and len(read.drive) == len(short.drive)
    played = RawBag(bag)
    assert [f"{bag} {note}" for note in played.notes] == [finding.message]
    assert sum(len(block.messages) for block in played.blocks()) == played.count == 1 + sum(len(stream) for _, stream in short.streams())
    played.close()


def test_a_file_without_its_very_end_hides_no_wrong_count_from_a_player(bag):
    file = damage.storage_file(bag)
    file.write_bytes(file.read_bytes()[:-9])
    told_by_metadata(bag, lambda information: information.update(message_count=7))
    played = RawBag(bag)
    ended, counted = played.notes
    assert ended.startswith("has lost its end") and "message_count is 7 and the bag holds" in counted
    played.close()


def test_a_file_in_the_bag_goes_before_one_of_its_name_outside(tmp_path, bag, short):
    write_recording(tmp_path / "other" / "field", short.between(0.0, 6.0))
    (said,) = told_by_metadata(bag, lambda information: information.update(relative_file_paths=["../other/field/field.mcap"]))
    assert said.endswith(f"lies outside of the bag; {bag / 'field.mcap'} is read")


def test_a_file_that_metadata_names_twice_is_read_once(bag, short):
    (said,) = told_by_metadata(bag, lambda information: information.update(relative_file_paths=["field.mcap", "./field.mcap"]))
    assert said.endswith("names field.mcap twice; it is read once")
    assert len(read_recording(bag).drive) == len(short.drive)


def test_a_file_that_metadata_does_not_name_is_told(tmp_path, bag, short):
    shutil.copy(bag / "field.mcap", bag / "field_1.mcap")
    shutil.copy(bag / "field.mcap", bag / "field.mcap.zstd")  # packed by the recorder and unpacked by a player: the same file
    (said,) = told_by_metadata(bag, lambda information: None)
    assert said.endswith("relative_file_paths does not name field_1.mcap, which lies beside it and is not read")


def test_unknown_storage_and_compression(bag):
    path = bag / "metadata.yaml"
    good = path.read_text()
    path.write_text(good.replace("storage_identifier: mcap", "storage_identifier: rosbag_v2"))
    assert "storage_identifier 'rosbag_v2' cannot be read; known are mcap, sqlite3" in refusal(bag)
    path.write_text(
        good.replace("compression_mode: ''", "compression_mode: file").replace(
            "compression_format: ''", "compression_format: lzo"
        )
    )
    message = refusal(bag)
    assert "compression_mode 'file' with compression_format 'lzo' cannot be read" in message


# Damaged files


@pytest.mark.parametrize("share", [0.95, 0.6, 0.2])
@pytest.mark.parametrize("keep_metadata", [True, False])
def test_truncated_mcap(tmp_path, paper, share, keep_metadata):
    long = paper.between(0.0, 60.0)
    bag = write_recording(tmp_path / "cut", long)
    damage.truncate(bag, share, keep_metadata)
    read = read_recording(bag)
    (finding,) = read.warnings
    assert "has no end, the recorder was stopped hard: it is whole up to byte" in finding.message
    assert ", and read beyond as far as its messages are whole; recovered" in finding.message
    messages = 1 + sum(len(s) for _, s in read.streams())
    far = keep_metadata and messages < 0.95 * (1 + sum(len(s) for _, s in long.streams()))  # without it nobody knows how many there were
    assert finding.severity == ("error" if far else "warning")
    assert f"recovered {messages}" in finding.message
    assert f"messages, {read.duration:.1f}"[:-1] in finding.message
    assert len(read.drive) > (share - 0.15) * len(long.drive)  # as much as whole blocks of zstd hold
    np.testing.assert_array_equal(read.drive.values, long.drive.values[: len(read.drive)])
    if keep_metadata and len(read.drive) < len(long.drive):
        assert f"of {1 + sum(len(s) for _, s in long.streams())} messages" in finding.message


def test_every_cut_is_survived(tmp_path, short):
    """Wherever the file ends: a recording or a BagError, and nothing else."""
    bag = write_recording(tmp_path / "cut", short.between(0.0, 1.0))
    (bag / "metadata.yaml").unlink()
    file = damage.storage_file(bag)
    whole = file.read_bytes()
    kept = set()
    for end in [*range(200), *range(200, len(whole), max(1, len(whole) // 300))]:
        file.write_bytes(whole[:end])
        try:
            read = read_recording(bag)
            kept.add(len(read.drive) if read.drive is not None else 0)
            assert read.warnings
        except BagError as error:
            assert str(bag) in str(error)
    assert max(kept) == len(short.between(0.0, 1.0).drive)


def test_damaged_bytes_are_survived(tmp_path, paper):
    """Flipped bytes anywhere: a recording, or a BagError that names the file."""
    bag = write_recording(tmp_path / "flipped", paper.between(0.0, 40.0))
    file = damage.storage_file(bag)
    whole = bytearray(file.read_bytes())
    rng = np.random.default_rng(4)
    for _ in range(60):
        broken = bytearray(whole)
        for at in rng.integers(8, len(whole), 3):
            broken[at] ^= int(rng.integers(1, 256))
        file.write_bytes(broken)
        try:
            read_recording(bag)
        except BagError as error:
            assert str(bag) in str(error)


@pytest.mark.parametrize("told_by", ["chunk", "metadata.yaml", "neither"])
def test_a_damaged_log_time_makes_no_recording_longer(tmp_path, bag, short, told_by):
    """Chunks without a checksum, as rosbag2 writes them by default."""
    target = rewritten(bag, tmp_path / "plain")
    file = damage.storage_file(target)
    content = bytearray(file.read_bytes())
    chunk = content.index(b"\x06", 8) + 9
    assert struct.unpack_from("<I", content, chunk + 24) == (0,)
    drive = next(content.index(raw) for c, _, raw in messages(target) if c.topic == DRIVE)
    content[drive - 9] ^= 0x45  # the highest byte of its log time stands before that of its publish time
    if told_by != "chunk":
        struct.pack_into("<QQ", content, chunk, 0, 2**64 - 1)
    file.write_bytes(content)
    metadata = target / "metadata.yaml"
    whole = yaml.safe_load(metadata.read_text())
    listed = whole["rosbag2_bagfile_information"]
    listed["topics_with_message_count"][0]["message_count"] += 3
    if told_by != "metadata.yaml":
        del listed["duration"]
    metadata.write_text(yaml.safe_dump(whole))
    (finding,) = [f for f in read_recording(target).findings if "recovered" in f.message]
    seconds = float(finding.message.split()[-2])
    assert (seconds <= short.duration + 0.1) == (told_by != "neither")


def test_flipped_bytes_make_no_recording_longer(tmp_path, paper):
    long = paper.between(0.0, 40.0)
    target = rewritten(write_recording(tmp_path / "field", long), tmp_path / "plain")
    file = damage.storage_file(target)
    whole = np.frombuffer(file.read_bytes(), np.uint8)
    told = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        broken = whole.copy()
        broken[rng.integers(12_000, whole.size, 60)] ^= rng.integers(1, 256, 60, np.uint8)
        file.write_bytes(broken.tobytes())
        told += [float(f.message.split()[-2]) for f in read_recording(target).findings if "recovered" in f.message]
    assert len(told) == 20 and max(told) <= long.duration + 0.1


@pytest.mark.parametrize("which", ["first", "middle"])
def test_damaged_chunk_is_left_out_and_said(tmp_path, paper, which):
    """With how many messages it held; the definitions that stood in it are in the summary."""
    long = paper.between(0.0, 120.0)
    bag = write_recording(tmp_path / "bits", long, flush_interval=1e6)
    file = damage.storage_file(bag)
    content = bytearray(file.read_bytes())
    content[600 if which == "first" else len(content) // 2] ^= 0xFF
    file.write_bytes(content)
    read = read_recording(bag)
    (finding,) = [f for f in read.warnings if "has a damaged chunk at byte" in f.message]
    assert 0.2 * len(long.drive) < len(read.drive) < len(long.drive)
    lost = sum(len(s) for _, s in long.streams()) - sum(len(s) for _, s in read.streams())
    assert lost <= int(finding.message.split(" messages by its index")[0].split()[-1]) <= lost + 1, "the announcement of the rig, too"


@pytest.mark.parametrize("packing", ["zstd", "plain zstd", "lz4", "none"])
def test_no_value_of_a_damaged_chunk_is_believed(tmp_path, paper, packing):
    """A flipped bit changes what is unpacked long before, or without, any error of the compression."""
    bag = write_recording(tmp_path / "field", paper.between(0.0, 120.0), flush_interval=1e6)
    file, plain = damage.storage_file(bag), packing == "plain zstd"
    if packing in ("lz4", "none"):
        repacked(file, "" if packing == "none" else packing)
    elif plain:
        repacked(file, "zstd")
    whole = file.read_bytes()
    sound = {topic: set(map(bytes, np.column_stack([s.time, s.values]))) for topic, s in read_recording(bag).streams()}
    begin, end = whole.index(b"\x06", 8) + 60, len(whole) * 8 // 10
    said = 0
    for at in np.random.default_rng(5).integers(begin, end, 40):
        content = bytearray(whole)
        content[at] ^= 0x10
        file.write_bytes(content)
        try:
            read = read_recording(bag)
        except BagError:
            continue
        said += any("is left out" in f.message for f in read.warnings)
        shift = (read.epoch_ns - paper.epoch_ns) * 1e-9
        for topic, s in read.streams():
            if abs(shift) < 1e-9:
                assert set(map(bytes, np.column_stack([s.time, s.values]))) <= sound[topic]
    assert said > 20


def repacked(file, name):
    """The chunks of an MCAP file packed otherwise, with their checksums: by zstd without one of its own, by lz4, or not at all."""
    import lz4.frame

    pack = {"": bytes, "lz4": lz4.frame.compress, "zstd": zstd.compress}[name]
    content, at, out = file.read_bytes(), 8, bytearray(MAGIC)
    while True:
        opcode, length = struct.unpack_from("<BQ", content, at)
        record = content[at + 9 : at + 9 + length]
        if opcode == CHUNK:
            packed = pack(unpack_chunk(record[44:], "zstd", struct.unpack_from("<Q", record, 16)[0])[0])
            record = record[:28] + struct.pack("<I", len(name)) + name.encode() + struct.pack("<Q", len(packed)) + packed
        if opcode == DATA_END:
            break
        out += struct.pack("<BQ", opcode, len(record)) + record
        at += 9 + length
    file.write_bytes(out + struct.pack("<BQI", DATA_END, 4, 0) + struct.pack("<BQQQI", FOOTER, 20, 0, 0, 0) + MAGIC)


def test_of_a_file_that_was_cut_off_in_a_chunk_the_whole_messages_are_read(tmp_path, paper):
    short = paper.between(0.0, 30.0)
    bag = write_recording(tmp_path / "field", short, flush_interval=1e6)
    damage.truncate(bag, 0.3)
    read = read_recording(bag)
    n = len(read.drive)
    assert 500 < n < len(short.drive) and np.array_equal(read.drive.values, short.drive.values[:n], equal_nan=True)
    file = damage.storage_file(bag)
    content = bytearray(file.read_bytes())
    content[len(content) // 2 : len(content) // 2 + 64] = bytes(64)
    file.write_bytes(content)
    assert "could be unpacked; all of it is left out" in refusal(bag)


def test_tail_of_zeros_after_a_power_cut(tmp_path, short):
    bag = write_recording(tmp_path / "zeros", short)
    damage.truncate(bag, 0.9)
    with damage.storage_file(bag).open("ab") as file:
        file.write(bytes(100_000))
    assert "has no end" in read_recording(bag).findings[0].message


def test_chunk_compression_that_nobody_knows(bag):
    file = damage.storage_file(bag)
    file.write_bytes(file.read_bytes().replace(b"\4\0\0\0zstd", b"\4\0\0\0brot"))
    assert "compression 'brot' cannot be read; known are '', 'zstd', 'lz4'" in refusal(bag)


def test_cut_sqlite_file(tmp_path, bag, monkeypatch):
    target = rewritten(bag, tmp_path / "sql", storage=StoragePlugin.SQLITE3)
    file = damage.storage_file(target)
    damage.truncate(target, 0.5, keep_metadata=True)
    message = refusal(target)
    assert message.startswith(f"{file} is a damaged SQLite3 file: database disk image is malformed; what is left of it goes into another")
    if shutil.which("sqlite3"):
        monkeypatch.chdir(tmp_path)
        subprocess.run(["sh", "-c", message.partition("another by: ")[2]], stderr=subprocess.DEVNULL, check=False)
        assert len(read_recording(tmp_path / "saved_sql.db3").drive) > 100


def test_a_sqlite_file_whose_texts_are_damaged_is_said_to_be_so(tmp_path, bag):
    target = rewritten(bag, tmp_path / "sql", storage=StoragePlugin.SQLITE3)
    file = damage.storage_file(target)
    file.write_bytes(file.read_bytes().replace(b"hydraulics/telemetry", b"hydraulics/\xffelemetry"))
    assert "is a damaged SQLite3 file: 'utf-8' codec can't decode byte 0xff" in refusal(target)


def test_packed_file_that_is_damaged(tmp_path, bag):
    path = tmp_path / "field.mcap.zstd"
    path.write_bytes(b"this is not zstd")
    assert "cannot be unpacked" in refusal(path)


def test_messages_that_are_too_short(tmp_path, bag):
    target = tmp_path / "short"
    with AnyReader([bag]) as reader, Writer(target, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        ids = {c.id: writer.add_connection(c.topic, c.msgtype, typestore=reader.typestore) for c in reader.connections}
        for n, (connection, at, raw) in enumerate(reader.messages()):
            writer.write(ids[connection.id], at, raw[:30] if connection.topic == DRIVE and n % 10 == 0 else raw)
    (finding,) = read_recording(target).warnings
    assert f"messages on {DRIVE} cannot be decoded and are left out, the first has 30 bytes" in finding.message
    assert finding.count > 50


@pytest.mark.parametrize("share", [3, 1])
def test_a_stamp_with_nanoseconds_of_more_than_a_second(tmp_path, bag, share):
    """Of every third message on the drive's topic, and of all."""
    target = tmp_path / "stamps"
    with AnyReader([bag]) as reader, Writer(target, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        ids = {c.id: writer.add_connection(c.topic, c.msgtype, typestore=reader.typestore) for c in reader.connections}
        for n, (connection, at, raw) in enumerate(reader.messages(c for c in reader.connections if c.topic in (DRIVE, "/ddh/rig"))):
            odd = connection.topic == DRIVE and n % share == 0
            writer.write(ids[connection.id], at, raw[:8] + (4 * 10**9).to_bytes(4, "little") + raw[12:] if odd else raw)
    said = f"{DRIVE}: header.stamp nanosec is 4000000000, allowed are 0 to 999999999; "
    if share == 1:
        assert said in refusal(target)
        return
    recording = read_recording(target)
    (finding,) = [f for f in recording.findings if f.field == "header.stamp"]
    assert finding.message == f"{target}: {said}{finding.count} messages are so and are left out"
    assert (finding.severity, finding.topic, finding.value) == ("warning", DRIVE, 4 * 10**9)
    assert finding.count == pytest.approx(0.5 * len(recording.drive), abs=2)
    assert not [f for f in screen_recording(recording).findings if "jumped" in f.message]


# Types


def test_wrong_type_on_a_known_topic(tmp_path, bag):
    types = {DRIVE: (telemetry_typestore(), "geometry_msgs/msg/TwistStamped")}
    message = refusal(rewritten(bag, tmp_path / "typed", types))
    assert f"topic {DRIVE} has type 'geometry_msgs/msg/TwistStamped'" in message
    assert "expected 'ddh_msgs/msg/DriveTelemetry'" in message


def test_unknown_type_on_a_known_topic(tmp_path, bag):
    types = {DRIVE: type_of("acme_msgs/msg/Drive", "std_msgs/Header header\nfloat64 rpm\n")}
    assert "has type 'acme_msgs/msg/Drive'" in refusal(rewritten(bag, tmp_path / "typed", types))


def test_unknown_type_on_another_topic_is_no_matter(tmp_path, bag):
    types = {"/ddh/temperature/line_a": type_of("acme_msgs/msg/Other", "float64 x\n")}
    target = rewritten(bag, tmp_path / "typed", types, topic=lambda t: t.replace("temperature/line_a", "acme"))
    assert read_recording(target).warnings == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("std_msgs/Header header\nfloat64 speed\n", "field 'speed_command' is missing"),
        ("{all}float64 temperature\n", "unexpected field 'temperature'"),
        ("{renamed}", "field 'electrical_power' is missing, it has 'electric_power'"),
        ("{float}", "field 'voltage' is of another type"),
        ("{swapped}", "fields are in the order"),
    ],
)
def test_another_definition_of_our_type(tmp_path, bag, text, said):
    fields = ["speed_command", "speed", "torque", "current", "voltage", "electrical_power"]
    lines = ["std_msgs/Header header", *(f"float64 {name}" for name in fields)]
    every = "\n".join(lines) + "\n"
    text = text.replace("{all}", every).replace("{renamed}", every.replace("electrical_", "electric_"))
    text = text.replace("{float}", every.replace("float64 voltage", "float32 voltage"))
    text = text.replace("{swapped}", "\n".join([lines[0], lines[2], lines[1], *lines[3:]]) + "\n")
    types = {DRIVE: type_of("ddh_msgs/msg/DriveTelemetry", text)}
    message = refusal(rewritten(bag, tmp_path / "typed", types))
    assert f"topic {DRIVE} has another definition of 'ddh_msgs/msg/DriveTelemetry': {said}" in message


def test_type_hash_of_metadata_is_believed(bag):
    path = bag / "metadata.yaml"
    path.write_text(path.read_text().replace("RIHS01_fe605f9b", "RIHS01_00000000"))
    message = refusal(bag)
    assert f"topic {DRIVE} has another definition" in message
    assert "type hash RIHS01_00000000" in message


# Topics and rigs


@pytest.mark.parametrize(
    ("stream", "said"),
    [
        ("drive/telemetry", "the motor's losses and the shaft's speed are not known"),
        ("hydraulics/telemetry", "pressures and rod motion are not known"),
        ("temperature/ambient", "the ambient temperature must be assumed"),
    ],
)
def test_missing_topic(tmp_path, short, stream, said):
    read = read_recording(write_recording(tmp_path / "missing", damage.without_stream(short, stream)))
    (finding,) = read.findings
    assert finding.severity == "warning"
    assert finding.topic == f"/ddh/{stream}"
    assert f"topic /ddh/{stream} is missing, {said}" in finding.message
    assert stream not in dict(read.streams())


def test_most_sensors_may_be_missing_without_a_word(tmp_path, short):
    few = replace(short, temperatures={"ambient": short.temperatures["ambient"]})
    assert read_recording(write_recording(tmp_path / "few", few)).findings == []


def test_misspelt_topic_is_pointed_out(tmp_path, bag):
    target = rewritten(bag, tmp_path / "misspelt", topic=lambda t: t.replace("hydraulics/", "hydraulic/"))
    read = read_recording(target)
    assert read.hydraulic is None
    assert "did /ddh/hydraulic/telemetry mean it?" in read.warnings[0].message


def test_sensors_in_another_namespace_than_the_rig_are_pointed_out(tmp_path, bag):
    read = read_recording(rewritten(bag, tmp_path / "apart", topic=lambda t: t.replace("/ddh/temperature", "/plant/temperature")))
    said = [finding.message for finding in read.warnings]
    assert any("10 topics of telemetry are in the namespace '/plant' and not in the rig's, '/ddh', and are ignored" in one for one in said)
    assert not [finding for finding in read.findings if finding.severity == "info"]


def test_a_second_rig_that_was_not_chosen_is_no_fault(tmp_path, short):
    read = read_recording(two_rigs(tmp_path, short), namespace="left")
    assert not [finding for finding in read.warnings if "of telemetry are in the namespace" in finding.message]


@pytest.mark.parametrize("samples", [1, 100])
def test_a_recording_of_no_length_is_told(tmp_path, short, samples):
    still = {name: replace(s, time=np.zeros(min(samples, len(s))), values=s.values[:samples]) for name, s in short.streams()}
    read = read_recording(write_recording(tmp_path / "still", short.with_streams(still)))
    assert any("covers no time: all its messages have one stamp" in finding.message for finding in read.warnings)


def test_a_recording_without_stamps_is_told_so(tmp_path, short):
    still = {name: replace(s, time=np.zeros(len(s))) for name, s in short.streams()}
    read = read_recording(write_recording(tmp_path / "unstamped", replace(short.with_streams(still), epoch_ns=0)))
    assert any("covers no time, as all stamps are 0: nobody set header.stamp, and" in finding.message for finding in read.warnings)


def test_a_recording_of_one_message_of_each_topic_is_told(tmp_path, short):
    one = {name: replace(s, time=s.time[:1], values=s.values[:1]) for name, s in short.streams()}
    read = read_recording(write_recording(tmp_path / "one", short.with_streams(one)))
    assert any("holds one message of each topic, and nothing can be told of it" in finding.message for finding in read.warnings)
    whole = read_recording(write_recording(tmp_path / "all", short))
    assert not any("one message of each" in finding.message for finding in whole.findings)


def test_a_rig_without_a_name_is_not_named():
    assert str(RigInfo("", "", float("nan"))) == "not named, oil not known, payload not known"


def test_unknown_sensor_is_pointed_out(tmp_path, bag):
    target = rewritten(bag, tmp_path / "sensor", topic=lambda t: t.replace("tank_oil", "oil_tank"))
    (finding,) = read_recording(target).warnings
    assert "topic /ddh/temperature/oil_tank is no sensor of the interface and is ignored" in finding.message
    assert "valid are ambient, motor_winding" in finding.message


def test_what_the_twin_itself_publishes_is_no_misspelt_sensor(tmp_path, bag):
    names = iter(BESIDE_SENSORS)
    target = rewritten(bag, tmp_path / "own", topic=lambda t: f"/ddh/{next(names)}" if t.startswith("/ddh/temperature/line_") else t)
    assert not [f for f in read_recording(target).findings if "is no sensor" in f.message]


def test_rig_missing(tmp_path, short):
    (finding,) = read_recording(write_recording(tmp_path / "norig", replace(short, rig=None))).findings
    assert "has no message on /ddh/rig: payload and oil grade must come from elsewhere" in finding.message


def two_rigs(tmp_path, short):
    target = tmp_path / "two"
    with BagWriter(target) as writer:
        for namespace, rig_id in (("/left", "rig_1"), ("/right", "rig_2")):
            writer.write_rig(replace(short.rig, rig_id=rig_id), short.epoch_ns, namespace)
            write_rows(
                writer,
                f"{namespace}/drive/telemetry",
                "ddh_msgs/msg/DriveTelemetry",
                short.drive.stamps(short.epoch_ns),
                short.drive.values,
            )
    return target


def test_two_rigs_must_be_chosen_from(tmp_path, short):
    target = two_rigs(tmp_path, short)
    assert "holds 2 rigs, in the namespaces '/left' and '/right'; choose one" in refusal(target)
    assert read_recording(target, namespace="right").rig.rig_id == "rig_2"
    assert read_recording(target, namespace="/left/").rig.rig_id == "rig_1"
    message = refusal(target, namespace="middle")
    assert "has no telemetry in namespace '/middle'; namespaces with telemetry: '/left', '/right'" in message


def test_two_rig_ids_in_one_namespace(tmp_path, short):
    target = tmp_path / "ids"
    with BagWriter(target) as writer:
        for rig_id in ("rig_1", "rig_2"):
            writer.write_rig(replace(short.rig, rig_id=rig_id), short.epoch_ns)
        stamps = short.drive.stamps(short.epoch_ns)
        write_rows(writer, DRIVE, "ddh_msgs/msg/DriveTelemetry", stamps, short.drive.values)
    assert "topic /ddh/rig names 2 rigs, 'rig_1' and 'rig_2'" in refusal(target)


def announced(target, short, **field):
    """A bag in which the rig is announced with these values of a field one after the other, as it is read."""
    ((name, told),) = field.items()
    with BagWriter(target) as writer:
        for value in told:
            writer.write_rig(replace(short.rig, **{name: value}), short.epoch_ns)
        stamps = short.drive.stamps(short.epoch_ns)
        write_rows(writer, DRIVE, "ddh_msgs/msg/DriveTelemetry", stamps, short.drive.values)
    return read_recording(target)


def test_payload_that_changes_is_said(tmp_path, short):
    read = announced(tmp_path / "payload", short, payload_mass=(149.5, 60.0))
    assert read.rig.payload_mass == 149.5
    assert any("says payload 149.5 kg" in f.message and "then 60 kg" in f.message for f in read.warnings)


@pytest.mark.parametrize("first", [np.nan, 0.0])
def test_the_first_announcement_of_a_payload_that_is_a_mass_is_used(tmp_path, short, first):
    read = announced(tmp_path / "payload", short, payload_mass=(first, first, 200.0, 60.0))
    (said,) = (finding.message for finding in read.findings if finding.topic == "/ddh/rig")
    assert read.rig.payload_mass == 200.0
    assert f"says payload {first:g} kg" in said and "then 200 kg" in said
    assert said.endswith("; number 3 of 4, whose payload is the first that is a mass, is used")


def test_an_announcement_without_a_name_is_of_the_rig_that_another_one_names(tmp_path, short):
    read = announced(tmp_path / "names", short, rig_id=("", "rig_1"))
    assert read.rig.rig_id == "rig_1" and not [finding for finding in read.findings if finding.topic == "/ddh/rig"]


def test_stamps_far_from_the_others_do_not_move_the_epoch(tmp_path, short):
    time = short.drive.time.copy()
    time[3] = -short.epoch_ns * 1e-9  # header never filled in
    odd = short.with_streams({**dict(short.streams()), "drive/telemetry": replace(short.drive, time=time)})
    read = read_recording(write_recording(tmp_path / "odd", odd))
    assert abs(read.epoch_ns - short.epoch_ns) < 10**9
    assert np.median(read.drive.time) < 20


def test_copy_of_one_file_of_a_bag_is_enough(tmp_path, bag, short):
    shutil.copy(bag / "field.mcap", tmp_path / "alone.mcap")
    assert read_recording(tmp_path / "alone.mcap").findings == []


# What the rig's own message says


@pytest.mark.parametrize("payload", [0.0, -3.0, float("nan"), float("inf"), 2.0e5])
def test_a_payload_that_is_no_mass_is_not_taken(tmp_path, short, payload):
    bag = write_recording(tmp_path / "odd", replace(short, rig=replace(short.rig, payload_mass=payload)))
    read = read_recording(bag)
    (finding,) = read.findings
    assert (finding.severity, finding.topic, finding.field) == ("warning", "/ddh/rig", "payload_mass")
    assert f"{bag}: topic /ddh/rig payload_mass is {payload:g} kg, allowed are above 0 to 100000 kg" in finding.message
    assert "the rig file's payload is taken instead" in finding.message
    assert np.isnan(read.rig.payload_mass)
    assert "payload not known" in read.describe()


@pytest.mark.parametrize("grade, severity", [("ISO VG 46", "warning"), ("", "info")])
def test_another_oil_is_said(tmp_path, short, grade, severity):
    read = read_recording(write_recording(tmp_path / "odd", replace(short, rig=replace(short.rig, oil_grade=grade))))
    (finding,) = read.findings
    assert (finding.severity, finding.field) == (severity, "oil_grade")
    assert "the reference sheet's is 'ISO VG 32'; the oil of the rig file is used" in finding.message


def test_the_same_oil_in_another_spelling_is_the_same(tmp_path, short):
    bag = write_recording(tmp_path / "same", replace(short, rig=replace(short.rig, oil_grade="iso VG32")))
    assert read_recording(bag).findings == []


def test_topics_of_the_twin_itself_are_no_unknown_sensors(tmp_path, bag):
    names = {"/ddh/temperature/line_a": "/ddh/temperature/estimates", "/ddh/temperature/line_b": "/ddh/temperature/residuals"}
    target = tmp_path / "own"
    rewritten(bag, target, topic=lambda t: names.get(t, t))
    read = read_recording(target)
    assert read.warnings == []
    assert "/ddh/temperature/estimates, /ddh/temperature/residuals" in read.findings[0].message
