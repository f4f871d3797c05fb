"""What is written survives: the reader reads it, and the death of the writer."""

import os
import resource
import signal
import struct
import subprocess
import sys
import textwrap
import threading
import time
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ddh_twin_py.bags.compression import pack_chunk, unpack_chunk
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.message_types import typestore
from ddh_twin_py.bags.qos import LATCHED, SENSOR_DATA, qos_profile
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import BagWriter, whole_bag, write_recording
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader
from support.bag_rows import write_rows


def test_profiles_and_hashes_are_those_of_the_given_bag(tmp_path, short, paper_cycle_bag):
    written = write_recording(tmp_path / "field", short)
    with Reader(paper_cycle_bag) as given, Reader(written) as ours:
        expected = {c.topic: (c.msgtype, c.digest, c.ext.offered_qos_profiles) for c in given.connections}
        got = {c.topic: (c.msgtype, c.digest, c.ext.offered_qos_profiles) for c in ours.connections}
        assert got == expected
        assert ours.connections[0].msgdef.data


def test_rosbags_reads_every_message_and_its_definition(tmp_path, short):
    written = write_recording(tmp_path / "field", short)
    with AnyReader([written]) as reader:
        messages = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages()]
        assert reader.message_count == len(messages) == 1 + sum(len(s) for _, s in short.streams())


def test_a_stamp_that_ros_cannot_hold_is_refused_with_its_topic(tmp_path, short):
    late = replace(short, epoch_ns=2**31 * 1_000_000_000)
    early = replace(short, epoch_ns=-5 * 10**9)
    with pytest.raises(BagError, match=r"drive/telemetry: stamp -\d\.\d s since 1970 cannot be written, allowed are 0 to"):
        write_recording(tmp_path / "early", early)
    assert not (tmp_path / "early").exists()
    with pytest.raises(BagError, match=r"drive/telemetry: stamp 2147483648\.\d s since 1970 .* 0 to below 2147483648 s \(January 2038"):
        write_recording(tmp_path / "late", late)
    assert not (tmp_path / "late").exists()


def rows(topic, writer, stamps, values):
    """Messages of the drive, logged when they were stamped."""
    write_rows(writer, topic, "ddh_msgs/msg/DriveTelemetry", stamps, values)


def chunks_of(file):
    """Where each chunk of an MCAP file begins, and its head: size and checksum of what is in it, and the packed bytes."""
    content, at = file.read_bytes(), 8
    while content[at] != 0x0F:
        (length,) = struct.unpack_from("<Q", content, at + 1)
        if content[at] == 0x06:
            size, crc = struct.unpack_from("<QI", content, at + 25)
            yield at, size, crc, content[at + 9 + 32 + len("zstd") + 8 : at + 9 + length]
        at += 9 + length


def test_every_chunk_has_the_checksum_of_what_is_in_it(tmp_path, short):
    written = write_recording(tmp_path / "field", short, flush_interval=0.02)
    found = list(chunks_of(written / "field.mcap"))
    assert found and all(crc == zlib.crc32(raw) and len(raw) == size for _, size, crc, raw in
                         ((at, size, crc, unpack_chunk(packed, "zstd", size)[0]) for at, size, crc, packed in found))
    with AnyReader([written]) as reader:
        assert sum(1 for _ in reader.messages()) == reader.message_count


def test_a_chunk_whose_contents_changed_is_left_out_and_named(tmp_path, short):
    """Of the same length and soundly packed, as after a fault of the memory: nothing but the chunk's own checksum tells."""
    other = write_recording(tmp_path / "first", short) / "first.mcap"
    with BagWriter(tmp_path / "two", flush_interval=1e6) as writer:
        for begin, values in ((0, short.drive.values[:50]), (10**9, short.drive.values[50:100])):
            rows("/ddh/drive/telemetry", writer, begin + 10**7 * np.arange(1, 51), values)
            writer.flush()
    file = tmp_path / "two" / "two.mcap"
    content = bytearray(file.read_bytes())
    at, size, _, packed = list(chunks_of(file))[-1]
    raw = bytearray(unpack_chunk(packed, "zstd", size)[0])
    raw[-1] ^= 0x40
    again = pack_chunk(bytes(raw))
    length = 32 + len("zstd") + 8 + len(again)
    head = content[at + 9 : at + 9 + 32 + len("zstd")] + struct.pack("<Q", len(again))
    file.write_bytes(content[:at] + struct.pack("<BQ", 6, length) + head + again + content[at + 9 + 32 + len("zstd") + 8 + len(packed) :])
    read = read_recording(tmp_path / "two")
    (finding,) = [f for f in read.findings if "damaged chunk" in f.message]
    assert finding.message.startswith(f"{tmp_path / 'two'}") and f"has a damaged chunk at byte {at} " in finding.message
    assert f"its {size} bytes do not fit its checksum; all of it, 50 messages by its index, is left out" in finding.message
    assert len(read.drive) == 50
    parts = tmp_path / "parts"
    parts.mkdir()
    for k, part in enumerate((other, file)):
        part.rename(parts / f"x_{k}.mcap")
    assert "50 messages by its index, is left out (x_1.mcap)" in " ".join(f.message for f in read_recording(parts).findings)


def test_outputs_and_foreign_types_are_written_with_their_definition(tmp_path):
    store = typestore()
    types = store.types
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](1, 2), "rig")
    residual = types["ddh_msgs/msg/Residual"]("speed", "rad/s", 1.0, 0.9, 0.1, 0.15)
    status = types["diagnostic_msgs/msg/DiagnosticArray"](header, [])
    with BagWriter(tmp_path / "out") as writer:
        writer.write_message(
            "/ddh/residuals", types["ddh_msgs/msg/ResidualArray"](header, "fusion", [residual]), 10, SENSOR_DATA
        )
        writer.write_message("/diagnostics", status, 11)
    with AnyReader([tmp_path / "out"]) as reader:
        (first, second) = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages()]
    assert first.residuals[0].signal == "speed"
    assert second.header.frame_id == "rig"


def test_a_type_of_a_sourced_workspace_is_found(tmp_path, monkeypatch):
    folder = tmp_path / "prefix" / "share" / "acme_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Inner.msg").write_text("float64 x\n")
    (folder / "Outer.msg").write_text("acme_msgs/Inner[] parts\n")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
    with BagWriter(tmp_path / "acme") as writer:
        writer.write_raw("/acme", "acme_msgs/msg/Outer", None, 1, b"\0\1\0\0\0\0\0\0")
    with AnyReader([tmp_path / "acme"]) as reader:
        ((connection, _, raw),) = reader.messages()
        assert len(reader.deserialize(raw, connection.msgtype).parts) == 0


def test_a_type_that_is_nowhere_is_named(tmp_path):
    with BagWriter(tmp_path / "x") as writer, pytest.raises(BagError) as caught:
        writer.write_raw("/acme", "nowhere_msgs/msg/Thing", None, 1, b"\0\1\0\0")
    assert "topic /acme: no definition of 'nowhere_msgs/msg/Thing'; source the workspace" in str(caught.value)


def test_an_existing_folder_is_left_alone(tmp_path):
    (tmp_path / "there").mkdir()
    with pytest.raises(BagError, match="there cannot be written: .*exists already"):
        BagWriter(tmp_path / "there")


def test_an_exception_in_the_context_leaves_a_whole_bag(tmp_path, short):
    with pytest.raises(RuntimeError), BagWriter(tmp_path / "field") as writer:
        writer.write_rig(short.rig, short.epoch_ns)
        rows("/ddh/drive/telemetry", writer, short.drive.stamps(short.epoch_ns), short.drive.values)
        raise RuntimeError
    read = read_recording(tmp_path / "field")
    assert len(read.drive) == len(short.drive)
    assert (tmp_path / "field" / "metadata.yaml").exists()


def test_many_threads_may_write(tmp_path, short):
    stamps, values = short.drive.stamps(short.epoch_ns), short.drive.values
    with BagWriter(tmp_path / "field", flush_interval=0.02) as writer:
        threads = [
            threading.Thread(
                target=rows,
                args=(f"/rig_{k}/drive/telemetry", writer, stamps, values),
            )
            for k in range(4)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    for k in range(4):
        np.testing.assert_array_equal(read_recording(tmp_path / "field", f"rig_{k}").drive.values, values)


def test_a_full_disk_is_said(tmp_path, short, monkeypatch):
    writer = BagWriter(tmp_path / "field", flush_interval=0.01)
    monkeypatch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(BagError, match="field cannot be written: .*No space left on device"):
        for _ in range(200):
            writer.write_rig(short.rig, short.epoch_ns)
            time.sleep(0.01)
    monkeypatch.undo()
    with pytest.raises(BagError, match="field cannot be written: No space left on device"):
        writer.close()
    writer.close()


@pytest.mark.parametrize("by_itself", [True, False])
def test_what_was_written_before_the_disk_was_full_is_read_though_there_is_room_again(tmp_path, short, by_itself):
    """The second chunk is written in half, by the thread that flushes or as it grows too long; then there is room again."""
    writer = BagWriter(tmp_path / "field", flush_interval=1e6 if by_itself else 0.05)
    rows("/ddh/drive/telemetry", writer, 10**7 * np.arange(1, 201), short.drive.values[:200])
    writer.flush()
    file = tmp_path / "field" / "field.mcap"
    whole = file.stat().st_size
    noise = np.random.default_rng(1).normal(size=(200 if not by_itself else 20000, 6))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (whole + 5000, before[1]))  # signals are ignored by Python: EFBIG
    try:
        if by_itself:
            with pytest.raises(BagError, match="field cannot be written: File too large"):
                rows("/ddh/drive/telemetry", writer, 10**10 + 10**7 * np.arange(20000), noise)
        else:
            rows("/ddh/drive/telemetry", writer, 10**10 + 10**7 * np.arange(200), noise)
            writer._thread.join(10.0)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    with pytest.raises(BagError, match="field cannot be written: File too large"):
        writer.close()
    assert file.stat().st_size == whole
    read = read_recording(tmp_path / "field")
    assert len(read.drive) == 200 and any("the recorder was stopped hard" in finding.message for finding in read.warnings)


def full(monkeypatch, after):
    """The disk is full once so many flushes have been made."""
    flushes = iter([True] * after)
    sound = os.fsync

    def fsync(number):
        if not next(flushes, False):
            raise OSError(28, "No space left on device")
        sound(number)

    monkeypatch.setattr(os, "fsync", fsync)


@pytest.mark.parametrize("after", [0, 1])
def test_of_a_bag_that_does_not_fit_nothing_is_left(tmp_path, short, monkeypatch, after):
    full(monkeypatch, after)
    target = tmp_path / "tiny" / "field"
    with pytest.raises(BagError) as caught, whole_bag(target, flush_interval=1e6) as writer:
        writer.write_rig(short.rig, short.epoch_ns)
        writer.flush()
    assert str(caught.value) == f"{target} cannot be written: No space left on device"
    assert list(tmp_path.iterdir()) == []
    monkeypatch.undo()
    assert len(read_recording(write_recording(target, short)).drive) == len(short.drive)
    assert {path.name for path in tmp_path.rglob("*")} == {"tiny", "field", "metadata.yaml", "field.mcap"}


def test_a_recording_is_written_whole_or_not_at_all(tmp_path, short, monkeypatch):
    target = tmp_path / "field"
    monkeypatch.setattr(BagWriter, "write_raw", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        write_recording(target, short)
    assert list(tmp_path.iterdir()) == []
    monkeypatch.undo()
    write_recording(target, short)
    with pytest.raises(BagError, match="field cannot be written: it exists already"):
        write_recording(target, short)


def test_unknown_quality_is_named():
    with pytest.raises(ValueError, match="no reliability 'besteffort'; the nearest is 'best_effort'"):
        qos_profile("besteffort")
    assert LATCHED[0].depth == 1


WRITE_FOREVER = """
    import sys, time
    import numpy as np
    from ddh_twin_py.bags.cdr import encode_stamped_floats
    from ddh_twin_py.bags.qos import SENSOR_DATA
    from ddh_twin_py.bags.writer import BagWriter

    rate = float(sys.argv[2])
    writer = BagWriter(sys.argv[1])
    count = 0
    while True:
        now = time.time_ns()
        row = np.full((1, 6), count)
        (message,) = encode_stamped_floats(np.array([now]), row, "")
        writer.write_raw("/ddh/drive/telemetry", "ddh_msgs/msg/DriveTelemetry", SENSOR_DATA, now, message.data)
        count += 1
        print(now, flush=True)
        time.sleep(1.0 / rate)
"""


@pytest.mark.parametrize("rate", [200.0, 0.9])
def test_a_killed_writer_loses_at_most_five_seconds(tmp_path, rate):
    """A real process, killed without warning: all but the last seconds is read, with a warning."""
    bag = tmp_path / "killed"
    script = tmp_path / "write.py"
    script.write_text(textwrap.dedent(WRITE_FOREVER))
    package = Path(sys.modules["ddh_twin_py"].__file__).resolve().parents[1]
    environment = {**os.environ, "PYTHONPATH": f"{package}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}
    process = subprocess.Popen(
        [sys.executable, str(script), str(bag), str(rate)], stdout=subprocess.PIPE, text=True, env=environment
    )
    try:
        written = [int(process.stdout.readline())]
        while written[-1] - written[0] < 4e9:
            written.append(int(process.stdout.readline()))
        time.sleep(0.3 if rate > 1 else 2.5)  # at a low rate no further message pushes the last ones out
        process.send_signal(signal.SIGKILL)
    finally:
        process.kill()
        rest = process.communicate()[0]
    written += [int(line) for line in rest.split()]
    killed = time.time_ns()
    read = read_recording(bag)
    (finding,) = [f for f in read.warnings if f.topic == ""]
    assert "has no metadata.yaml, the recorder was stopped hard; it has no end" in finding.message
    assert f"recovered {len(read.drive)} messages" in finding.message
    newest = int(read.drive.stamps(read.epoch_ns)[-1])
    lost = [stamp for stamp in written if stamp > newest]
    assert all(killed - stamp < 3.5e9 for stamp in lost)
    assert not (bag / "metadata.yaml").exists()
    if rate < 1:
        assert len(lost) <= 3
