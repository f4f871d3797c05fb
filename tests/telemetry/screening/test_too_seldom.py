"""Streams of the machine that come too seldom are named with their rate."""

import pytest
from ddh_twin_py.telemetry.recording import Stream
from ddh_twin_py.telemetry.screening.screening import screen_recording
from ddh_twin_py.telemetry.screening.too_seldom import too_seldom
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC


def thinned(recording, rate, *topics):
    """Of topics only so many samples a second, as far as they go into the recording's whole number of times."""
    streams = dict(recording.streams())
    for topic in topics:
        stream = streams[topic]
        every = round((stream.time.size - 1) / (stream.time[-1] - stream.time[0]) / rate)
        streams[topic] = Stream(stream.time[::every], stream.values[::every], stream.fields)
    return recording.with_streams(streams)


def test_topic_and_rate_are_named(paper, noise):
    screened = screen_recording(thinned(paper, 1.0, DRIVE_TOPIC, HYDRAULIC_TOPIC), noise)
    said = [finding.message for finding in screened.findings if "Hz" in finding.message]
    assert said == [f"{paper.path}: /ddh/{topic} comes at 1.0 Hz; 50 to 1000 Hz are needed: what happens between two samples is lost"
                    for topic in (DRIVE_TOPIC, HYDRAULIC_TOPIC)]


@pytest.mark.parametrize(("rate", "named"), [(50.0, 0), (25.0, 0), (10.0, 1)])
def test_of_one_in_each_interval_nothing_is_said(paper, rate, named):
    found = too_seldom(thinned(paper, rate, HYDRAULIC_TOPIC))
    assert len(found) == named and all(f.value == pytest.approx(rate, rel=0.02) and f.severity == "warning" for f in found)


def test_of_temperatures_and_of_few_samples_nothing_is_said(paper):
    assert not too_seldom(thinned(paper, 0.1, "temperature/tank_oil"))
    assert not too_seldom(thinned(paper.between(0.0, 5.0), 1.0, DRIVE_TOPIC))
