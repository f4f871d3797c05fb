"""What `/diagnostics` says of the clock: what happened, and no more."""

import pytest
from ddh_twin_py.nodes.health import Report, judge_clock
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
