"""A topic by another clock in a bag, of which a recorder's own clock tells when each message came."""

import json

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import whole_bag
from ddh_twin_py.cli.main import main
from ddh_twin_py.estimation.fitting.experiment import Experiment, ExperimentError
from ddh_twin_py.estimation.replay import ReplayError, replay
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, TOPIC_TYPES, ZERO_CELSIUS
from ddh_twin_py.telemetry.spans import missing_ends
from support.bag_rows import write_rows

DRIVE, OIL = "drive/telemetry", "temperature/tank_oil"


def recorded(path, recording, topic="", by=0.0, since=0.0):
    """A bag as a recorder writes it: messages come up to 2 ms after they are measured; one topic's stamps are off by so many s."""
    rng = np.random.default_rng(1)
    with whole_bag(path) as writer:
        writer.write_rig(recording.rig, recording.epoch_ns)
        for name, stream in recording.streams():
            stamps = stream.stamps(recording.epoch_ns)
            came = np.maximum.accumulate(stamps + rng.integers(500_000, 2_000_000, stamps.size))
            values = stream.values - [ZERO_CELSIUS, 0.0] if name.startswith(TEMPERATURE_PREFIX) else stream.values
            off = np.where(stream.time >= since, round(by * 1e9), 0) if name == topic else 0
            write_rows(writer, f"/ddh/{name}", TOPIC_TYPES[name], stamps + off, values, came)
    return path


@pytest.mark.parametrize("since", [0.0, 6.0])
@pytest.mark.parametrize("by", [-700.0, 60.0])
def test_it_is_left_out_and_named(tmp_path, short, by, since):
    path = recorded(tmp_path / "bag", short, OIL, by, since)
    read = read_recording(path)
    (finding,) = [f for f in read.findings if f.field == "header.stamp"]
    kept = int(np.count_nonzero(short.temperatures["tank_oil"].time < since))
    assert finding.topic == f"/ddh/{OIL}" and finding.value == pytest.approx(by, abs=0.01)
    assert finding.count == len(short.temperatures["tank_oil"]) - kept and finding.first_time == pytest.approx(since, abs=1.0)
    where = f"is stamped {abs(by):.1f} s {'ahead of' if by > 0.0 else 'behind'} the others"
    assert finding.message.startswith(str(path)) and finding.message.endswith(where)
    assert len(read.temperatures.get("tank_oil", ())) == kept
    assert read.duration == pytest.approx(short.duration, abs=0.1) and read.epoch_ns == pytest.approx(short.epoch_ns, abs=1e8)
    assert bool(missing_ends(read)) == bool(kept)


def test_the_rest_is_replayed_as_if_it_were_not_there(tmp_path, short):
    read = read_recording(recorded(tmp_path / "bag", short, OIL, 60.0))
    streams = {name: stream for name, stream in short.streams() if name != OIL}
    told, expected = replay(read, load_rig()), replay(short.with_streams(streams), load_rig())
    assert np.array_equal(told.time, expected.time) and np.allclose(told.fused, expected.fused, atol=1e-6)


def test_a_bag_whose_clocks_agree_loses_nothing(tmp_path, short):
    read = read_recording(recorded(tmp_path / "bag", short))
    assert read.findings == [] and read.samples() == short.samples()


def test_a_drive_that_is_left_out_is_why_it_is_refused(tmp_path, short):
    read = read_recording(recorded(tmp_path / "bag", short, DRIVE, 60.0))
    assert [f.message.split(": ")[1].split(", the motor")[0] for f in read.warnings[1:]] == [f"topic /ddh/{DRIVE} is left out"]
    said = f"all {len(short.drive)} messages on /ddh/{DRIVE} are of another clock .* 60.0 s ahead of the others; "
    for refuses, error in ((replay, ReplayError), (Experiment, ExperimentError)):
        with pytest.raises(error, match=said):
            refuses(read, load_rig())


def test_info_names_it(tmp_path, short, capsys):
    assert main(["info", str(recorded(tmp_path / "bag", short, OIL, 60.0)), "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [finding["value"] for finding in told["findings"] if finding["topic"] == f"/ddh/{OIL}"] == pytest.approx([60.0], abs=0.01)
