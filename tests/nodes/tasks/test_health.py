"""What `/diagnostics` says of clock and inputs: what happened, and no more."""

import re
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from ddh_twin_py.nodes.base.inputs import Input
from ddh_twin_py.nodes.base.node_base import TwinNode
from ddh_twin_py.nodes.tasks.health import Health, Report, judge_age, judge_clock
from ddh_twin_py.nodes.tasks.silent_inputs import SilentInputs
from ddh_twin_py.nodes.tasks.stops import Stops, StopsTold
from ddh_twin_py.nodes.tasks.stream_judge import StreamJudge
from ddh_twin_py.telemetry.alignment.tick_aligner import TickAligner
from ddh_twin_py.telemetry.clocks.clock import Break
from ddh_twin_py.telemetry.screening.alike_watch import AlikeWatch
from ddh_twin_py.telemetry.screening.screening import StreamScreen


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

    def known(lengths, pauses, wall):
        stops.note(lengths, pauses, wall)
        return stops.count

    assert [known(*now) for now in (([], 0, 0.0), ([700.0], 0, 10.0), ([], 1, 11.0), ([], 1, 30.0))] == [0, 0, 0, 0], "the clock went ahead"
    assert [known(*now) for now in (([30.0], 1, 40.0), ([800.0], 1, 46.0), ([], 2, 56.0), ([], 2, 62.0))] == [0, 0, 1, 1]
    assert stops.first == 30.0, "it stopped by itself"


def test_a_stop_is_not_excused_by_a_pause_of_long_ago():
    stops = Stops()
    for lengths, wall in (([], 0.0), ([700.0], 1000.0), ([], 1100.0)):
        stops.note(lengths, 3, wall)
    assert (stops.count, stops.first) == (1, 700.0)
    stops.note([], 4, 1200.0)
    stops.note([900.0], 4, 1210.0)  # a stream that is told seldom comes back after all others
    stops.note([], 4, 1300.0)
    assert stops.count == 1


TOPICS = ("drive/telemetry", "hydraulics/telemetry", "temperature/ambient")
DRIVE, AMBIENT = TOPICS[0], TOPICS[2]


def heard(off, paused=np.inf, seconds=50, every=None, still=(0.0, 0.0)):
    """What three inputs of a node log, and what `/diagnostics` says of each, of stamps that are off by so many s, given by topic and s.

    A topic tells 50 times a second, or each so many 1/50 s. After `paused`, s, all went on later.
    The process stands still between two times, s, and hears nothing of them.
    """
    width, every = dict(zip(TOPICS, (6, 4, 2), strict=True)), every or {}
    names = {topic: SimpleNamespace(topic_name=f"/ddh/{topic}") for topic in TOPICS}
    feed = SimpleNamespace(
        alike=AlikeWatch({}),
        aligner=TickAligner(width, awaited=TOPICS[:2]), screens={topic: StreamScreen(topic) for topic in TOPICS}, last={},
        inputs=SimpleNamespace(all={topic: Input(topic, object, None, names[topic], received=1, arrived=0.0) for topic in TOPICS}),
    )  # fmt: skip
    wall, lines, shown = 0.0, [], {topic: {} for topic in TOPICS}
    node = SimpleNamespace(wall=lambda: wall, _said=set(), _met={}, count_publishers=lambda topic: 1,
                           get_logger=lambda: SimpleNamespace(warning=lines.append))  # fmt: skip
    node.warn_once, node.warn_again = partial(TwinNode.warn_once, node), partial(TwinNode.warn_again, node)
    told = StopsTold(node)
    judges = {topic: StreamJudge(node, feed, topic, True, np.inf, lambda wall: False, lambda: int(wall > paused), told,
                                 SilentInputs(node, lambda wall: False)) for topic in TOPICS}
    for k in (k for k in range(1, 50 * seconds) if not still[0] < 0.02 * k < still[1]):
        for topic in TOPICS:
            if k % every.get(topic, 1) == 0:
                stamp = 10**18 + k * 20_000_000 + round(off(topic, 0.02 * k) * 1e9)
                feed.screens[topic].screen([stamp], np.full((1, width[topic]), 300.0 + 0.01 * np.sin(k) if topic == AMBIENT else 0.0))
                feed.aligner.push(topic, stamp, np.zeros(width[topic]))
        list(feed.aligner.ready())
        if k % 50 == 0:
            wall = 0.02 * k
            for topic, judge in judges.items():
                report = Report("", "")
                shown[topic][wall] = report.finished(judge(report)).message
    return [text for text in lines if "clock" in text or "came back" in text or "missing" in text], shown


def stepping(topic, *steps):
    """The stamps of one topic off by so many s from a time on, s."""
    return lambda name, t: next((off for since, off in reversed(steps) if name == topic and t > since), 0.0)


def test_stamps_that_nobody_sets_are_said_to_be_so():
    _, shown = heard(lambda topic, t: -1e9 - t if topic == AMBIENT else 0.0, seconds=20)
    (repeated,) = re.findall(r"repeated [^;]*", shown[AMBIENT][15.0])
    assert repeated.endswith(", all stamps are 0: nobody set header.stamp")
    assert "nobody set" not in shown[DRIVE][15.0]


def off_in(said):
    """By how many s a sentence says that a stamp is off."""
    off, side = re.search(r"a stamp (\S+) s (behind|ahead of) the others", said).groups()
    return float(off) * (-1.0 if side == "behind" else 1.0)


def test_a_clock_that_goes_ahead_is_no_stop_of_any_stream():
    assert heard(lambda topic, t: 700.0 if t > 20.0 else 0.0, paused=20.0)[0] == []


@pytest.mark.parametrize("topic", TOPICS)
@pytest.mark.parametrize("off", [-60.0, 5.0, 60.0, 700.0])
def test_a_stream_whose_clock_was_wrong_for_a_while_is_said_to_be_off_and_not_to_have_stopped(off, topic):
    (said,), shown = heard(stepping(topic, (20.0, off), (35.0, 0.0)), seconds=60)
    assert said.startswith(f"/ddh/{topic}: a stamp ") and "s: of another clock, dropped; is a clock wrong" in said
    assert re.fullmatch(r"a stamp .* of another clock, dropped \(\d+ times\)", shown[topic][30.0])
    assert off_in(said) == off_in(shown[topic][30.0]) == pytest.approx(off, abs=0.1)
    assert {message for name in TOPICS for wall, message in shown[name].items() if name != topic or wall > 47.0} == {"well"}


def test_each_step_of_a_clock_that_is_wrong_is_named():
    steps = {20.0: -60.0, 40.0: 60.0, 60.0: -3600.0, 90.0: -60.0}
    there_and_back = [step for since, off in steps.items() for step in ((since, off), (since + 15.0, 0.0))]
    lines, shown = heard(stepping(DRIVE, *there_and_back), seconds=120)
    assert [off_in(line) for line in lines] == pytest.approx(list(steps.values()), abs=0.1)
    assert [off_in(shown[DRIVE][since + 10.0]) for since in steps] == pytest.approx(list(steps.values()), abs=0.1)


def test_a_clock_that_steps_some_seconds_is_named_each_time_and_nobody_else_is():
    lines, shown = heard(stepping(DRIVE, (20.0, 5.0), (30.0, 0.0), (40.0, 8.0), (50.0, 0.0)), seconds=70)
    assert [off_in(line) for line in lines] == pytest.approx([5.0, 8.0], abs=0.1)
    assert all("of another clock, dropped; is a clock wrong" in line and DRIVE in line for line in lines)
    assert {message for topic in TOPICS[1:] for message in shown[topic].values()} == {"well"}


def test_of_a_clock_that_never_rests_there_are_a_few_lines_a_minute():
    lines, _ = heard(stepping(DRIVE, *((20.0 + 4.0 * k, 100.0 * (k + 1)) for k in range(25))), seconds=125)
    assert 8 < len(lines) < 20 and sum("times since this was last said" in line for line in lines) == 1


def test_a_lone_stamp_of_another_clock_is_no_stop_no_jump_and_leaves_no_message_missing():
    lines, shown = heard(lambda topic, t: 60.0 if topic == AMBIENT and 99.0 < t < 101.0 else 0.0, seconds=200, every={AMBIENT: 100})
    (said,) = lines
    assert said.startswith("/ddh/temperature/ambient: a stamp ") and off_in(said) == pytest.approx(60.0, abs=2.1)
    assert {message for message in shown[AMBIENT].values() if "another clock" not in message} == {"well"}


def test_what_is_missed_while_the_process_stands_still_is_no_stop_of_a_stream():
    lines, shown = heard(lambda topic, t: 0.0, still=(20.5, 40.5), seconds=70)
    assert lines == [] and {message for topic in TOPICS for message in shown[topic].values()} == {"well"}


def test_a_stream_that_stopped_is_said_to_have_come_back():
    lines, shown = heard(lambda topic, t: 60.0 if t > 20.0 else 0.0)
    (said,) = (line for line in lines if "came back" in line)
    assert said.startswith(f"{', '.join(f'/ddh/{topic}' for topic in TOPICS)} stopped and came back, first after 60.0 to 60.")
    assert shown[DRIVE][40.0] == "stopped and came back (1 times)"


@pytest.mark.parametrize(("looks", "stood"), [(range(60), False), ([0, 1, 9], False), ([0, 1, *range(31, 100)], True)])
def test_a_node_that_did_nothing_for_a_while_says_so_at_once_and_for_a_minute(looks, stood):
    warned, shown, walls = [], [], iter([float(wall) for wall in looks])
    node = SimpleNamespace(
        wall=lambda: next(walls), every=lambda period, callback: None, warn_again=lambda cause, text: warned.append(text),
        create_publisher=lambda *_: SimpleNamespace(publish=shown.append), get_fully_qualified_name=lambda: "/ddh/node",
        get_clock=lambda: SimpleNamespace(now=lambda: SimpleNamespace(to_msg=Time)),
    )  # fmt: skip
    health = Health(node)
    for _ in looks:
        health.publish()
    said = "did nothing for 30 s, as it was stopped or the computer is too slow; what came meanwhile may be lost"
    assert warned == ([f"this node {said}"] if stood else [])
    told = [(status.name, status.message) for array in shown for status in array.status]
    assert told == [("ddh/node: process", said if stood and 31 <= wall < 91 else "goes on") for wall in looks]
