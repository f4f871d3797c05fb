"""Recordings that allow no diagnosis, and those that are taken for one another."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.binning import HOLDING
from ddh_twin_py.estimation.fitting.experiment import Experiment, ExperimentError
from ddh_twin_py.estimation.fitting.unpredictable import COMMANDS_LOST
from ddh_twin_py.gap.diagnose import Recordings, diagnose
from ddh_twin_py.gap.recordings.suitability import no_answer, no_twice, out_of_order, refuse_unfit, uncommanded, undriven
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


@pytest.mark.parametrize("role", ["field", "commissioning", "validation"])
@pytest.mark.parametrize(("ahead", "said"), [(25.0, "when it is taken 25.0 s later; their clocks differ, and a free run needs one clock"),
                                             (900.0, "when it is taken 900.0 s later; their clocks differ")])  # fmt: skip
def test_a_drive_by_another_clock_is_refused(role, ahead, said, recording):
    odd = replace(recording, drive=replace(recording.drive, time=recording.drive.time + ahead))
    given = {"field": [recording]} | {role: [odd] if role == "field" else odd}
    with pytest.raises(ExperimentError) as refused:
        diagnose(Recordings(**given), load_rig())
    assert said in str(refused.value) and str(refused.value).startswith(f"{odd.path}: {odd.namespace}/hydraulics/telemetry follows ")


def test_two_machines_on_the_same_topics_are_refused(recording):
    """A second rod, 7 s behind, between the messages of the first."""
    def beside(stream):
        time = np.concatenate([stream.time, stream.time + 7.0123])
        order = np.argsort(time, kind="stable")
        return replace(stream, time=time[order], values=np.concatenate([stream.values, stream.values])[order])

    both = recording.with_streams({topic: beside(stream) for topic, stream in recording.streams()})
    with pytest.raises(ExperimentError, match="two machines publish there") as refused:
        diagnose(Recordings([recording], commissioning=both), load_rig())
    assert "rod_position is" in str(refused.value) and recording.path in str(refused.value) and "\n" not in str(refused.value)


def test_drive_and_hydraulics_that_share_no_time_are_refused_whether_the_rod_moves_or_not(recording):
    still = replace(recording.hydraulic, time=recording.hydraulic.time - 900.0, values=np.zeros_like(recording.hydraulic.values))
    with pytest.raises(ExperimentError, match=r"they have no time in common; do their clocks differ\?$"):
        diagnose(Recordings([replace(recording, hydraulic=still)]), load_rig())


@pytest.mark.parametrize(("held", "told"), [(4.98, "4.9 s would count, 5 s are needed"), (5.0, ""), (2.0, "2.0 s would count, 5 s are")])
def test_a_held_out_part_that_is_too_short_is_told_as_less_than_what_is_needed(held, told, recording):
    experiment = Experiment(recording, load_rig())
    short = SimpleNamespace(recording=recording, signals=experiment.signals, duration=40.0, held_from=40.0 - held,
                            phase_of_intervals=experiment.phase_of_intervals, interval=experiment.interval, left_out={})
    said = no_answer([short], False)
    assert (told in said) if told else said == ""


def test_a_held_out_part_without_a_sample_sizes_nothing(recording):
    experiment = Experiment(recording, load_rig())
    early = {name: replace(s, time=s.time[s.time < 45.0], measured=s.measured[s.time < 45.0])
             for name, s in experiment.signals.items()}
    short = SimpleNamespace(recording=recording, signals=early, duration=60.0, held_from=45.0,
                            phase_of_intervals=experiment.phase_of_intervals, interval=experiment.interval, left_out={})
    assert f"hold no usable sample in the part that would be held out (of {recording.path} from 45 s on)" in no_answer([short], False)
    assert no_answer([short], True) == ""


@pytest.mark.parametrize(("moving", "told"), [(9.97, "turns for 9.9 s only; at least 10 s"), (0.04, "for 0.0 s only"), (10.0, "")])
def test_motion_that_is_too_short_is_told_as_less_than_what_is_needed(moving, told, recording):
    experiment = Experiment(recording, load_rig())
    phases = np.where(np.arange(6000) < round(moving / 0.01), HOLDING - 1, HOLDING)
    short = SimpleNamespace(recording=recording, signals=experiment.signals, duration=60.0, held_from=45.0,
                            phase_of_intervals=lambda: phases, interval=0.01, left_out={})
    said = no_answer([short], False)
    assert (told in said) if told else said == ""


def test_a_rig_as_built_that_is_younger_than_the_field_is_noted(recording):
    later = replace(recording, path="new", epoch_ns=recording.epoch_ns + 40 * DAY)
    assert out_of_order([recording], None) == out_of_order([later], recording) == out_of_order([recording], recording) == []
    (note,) = out_of_order([later, recording], later)
    assert note.startswith("commissioning and field may be interchanged: new, given as the rig as built, was recorded 40 days after ")
    assert recording.path in note


def with_value(recording, value):
    """The recording with another first value of the drive."""
    values = recording.drive.values.copy()
    values[0, 1] = value
    return replace(recording, drive=Stream(recording.drive.time, values, recording.drive.fields))


def moved(recording):
    """With the same stamps and other values."""
    drive, hydraulic = (replace(stream, values=stream.values + 1.0e-6) for stream in (recording.drive, recording.hydraulic))
    return replace(recording, drive=drive, hydraulic=hydraulic)


@pytest.mark.parametrize("roles", [
    lambda one, copy, other: Recordings([one, copy]),
    lambda one, copy, other: Recordings([copy], commissioning=one),
    lambda one, copy, other: Recordings([one], commissioning=other, validation=copy),
    lambda one, copy, other: Recordings([other], commissioning=one, validation=copy),
])
def test_a_copy_of_a_recording_is_refused_in_any_role(roles, recording):
    one = replace(with_value(recording, np.nan), path="one")  # what is not known is the same too
    copy, other = replace(with_value(recording, np.nan), path="one/one.mcap"), moved(recording)
    with pytest.raises(ExperimentError, match="^one and one/one.mcap are the same recording; its samples would count twice$"):
        diagnose(roles(one, copy, other), load_rig())


def test_a_part_of_a_recording_in_another_role_is_refused(recording):
    def cut(start, stop, path):
        return replace(recording, path=path, drive=recording.drive.between(start, stop), hydraulic=recording.hydraulic.between(start, stop))

    no_twice([cut(0.0, 40.0, "first"), cut(40.0, 60.0, "rest")])
    said = r"^first and late overlap: \d+ samples of .*/drive/telemetry, from 30.0 s to 50.0 s of the first, are in both; its samples"
    with pytest.raises(ExperimentError, match=said):
        no_twice([cut(0.0, 50.0, "first"), cut(30.0, 60.0, "late")])


def test_recordings_of_one_beginning_are_no_copies(recording):
    """Simulations begin at the same stamp, and at rest with the same values."""
    no_twice([recording, moved(recording), replace(recording, epoch_ns=recording.epoch_ns + DAY)])
    no_twice([replace(recording, drive=None, hydraulic=None, temperatures={})] * 2)  # nothing of it could count at all
    still = replace(recording, drive=replace(recording.drive, values=np.zeros_like(recording.drive.values)), hydraulic=None)
    no_twice([still, still])


def test_a_recording_that_does_not_know_where_the_rod_was_driven_is_refused(recording):
    experiment = Experiment(recording, load_rig())
    assert uncommanded(experiment) == ""
    experiment.left_out[COMMANDS_LOST] = 0.2 * experiment.duration
    said = uncommanded(experiment)
    assert "drive/telemetry: messages were lost while speed_command changed, and for 12 s of 60 s" in said
    assert no_answer([experiment], True) == said
    with pytest.raises(ExperimentError, match="for 12 s of 60 s .* leave this validation recording out"):
        refuse_unfit(experiment, "validation")
