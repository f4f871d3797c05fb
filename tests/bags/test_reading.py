"""Bags as they should be, in every form in which they come."""

import shutil
import struct
import zlib

import lz4.frame
import numpy as np
import pytest
from ddh_twin_py.bags.cdr import encode_stamped_floats, odd_nanosec, stamped_floats
from ddh_twin_py.bags.damage import storage_file
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.telemetry.signals import TEMPERATURE_SENSORS
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer


def assert_same(a, b):
    assert a.rig == b.rig
    assert [name for name, _ in a.streams()] == [name for name, _ in b.streams()]
    for (_, x), (_, y) in zip(a.streams(), b.streams(), strict=True):
        np.testing.assert_array_equal(x.stamps(a.epoch_ns), y.stamps(b.epoch_ns))
        np.testing.assert_allclose(x.values, y.values, rtol=1e-15)


def copied(bag, target, storage=StoragePlugin.MCAP, mode=CompressionMode.NONE, rename=lambda t: t):
    """The bag again, by rosbags' own writer."""
    writer = Writer(target, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with AnyReader([bag]) as reader, writer:
        connections = {
            c.id: writer.add_connection(
                rename(c.topic), c.msgtype, typestore=reader.typestore, offered_qos_profiles=c.ext.offered_qos_profiles
            )
            for c in reader.connections
        }
        for connection, at, raw in reader.messages():
            writer.write(connections[connection.id], at, raw)
    return target


def test_paper_cycle_is_read_without_findings(paper):
    assert paper.findings == []
    assert paper.namespace == "/ddh"
    assert min(stream.time.min() for _, stream in paper.streams()) == 0.0
    assert (paper.rig.rig_id, paper.rig.oil_grade, paper.rig.payload_mass) == ("rig_000", "ISO VG 32", 149.5)
    assert tuple(paper.temperatures) == TEMPERATURE_SENSORS
    assert len(paper.drive) == len(paper.hydraulic) == 32995
    assert 295 < paper.temperatures["tank_oil"].values[0, 0] < 297  # kelvin
    assert abs(paper.duration - 329.94) < 0.01


def test_what_is_written_is_read(tmp_path, short):
    again = read_recording(write_recording(tmp_path / "again", short, namespace="plant/left"))
    assert_same(short, again)
    assert again.namespace == "/plant/left"


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize("mode", [CompressionMode.NONE, CompressionMode.FILE, CompressionMode.MESSAGE])
def test_storages_and_compressions(tmp_path, bag, short, storage, mode):
    target = copied(bag, tmp_path / "copy", storage, mode)
    read = read_recording(target)
    assert read.warnings == []
    assert_same(short, read)
    if mode is not CompressionMode.MESSAGE:  # a lone file does not say that its messages are packed
        (file,) = [p for p in target.iterdir() if p.name != "metadata.yaml"]
        alone = shutil.copy(file, tmp_path)
        assert_same(short, read_recording(alone))


def test_any_namespace_and_the_root(tmp_path, bag, short):
    deep = copied(bag, tmp_path / "deep", rename=lambda t: t.replace("/ddh/", "/hall_3/rig_b/ddh/"))
    assert read_recording(deep).namespace == "/hall_3/rig_b/ddh"
    root = copied(bag, tmp_path / "root", rename=lambda t: t.removeprefix("/ddh"))
    read = read_recording(root)
    assert read.namespace == ""
    assert_same(short, read)


def swapped(messages):
    return messages[len(messages) // 2 :] + messages[: len(messages) // 2]


def shuffled(messages):
    return [messages[i] for i in np.random.default_rng(1).permutation(len(messages))]


@pytest.mark.parametrize("disorder", [swapped, shuffled])
def test_message_order_is_log_time(tmp_path, bag, short, disorder):
    """A file whose messages are not in order of log time is put in order of arrival."""
    target = tmp_path / "swapped"
    with AnyReader([bag]) as reader, Writer(target, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        ids = {c.id: writer.add_connection(c.topic, c.msgtype, typestore=reader.typestore) for c in reader.connections}
        for connection, at, raw in disorder(list(reader.messages())):
            writer.write(ids[connection.id], at, raw)
    assert_same(short, read_recording(target))


def test_a_recorder_whose_clock_was_set_back_is_told_from_parts_in_another_order(tmp_path, bag, short):
    """Stamps and log times step back by 3 s: the samples must not be sorted into each other."""
    target = tmp_path / "back"
    with AnyReader([bag]) as reader, Writer(target, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        ids = {c.id: writer.add_connection(c.topic, c.msgtype, typestore=reader.typestore) for c in reader.connections}
        messages = list(reader.messages())
        half = messages[len(messages) // 2][1]
        for connection, at, raw in messages:
            back = 3_000_000_000 * (at > half)
            if back and connection.topic != "/ddh/rig":
                message = reader.deserialize(raw, connection.msgtype)
                message.header.stamp.sec -= 3
                raw = reader.typestore.serialize_cdr(message, connection.msgtype)
            writer.write(ids[connection.id], at - back, raw)
    stream = read_recording(target).drive
    steps = np.diff(stream.time)
    assert len(stream) == len(short.drive) and np.flatnonzero(steps < -2.0).size == 1 and (steps > -0.1).sum() == steps.size - 1


@pytest.mark.parametrize("wrong", [
    lambda at, i, half: at + int(np.random.default_rng(i).integers(0, 700_000_000)), lambda at, i, half: at - 5_000_000_000 * (i % 2),
    lambda at, i, half: at - 400_000_000_000 * half, lambda at, i, half: 0 if i % 50 == 0 else at,
], ids=["jitters", "to and fro", "set back far", "zeros"])  # fmt: skip
def test_a_recorders_clock_says_nothing_against_stamps_that_go_on(wrong, tmp_path, bag, short):
    """Log times that jump where stamps do not are no jump of the machine's clock."""
    target = tmp_path / "odd"
    with AnyReader([bag]) as reader, Writer(target, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        ids = {c.id: writer.add_connection(c.topic, c.msgtype, typestore=reader.typestore) for c in reader.connections}
        messages = list(reader.messages())
        for i, (connection, at, raw) in enumerate(messages):
            writer.write(ids[connection.id], wrong(at, i, i > len(messages) // 2), raw)
    read = read_recording(target)
    assert read.warnings == []
    assert_same(short, read)


def test_progress_reaches_the_end(bag):
    seen = []
    read_recording(bag, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_other_topics_are_listed_and_ignored(tmp_path, bag, short):
    def rename(topic):
        return {"/ddh/temperature/line_a": "/camera/temperature", "/ddh/temperature/line_b": "/tf"}.get(topic, topic)

    read = read_recording(copied(bag, tmp_path / "other", rename=rename))
    (finding,) = read.findings
    assert finding.severity == "info"
    assert "2 other topics are ignored: /camera/temperature, /tf" in finding.message
    assert "line_a" not in read.temperatures


def record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def text(string):
    return struct.pack("<I", len(string)) + string.encode()


def foreign_mcap(bag, target, compression):
    """As other writers do it: chunks with a checksum, or none at all (None); no index at the end."""
    with AnyReader([bag]) as reader:
        parts = []
        for c in reader.connections:
            content = text(c.msgtype) + text("ros2msg") + text(c.msgdef.data)
            parts.append(record(3, struct.pack("<H", 40 + c.id) + content))
            parts.append(record(4, struct.pack("<HH", c.id, 40 + c.id) + text(c.topic) + text("cdr") + text("")))
        for c, at, raw in reader.messages():
            parts.append(record(5, struct.pack("<HIQQ", c.id, 0, at, at) + raw))
    chunks = [b"".join(parts[k : k + 500]) for k in range(0, len(parts), 500)]
    if compression is not None:
        pack = {"": bytes, "lz4": lz4.frame.compress}[compression]
        for k, raw in enumerate(chunks):
            packed = pack(raw)
            head = struct.pack("<QQQI", 0, 0, len(raw), zlib.crc32(raw)) + text(compression)
            chunks[k] = record(6, head + struct.pack("<Q", len(packed)) + packed)
    magic = b"\x89MCAP0\r\n"
    header = record(1, text("ros2") + text("another"))
    footer = record(0x0F, bytes(4)) + record(2, bytes(20))
    target.write_bytes(magic + header + b"".join(chunks) + record(0x90, b"private") + footer + magic)


@pytest.mark.parametrize("compression", [None, "", "lz4"])
def test_mcap_of_another_writer(tmp_path, bag, short, compression):
    target = tmp_path / "foreign.mcap"
    foreign_mcap(bag, target, compression)
    read = read_recording(target)
    assert read.findings == []
    assert_same(short, read)


def test_checksum_of_a_chunk_is_believed(tmp_path, bag):
    target = tmp_path / "foreign.mcap"
    foreign_mcap(bag, target, "")
    content = bytearray(target.read_bytes())
    content[len(content) // 2] ^= 1
    target.write_bytes(content)
    (finding,) = [f for f in read_recording(target).findings if not f.topic]
    assert "has a damaged chunk at byte" in finding.message


def test_folder_with_several_files(tmp_path, bag, short):
    """rosbag2 splits long recordings."""
    half = short.duration / 2
    split = tmp_path / "split"
    split.mkdir()
    for number, part in enumerate((short.between(0, half), short.between(half, 1e9))):
        written = write_recording(tmp_path / f"part_{number}", part)
        shutil.move(storage_file(written), split / f"split_{number}.mcap")
    metadata = (bag / "metadata.yaml").read_text()
    metadata = metadata.replace("  - field.mcap\n", "  - split_0.mcap\n  - split_1.mcap\n")
    (split / "metadata.yaml").write_text(metadata)
    read = read_recording(split)
    assert len(read.drive) == len(short.drive)
    np.testing.assert_array_equal(read.drive.values, short.drive.values)


@pytest.mark.parametrize("frame", ["", "d", "ddh", "a_long_frame_id_of_a_sensor"])
@pytest.mark.parametrize("order", ["little", "big"])
def test_cdr_of_both_byte_orders_and_any_frame(frame, order):
    stamps = np.array([0, 1, 999_999_999, 1_772_000_000_123_456_789, -1_500_000_000], np.int64)
    values = np.random.default_rng(1).normal(size=(5, 6))
    messages = encode_stamped_floats(stamps, values, frame)
    if order == "big":
        offset = messages.shape[1] - 48
        for message in messages:
            message[1] = 0
            for at, width in [(4, 4), (8, 4), (12, 4), *((offset + 8 * k, 8) for k in range(6))]:
                message[at : at + width] = message[at : at + width][::-1].copy()
    size = np.full(5, messages.shape[1])
    got_stamps, got, sound = stamped_floats(messages.ravel(), np.cumsum(size) - size, size, 6)
    assert sound.all()
    np.testing.assert_array_equal(got_stamps, stamps)
    np.testing.assert_array_equal(got, values)


def test_cdr_that_is_too_short_or_of_another_kind_is_marked():
    messages = encode_stamped_floats(np.array([5, 6, 7], np.int64), np.ones((3, 4)), "ddh")
    messages[2, 1] = 7  # XCDR2
    size = np.full(3, messages.shape[1])
    start = np.cumsum(size) - size
    size[0] -= 8
    stamps, values, sound = stamped_floats(messages.ravel(), start, size, 4)
    assert sound.tolist() == [False, True, False]
    assert stamps.tolist() == [0, 6, 0]
    assert np.isnan(values[0]).all() and (values[1] == 1).all()


@pytest.mark.parametrize("order", ["little", "big"])
def test_a_stamp_of_more_nanoseconds_than_a_second_has_is_marked(order):
    messages = np.repeat(encode_stamped_floats(np.array([0]), np.ones((1, 4)), "ddh"), 3, axis=0)
    messages[:, 1] = order == "little"
    for message, nanosec in zip(messages, (999_999_999, 10**9, 2**32 - 1), strict=True):
        message[8:12] = np.frombuffer(nanosec.to_bytes(4, order), np.uint8)
        message[12:16] = np.frombuffer((4).to_bytes(4, order), np.uint8)
    size = np.full(3, messages.shape[1])
    given = messages.ravel(), np.cumsum(size) - size, size
    stamps, _, sound = stamped_floats(*given, 4)
    assert sound.tolist() == [True, False, False] and stamps.tolist() == [999_999_999, 0, 0]
    assert odd_nanosec(*given).tolist() == [10**9, 2**32 - 1]
