"""What `/diagnostics` says of clock and inputs: what happened, and no more."""

from types import SimpleNamespace

import pytest
from ddh_twin_py.nodes.health import Report, Stops, judge_age, judge_clock
from ddh_twin_py.nodes.inputs import Input
from ddh_twin_py.telemetry.clock import Break


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
