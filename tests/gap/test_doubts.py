"""What is doubtful about recordings reaches the notes."""

from dataclasses import replace

from ddh_twin_py.gap.doubts import doubts
from ddh_twin_py.telemetry.recording import Finding, Recording


def finding(severity, message, field=""):
    return Finding(severity, "bag", "topic", field, None, 1, message)


def recording(*findings):
    return replace(Recording("bag", 0, None, None, None, {}), findings=tuple(findings))


def test_errors_come_first_and_what_is_no_warning_is_left_out():
    given = recording(finding("warning", "out of order"), finding("info", "oil not told"), finding("warning", "NaN", "speed"),
                      finding("error", "in bar", "pressure"))
    assert doubts([given]) == ["in bar", "NaN", "out of order"]


def test_many_warnings_are_counted():
    notes = doubts([recording(*(finding("warning", f"warning {i}") for i in range(9))), recording()])
    assert len(notes) == 7 and notes[-1] == "bag: 3 further warnings; ddh-twin info lists them"
