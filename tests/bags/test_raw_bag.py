"""Messages of a bag for playing back come in order of arrival, however they stand in its files."""

import re

import numpy as np
import pytest
from ddh_twin_py.bags.compression import zstd
from ddh_twin_py.bags.damage import storage_file
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.sources.raw_bag import RawBag
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

SECOND = 1_000_000_000


def rewritten(bag, target, messages, storage=StoragePlugin.MCAP, mode=CompressionMode.NONE):
    """The bag again, MCAP in chunks of 300 messages; ``messages`` makes (connection, log time, CDR) of the list of them."""
    writer = Writer(target, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with AnyReader([bag]) as reader, writer:
        ids = {c.id: writer.add_connection(c.topic, c.msgtype, typestore=reader.typestore) for c in reader.connections}
        for i, (connection, at, raw) in enumerate(messages(list(reader.messages()))):
            writer.write(ids[connection.id], at, raw)
            if storage is StoragePlugin.MCAP and i % 300 == 299:
                writer.storage.close_chunk()
    return target


def played(bag, start_ns=None):
    """(topic, log time, CDR) of all messages as they are played; each block by itself in order of log time."""
    raw, found = RawBag(bag), []
    for block in raw.blocks(start_ns):
        assert np.all(np.diff(block.log_time) >= 0)
        found += [(raw.topics[number][0], *rest) for number, *rest in zip(block.topic.tolist(), block.log_time.tolist(), block.messages,
                                                                          strict=True)]
    raw.close()
    return found


def swapped(messages):
    return messages[len(messages) // 2 :] + messages[: len(messages) // 2]


def shuffled(messages):
    order = np.random.default_rng(1).permutation(len(messages))
    return [messages[i] for i in order]


def interleaved(messages):
    """Each stretch of 1000 messages changes places with the next one."""
    return [message for i in range(0, len(messages), 2000) for message in messages[i + 1000 : i + 2000] + messages[i : i + 1000]]


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
@pytest.mark.parametrize("disorder", [swapped, shuffled, interleaved])
def test_messages_are_played_in_order_of_log_time(tmp_path, bag, disorder, storage):
    target = rewritten(bag, tmp_path / "odd", disorder, storage)
    right, found = played(bag), played(target)
    assert [at for _, at, _ in found] == sorted(at for _, at, _ in found)
    assert sorted(found) == sorted(right)
    middle = right[len(right) // 3][1]
    assert played(target, middle) == [message for message in found if message[1] >= middle]


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_files_of_a_bag_are_played_in_order_of_log_time(tmp_path, bag, storage):
    folder = tmp_path / "parts"
    folder.mkdir()
    for name, half in (("a", lambda messages: swapped(messages)[: len(messages) // 2]), ("b", lambda m: m[: len(m) // 2])):
        file = storage_file(rewritten(bag, tmp_path / name, half, storage))
        file.rename(folder / f"{name}{file.suffix}")
    found = played(folder)
    assert [at for _, at, _ in found] == sorted(at for _, at, _ in found) and sorted(found) == sorted(played(bag))


def test_packed_messages_are_put_in_order_too(tmp_path, bag):
    target = rewritten(bag, tmp_path / "odd", swapped, mode=CompressionMode.MESSAGE)
    assert sorted(played(bag)) == sorted(played(target)) and [at for _, at, _ in played(target)] == [at for _, at, _ in played(bag)]


def test_a_packed_message_that_is_damaged_is_left_out_and_named(tmp_path, bag):
    target = rewritten(bag, tmp_path / "odd", list, mode=CompressionMode.MESSAGE)
    file = storage_file(target)
    content = file.read_bytes()
    frames = [m.start() for m in re.finditer(re.escape(b"\x28\xb5\x2f\xfd"), content)]  # as zstd begins
    at = frames[len(frames) // 2]
    file.write_bytes(content[:at] + b"\0" + content[at + 1 :])
    right, found = played(bag), played(target)
    assert len(found) == len(right) - 1 and set(found) < set(right)
    ((topic, *_),) = set(right) - set(found)
    raw = RawBag(target)
    assert raw.notes == [f"holds 1 messages on {topic} that cannot be unpacked and are left out"] and raw.count == len(found)
    raw.close()
    assert sum(len(stream) for _, stream in read_recording(target).streams()) == len(found) - 1  # without the rig's


def test_of_a_packed_file_that_is_cut_what_can_be_unpacked_is_played(tmp_path, bag):
    file = storage_file(rewritten(bag, tmp_path / "plain", list))
    packed = tmp_path / "cut.mcap.zstd"
    content = zstd.compress(file.read_bytes())
    packed.write_bytes(content[: len(content) * 9 // 10])
    found, read = played(packed), read_recording(packed)
    assert len(found) > 0.5 * len(played(bag)) and set(found) <= set(played(bag))
    assert len(found) == 1 + sum(len(stream) for _, stream in read.streams())


def test_after_the_recorders_clock_was_set_back_messages_come_as_they_stand(tmp_path, bag):
    def set_back(messages):
        half = messages[len(messages) // 2][1]
        return [(connection, at - 3 * SECOND * (at > half), raw) for connection, at, raw in messages]

    target = rewritten(bag, tmp_path / "back", set_back)
    found = played(target)
    assert [(topic, raw) for topic, _, raw in found] == [(topic, raw) for topic, _, raw in played(bag)]
    assert np.flatnonzero(np.diff([at for _, at, _ in found]) < 0).size == 1
    raw, whole = RawBag(target), RawBag(bag)
    blocks = list(raw.blocks())
    due, log_time = (np.concatenate([getattr(block, name) for block in blocks]) for name in ("due", "log_time"))
    assert np.all(np.diff(due) >= 0) and {0, 3 * SECOND} <= {round(off, -8) for off in (due - log_time).tolist()}
    assert (raw.begin_ns, raw.end_ns) == (due[0], due[-1]) and raw.duration == pytest.approx(whole.duration, abs=0.1)
    assert np.concatenate([block.due for block in raw.blocks(int(due[-5]))]).tolist() == due[-5:].tolist()
    raw.close()
    whole.close()


def test_of_several_files_the_damaged_one_is_named(tmp_path, bag):
    folder = tmp_path / "parts"
    folder.mkdir()
    for number, half in enumerate((lambda messages: messages[: len(messages) // 2], lambda messages: messages[len(messages) // 2 :])):
        storage_file(rewritten(bag, tmp_path / str(number), half)).rename(folder / f"parts_{number}.mcap")
    last = folder / "parts_1.mcap"
    with last.open("r+b") as opened:
        opened.truncate(last.stat().st_size * 8 // 10)
    raw = RawBag(folder)
    (note,) = (note for note in raw.notes if "parts_1" in note)
    assert note.startswith("has no end") and note.endswith(" (parts_1.mcap)")
    assert any(note in finding.message for finding in read_recording(folder).findings)
    raw.close()


def test_what_is_recorded_at_its_stamp_and_lags_is_no_clock_set_back(tmp_path, bag):
    def lagging(messages):
        """Outputs come in batches, seconds after what they tell of; on one topic, two publishers lag unlike."""
        def comes(number, connection, at):
            if "hydraulics" in connection.topic:
                return (at // (SECOND // 2)) * (SECOND // 2) + 2 * SECOND
            return at + (number % 2) * 5 * SECOND // 2 if "housing" in connection.topic else at

        return [message for _, message in sorted(((comes(i, m[0], m[1]), m) for i, m in enumerate(messages)), key=lambda item: item[0])]

    target = rewritten(bag, tmp_path / "lagging", lagging)
    assert sorted(played(target)) == sorted(played(bag))
    raw, whole = RawBag(target), RawBag(bag)
    assert raw.duration == whole.duration
    due = np.concatenate([block.due for block in raw.blocks()])
    assert np.all(np.diff(due) >= 0) and due[-1] - due[0] == round(whole.duration * SECOND)
    raw.close()
    whole.close()


def test_a_topic_that_begins_with_another_clock_comes_where_it_stands(tmp_path, bag):
    def ahead(messages):
        """Every third message of one topic is by a clock that is a year ahead."""
        return [(c, at + 365 * 86_400 * SECOND * ("housing" in c.topic and i % 3 == 0), raw) for i, (c, at, raw) in enumerate(messages)]

    target = rewritten(bag, tmp_path / "ahead", ahead)
    assert [(topic, raw) for topic, _, raw in played(target)] == [(topic, raw) for topic, _, raw in played(bag)]
    raw, whole = RawBag(target), RawBag(bag)
    assert raw.duration == pytest.approx(whole.duration, abs=0.01)
    raw.close()
    whole.close()


@pytest.mark.parametrize(("hole", "waited"), [(300, 300), (86_400, 0)])
def test_a_recorders_clock_that_was_set_ahead_is_not_waited_for_and_a_pause_of_minutes_is(tmp_path, bag, hole, waited):
    def later(messages):
        half = messages[len(messages) // 2][1]
        return [(connection, at + hole * SECOND * (at > half), raw) for connection, at, raw in messages]

    target = rewritten(bag, tmp_path / "ahead", later)
    assert [(topic, raw) for topic, _, raw in played(target)] == [(topic, raw) for topic, _, raw in played(bag)]
    raw, whole = RawBag(target), RawBag(bag)
    assert raw.duration == pytest.approx(whole.duration + waited, abs=0.1)
    blocks = list(raw.blocks())
    due, log_time = (np.concatenate([getattr(block, name) for block in blocks]) for name in ("due", "log_time"))
    assert np.all(np.diff(due) >= 0) and (raw.begin_ns, raw.end_ns) == (due[0], due[-1])
    assert np.ptp(log_time - due) == pytest.approx((hole - waited) * SECOND, abs=0.1 * SECOND)
    assert np.concatenate([block.due for block in raw.blocks(int(due[-5]))]).tolist() == due[-5:].tolist()
    said = [note for note in raw.notes if "is not waited for" in note]
    assert len(said) == (not waited) and all(note.startswith(f"holds nothing for {hole} s at ") for note in said)
    raw.close()
    whole.close()
