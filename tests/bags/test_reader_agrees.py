"""Bulk decoding against rosbags' own, message by message."""

import numpy as np
from ddh_twin_py.bags.reader import read_recording
from rosbags.highlevel import AnyReader


def test_bulk_decoding_is_rosbags_decoding(paper_cycle_bag):
    recording = read_recording(paper_cycle_bag)
    streams = dict(recording.streams())
    expected = {}
    with AnyReader([paper_cycle_bag]) as reader:
        for connection, _, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            relative = connection.topic.removeprefix("/ddh/")
            if relative == "rig":
                assert message.payload_mass == recording.rig.payload_mass
                continue
            fields = streams[relative].fields
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            expected.setdefault(relative, []).append((stamp, *(getattr(message, f) for f in fields)))
    assert set(expected) == set(streams)
    for relative, rows in expected.items():
        stamps = np.array([row[0] for row in rows])
        values = np.array([row[1:] for row in rows])
        if relative.startswith("temperature/"):
            values[:, 0] += 273.15
        np.testing.assert_array_equal(streams[relative].stamps(recording.epoch_ns), stamps)
        np.testing.assert_array_equal(streams[relative].values, values)
