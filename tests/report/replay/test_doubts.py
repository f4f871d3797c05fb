"""What keeps a replay's free run from being judged stands before what its numbers say."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.report.replay.agreement import compare
from ddh_twin_py.telemetry.recording import Finding, RigInfo, drive_stream


def unread(result):
    result.measured["rod_position"] = np.nan
    return result


def slow(result):
    return replace(result, recording=replace(result.recording, drive=drive_stream(np.arange(20.0), np.zeros((20, 6)))))


def jumped(result):
    return replace(result, time=np.concatenate([result.time[:300], result.time[50:150]]))


def put_back(result):
    return replace(result, time=np.concatenate([result.time[:200], result.time[150:350]]))


def short(result):
    return replace(result, time=0.3 * result.time)


def uncommanded(result):
    values = np.zeros((400, 6))
    values[:, 0] = np.nan
    return replace(result, recording=replace(result.recording, drive=drive_stream(0.05 * np.arange(400), values)))


def of_another_rig(result):
    return replace(result, rig=replace(result.rig, rig_id="rig_006"),
                   recording=replace(result.recording, rig=RigInfo("rig_012", "ISO VG 32", 100.0)))


def in_rpm(result):
    return replace(result, recording=result.recording.with_streams(dict(result.recording.streams()), [
        Finding("error", "bag", "drive/telemetry", "speed", 470.0, 9, "speed looks as if given in rpm")]))


def off_its_zero(result):
    return replace(result, zero_error=("tank_oil", 36.0, 10.9))


@pytest.mark.parametrize(("spoilt", "says"), [
    (off_its_zero, "temperature/tank_oil is held to read +10.9 K off, 36 standard deviations of its zero error"),
    (unread, "rod position is not read"), (uncommanded, "there is no speed command"),
    (slow, "comes every 1.00 s and the free run needs it every 0.25 s"),
    (jumped, "the clock jumped back once, and where it did by more than 10 s all began anew"),
    (put_back, "the clock jumped back once, by 10 s or less, and the twin went on as warm as it was"),
    (short, "6 s say next to nothing of temperatures"),
    (in_rpm, "speed looks as if given in rpm"),
    (of_another_rig, "the rig file describes rig_006 and the recording is of rig_012"),
])  # fmt: skip
def test_it_is_said_first(result, spoilt, says):
    agreement = compare(spoilt(result))
    assert agreement.verdict.startswith("Careful: ") and says in agreement.verdict.split(". Given")[0] and agreement.level != "good"
    assert len(agreement.doubts) == 1 and agreement.as_json()["doubts"] == list(agreement.doubts)


def test_nothing_is_said_where_nothing_is_in_the_way(result):
    assert compare(result).doubts == () and compare(result).verdict.startswith("Given")
