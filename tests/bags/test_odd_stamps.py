"""Stamps that are odd and may be right: said once, with file, topic and value, and used as they are."""

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import whole_bag
from ddh_twin_py.gap.recordings.contradictions import contradictions
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, TOPIC_TYPES, ZERO_CELSIUS
from support.bag_rows import write_rows

OIL = "temperature/tank_oil"


def recorded(path, recording, pace=1.0, epoch=None, topics=None):
    """A bag of which the recorder's clock is right and the stamps of some topics, or all, run at another pace, from another epoch, ns."""
    epoch = recording.epoch_ns if epoch is None else epoch
    with whole_bag(path) as writer:
        writer.write_rig(recording.rig, recording.epoch_ns)
        for name, stream in recording.streams():
            came = stream.stamps(recording.epoch_ns)
            stamps = epoch + (stream.time * 1e9 * (pace if topics is None or name in topics else 1.0)).astype(np.int64)
            values = stream.values - [ZERO_CELSIUS, 0.0] if name.startswith(TEMPERATURE_PREFIX) else stream.values
            write_rows(writer, f"/ddh/{name}", TOPIC_TYPES[name], stamps, values, came + 1_000_000)
    return path


@pytest.fixture(scope="module")
def minute(paper):
    """A minute of the paper's cycle, with strokes both ways."""
    return paper.between(0.0, 60.0)


@pytest.mark.parametrize("pace", [10.0, 0.1, 1e-3])
def test_a_pace_that_is_not_the_recorders_is_told_and_the_rod_says_so_too(tmp_path, minute, pace):
    path = recorded(tmp_path / "bag", minute, pace)
    read = read_recording(path)
    (finding,) = read.findings
    assert finding.field == "header.stamp" and finding.value == pytest.approx(pace, rel=0.01) and finding.severity == "info"
    assert finding.message.startswith(f"{path}: header.stamp of all topics in /ddh goes on {pace:.3g} times as fast as the recorder")
    (said,) = contradictions(read, load_rig())
    assert said.startswith(f"{path}: /ddh/hydraulics/telemetry rod_position goes ") and "seconds of header.stamp are likely" in said
    assert float(said.split(" goes ")[1].split()[0]) == pytest.approx(1.0 / pace, rel=0.02)


def test_a_topic_that_has_a_pace_of_its_own_is_named(tmp_path, minute):
    (finding,) = (f for f in read_recording(recorded(tmp_path / "bag", minute, 10.0, topics=[OIL])).findings if f.field)
    assert finding.topic == f"/ddh/{OIL}" and f"header.stamp of /ddh/{OIL} goes on 10 times as fast" in finding.message


@pytest.mark.parametrize("pace", [1.0, 1.05])
def test_nothing_is_said_of_a_pace_that_is_the_recorders(tmp_path, minute, pace):
    read = read_recording(recorded(tmp_path / "bag", minute, pace))
    assert read.findings == [] and contradictions(read, load_rig()) == []


def test_stamps_of_1970_are_a_remark(tmp_path, short):
    path = recorded(tmp_path / "bag", short, epoch=37 * 10**9)
    (finding,) = read_recording(path).findings
    assert finding.severity == "info" and finding.value == pytest.approx(37.0, abs=0.1) and finding.field == "header.stamp"
    assert finding.message.startswith(f"{path}: header.stamp begins at 37.") and "used as they are" in finding.message
