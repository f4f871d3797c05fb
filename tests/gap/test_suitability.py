"""Recordings that allow no diagnosis, and those that are taken for one another."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.experiment import ExperimentError
from ddh_twin_py.gap.diagnose import Recordings, diagnose
from ddh_twin_py.gap.suitability import no_twice, out_of_order, undriven
from ddh_twin_py.rig import load_rig
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


def with_value(recording, value):
    """The recording with another first value of the drive."""
    values = recording.drive.values.copy()
    values[0, 1] = value
    return replace(recording, drive=Stream(recording.drive.time, values, recording.drive.fields))


@pytest.mark.parametrize("roles", [
    lambda one, copy, other: Recordings([one, copy]),
    lambda one, copy, other: Recordings([copy], commissioning=one),
    lambda one, copy, other: Recordings([one], commissioning=other, validation=copy),
    lambda one, copy, other: Recordings([other], commissioning=one, validation=copy),
])
def test_a_copy_of_a_recording_is_refused_in_any_role(roles, recording):
    one = replace(with_value(recording, np.nan), path="one")  # what is not known is the same too
    copy, other = replace(with_value(recording, np.nan), path="one/one.mcap"), with_value(recording, 0.0)
    with pytest.raises(ExperimentError, match="^one and one/one.mcap are the same recording; its samples would count twice$"):
        diagnose(roles(one, copy, other), load_rig())


def test_recordings_that_differ_in_anything_are_no_copies(recording):
    fewer = replace(recording, temperatures={name: s for name, s in recording.temperatures.items() if name != "tank_oil"})
    no_twice([recording, with_value(recording, 7.0), replace(recording, epoch_ns=recording.epoch_ns + DAY), fewer])
    no_twice([replace(recording, drive=None, hydraulic=None, temperatures={})] * 2)  # nothing of it could count at all
