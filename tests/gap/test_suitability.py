"""Recordings that allow no diagnosis, and those that are taken for one another."""

from dataclasses import replace

import pytest
from ddh_twin_py.gap.suitability import out_of_order, undriven
from ddh_twin_py.telemetry.recording import Stream
from support.simulated import simulated

DAY = 86_400 * 10**9


@pytest.fixture(scope="module")
def recording():
    return simulated(1, "mixed", 60.0)[0]


def test_a_command_that_comes_too_seldom_drives_no_free_run(recording):
    assert undriven(recording) == ""
    drive = recording.drive
    every = round(1.0 / (drive.time[1] - drive.time[0]))
    slow = replace(recording, drive=Stream(drive.time[::every], drive.values[::every], drive.fields))
    assert "/drive/telemetry: comes every 1 s, and the free run needs its command at least every 0.25 s" in undriven(slow)


def test_a_rig_as_built_that_is_younger_than_the_field_is_noted(recording):
    later = replace(recording, path="new", epoch_ns=recording.epoch_ns + 40 * DAY)
    assert out_of_order([recording], None) == out_of_order([later], recording) == out_of_order([recording], recording) == []
    (note,) = out_of_order([later, recording], later)
    assert note.startswith(f"new is given as the rig as built, but was recorded 40 days after {recording.path}")
