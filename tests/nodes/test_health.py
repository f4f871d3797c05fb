"""What `/diagnostics` says of clock and inputs: what happened, and no more."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.nodes.health import Report, Stops, StreamJudge, judge_age, judge_clock
from ddh_twin_py.nodes.inputs import Input
from ddh_twin_py.telemetry.clock import Break
from ddh_twin_py.telemetry.screening import StreamScreen
from ddh_twin_py.telemetry.tick_aligner import TickAligner


@pytest.mark.parametrize(
    ("jumps", "breaks", "rests", "said", "restarts"),
    [
        (0, {}, False, "runs forward", "0"),
        (0, {Break.PAUSE: 1}, False, "runs forward", "1"),
        (0, {Break.PAUSE: 1}, True, "runs forward", "0"),
        (1, {}, False, "jumped back once", "0"),
        (1, {Break.PUT_BACK: 1}, False, "jumped back once; the state went on once", "0"),
        (2, {Break.OTHER_TIME: 2}, True, "jumped back 2 times; the state was reset 2 times", "2"),
        (3, {Break.PUT_BACK: 1, Break.OTHER_TIME: 2, Break.PAUSE: 1}, False,
         "jumped back 3 times; the state went on once and was reset 2 times", "3"),
    ],
)  # fmt: skip
def test_the_clock_is_said_to_have_done_what_it_did(jumps, breaks, rests, said, restarts):
    report = Report("ddh/node: clock", "")
    status = report.finished(judge_clock(report, jumps, breaks, rests))
    values = {entry.key: entry.value for entry in status.values}
    assert status.message == said and values["model restarts [1]"] == restarts and values["backward jumps [1]"] == str(jumps)


def stale_at(arrivals, asked):
    """At which of the times asked, s, an input that came at those times is called stale, with a limit of 2 s."""
    entry, stale, waiting = Input("drive/telemetry", object, None, SimpleNamespace(topic_name="/ddh/drive/telemetry")), [], list(arrivals)
    for wall in asked:
        while waiting and waiting[0] <= wall:
            entry.note_arrival(waiting.pop(0))
        judge_age(report := Report("", ""), entry, wall, 2.0, True)
        if report.finished("").message:
            stale.append(wall)
    return stale


def test_an_input_that_comes_with_seconds_at_once_is_not_stale_in_between():
    bursts = [burst + k * 0.01 for burst in range(0, 60, 3) for k in range(5)]
    assert all(wall < 6.0 for wall in stale_at(bursts, [0.5 * k for k in range(120)]))
    assert 63.0 in stale_at(bursts, [60.0, 63.0]), "it stopped"


def test_an_input_that_stopped_once_is_stale_as_soon_as_before():
    steady = [0.02 * k for k in range(3000) if not 500 <= k < 1000]  # from 10 to 20 s nothing
    assert stale_at(steady, [11.0, 13.0, 19.0, 21.0, 59.0, 61.5, 62.5]) == [13.0, 19.0, 62.5]


def test_what_all_streams_left_out_is_no_stop_of_one():
    stops = Stops()
    assert [stops.alone(*now) for now in ((0, 0, 0.0), (1, 0, 10.0), (1, 1, 11.0), (1, 1, 20.0))] == [0, 0, 0, 0], "the clock went ahead"
    assert [stops.alone(*now) for now in ((2, 1, 30.0), (2, 1, 36.0), (2, 2, 40.0))] == [0, 1, 1], "it stopped by itself"


TOPICS = ("drive/telemetry", "hydraulics/telemetry", "temperature/ambient")


def logged(off, pauses, seconds=50):
    """What three inputs of a node log of a drive whose stamps are off by so many s, as given by the time in s, and of the others."""
    width = dict(zip(TOPICS, (6, 4, 2), strict=True))
    names = {topic: SimpleNamespace(topic_name=f"/ddh/{topic}") for topic in TOPICS}
    feed = SimpleNamespace(
        aligner=TickAligner(width, awaited=TOPICS[:2]), screens={topic: StreamScreen(topic) for topic in TOPICS}, last={},
        inputs=SimpleNamespace(all={topic: Input(topic, object, None, names[topic], received=1, arrived=0.0) for topic in TOPICS}),
    )  # fmt: skip
    said = {}
    node = SimpleNamespace(wall=lambda: wall, warn_once=said.setdefault, count_publishers=lambda topic: 1)
    judges = [StreamJudge(node, feed, topic, True, np.inf, lambda wall: False, lambda: pauses) for topic in TOPICS]
    for k in range(1, 50 * seconds):
        for topic in TOPICS:
            stamp = 10**18 + k * 20_000_000 + round(off(topic, 0.02 * k) * 1e9)
            feed.screens[topic].screen([stamp], np.full((1, width[topic]), 300.0 + 0.1 * np.sin(k)))
            feed.aligner.push(topic, stamp, np.zeros(width[topic]))
        list(feed.aligner.ready())
        if k % 50 == 0:
            wall = 0.02 * k
            for judge in judges:
                judge(Report("", ""))
    return [text for text in said.values() if "clock" in text or "came back" in text or "missing" in text]


def test_a_clock_that_goes_ahead_is_no_stop_of_any_stream():
    assert logged(lambda topic, t: 700.0 if t > 20.0 else 0.0, pauses=1) == []


def test_a_stream_whose_clock_was_wrong_for_a_while_is_said_to_be_off_and_not_to_have_stopped():
    (said,) = logged(lambda topic, t: -60.0 if topic == "drive/telemetry" and 20.0 < t < 35.0 else 0.0, pauses=0)
    assert said.startswith(("/ddh/drive/telemetry: a stamp 60.0", "/ddh/drive/telemetry: a stamp 59.9"))
    assert "s behind the others: of another clock, dropped; is a clock wrong" in said


def test_a_stream_that_stopped_is_said_to_have_come_back():
    said, *_ = logged(lambda topic, t: 60.0 if t > 20.0 else 0.0, pauses=0)
    assert "/ddh/drive/telemetry stopped once and came back, first after 60" in said
