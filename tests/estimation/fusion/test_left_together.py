"""Where most sensors leave the filter's band in the same seconds the unit is not as warm as it was held to be, and they are believed."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.damage import without_samples
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.rig import load_rig

PAUSE, END = 20.0, 80.0  # s
READ = list(NODE_INDEX.values())


@pytest.fixture(scope="module")
def sound(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, END)


@pytest.fixture(scope="module")
def truth(sound):
    return replay(sound, load_rig())


def warmer(recording, by, begin, sensors=SENSORS):
    """The recording, in which some sensors read by so many K more from a time on."""
    read = recording.temperatures
    return replace(recording, temperatures={**read, **{name: replace(read[name], values=read[name].values + np.outer(
        by * (read[name].time >= begin), [1.0, 0.0])) for name in sensors}})


@pytest.mark.parametrize("by", [-14.0, 4.0])
@pytest.mark.parametrize("gap", [0.0, 9.0, 35.0])
def test_a_unit_in_another_state_is_believed_within_seconds_and_told_in_a_line(sound, truth, gap, by):
    other = warmer(sound, by, PAUSE + gap)
    for topic, _ in sound.streams():
        other = without_samples(other, topic, PAUSE, PAUSE + gap)
    result = replay(other, load_rig(), smooth=True)
    after = slice(*np.searchsorted(result.time, PAUSE + gap + np.array([3.0, 15.0])))  # later the air draws it elsewhere than the truth
    off = (result.fused - truth.fused - by)[after, READ]
    assert np.all(np.abs(off) < 3.0 * result.fused_std[after, READ])
    assert np.abs(off[:, SENSORS.index("tank_oil")]).max() < 0.7
    (said,) = (f for f in result.recording.findings if "tell together" in f.message)
    assert PAUSE + gap < said.first_time < PAUSE + gap + 2.5 and said.severity == "warning"
    assert "the estimate begins anew from what they read" in said.message and "expected were" in said.message
    assert result.zero_error is not None and abs(result.zero_error[1]) < 5.0 and not result.left_out
    smoothed, wide = result.smoothed - truth.fused[result.smoothed_row], result.smoothed_std[:, READ]
    at = result.time[result.smoothed_row]
    before, behind = at < PAUSE - 1.0, (at > PAUSE + gap + 3.0) & (at < PAUSE + gap + 15.0)
    assert np.all(np.abs(smoothed[before][:, READ]) < 4.0 * wide[before] + 0.3)
    assert np.all(np.abs(smoothed[behind][:, READ] - by) < 4.0 * wide[behind] + 0.3)


@pytest.mark.parametrize("sensors", [("tank_oil",), ("motor_winding", "motor_housing"), ("tank_oil", "tank_wall", "line_a", "line_b")])
def test_one_that_steps_or_a_few_are_refused(sound, sensors):
    result = replay(warmer(sound, 8.0, PAUSE, sensors), load_rig())
    left_out = {name for name, sensor in result.sensors.items() if not sensor.used}
    assert left_out | {i.sensor for i in result.innovations if not i.accepted} >= set(sensors)
    assert not any("tell together" in f.message for f in result.recording.findings)


def fed(steps, interval=1.0, calls=1):
    """A filter that was fed with readings, K by sensor, second by second, and where it began anew."""
    fusion, begun = TemperatureFusion(load_rig(), interval, ambient=295.0), []
    for start in range(0, len(steps), calls):
        some = steps[start : start + calls]
        result = fusion.advance(FusionInputs.unknown(len(some)), [Reading(i, s, t) for i, row in enumerate(some) for s, t in row.items()])
        begun += [(start + left.index, left.sensors) for left in result.begun_anew]
    return fusion, begun


def rest(of, seconds):
    return [dict(of)] * seconds


ALL = dict.fromkeys(SENSORS, 300.0)


def test_two_that_are_all_that_are_read_are_believed_together():
    two = {"tank_oil": 300.0, "motor_housing": 305.0}
    fusion, begun = fed(rest(two, 60) + rest({"tank_oil": 285.0, "motor_housing": 291.0}, 5))
    assert begun == [(61, ("motor_housing", "tank_oil"))]
    assert abs(fusion.state.dynamic[NODE_INDEX["tank_oil"]] - 285.0) < 0.5


def test_of_three_two_are_not_most():
    three = {"tank_oil": 300.0, "motor_housing": 305.0, "line_a": 300.0}
    assert fed(rest(three, 60) + rest({**three, "tank_oil": 285.0, "motor_housing": 290.0}, 5))[1] == []


@pytest.mark.parametrize("by", [-10.0, 6.0])
def test_one_that_would_be_believed_as_far_off_has_no_say(by):
    """After some seconds without readings a winding may be as far off by the heat of that time."""
    three = {"tank_oil": 300.0, "pump_1_case": 302.0, "motor_winding": 310.0}
    _, begun = fed(rest(three, 60) + [{}] * 14 + rest({name: kelvin + by for name, kelvin in three.items()}, 5))
    assert begun == [(75, ("pump_1_case", "tank_oil"))]


def test_what_no_unit_can_be_is_believed_of_nobody():
    """All of a logger in tenths of degC, 27 degC as 270."""
    fusion, begun = fed(rest(ALL, 60) + rest(dict.fromkeys(SENSORS, 543.0), 20) + rest(ALL, 5))
    assert begun == [] and abs(fusion.state.dynamic[NODE_INDEX["tank_oil"]] - 300.0) < 1.0


def test_two_that_are_exchanged_while_it_runs_are_not_believed():
    assert fed(rest({"tank_oil": 300.0, "motor_housing": 310.0}, 60) + rest({"tank_oil": 310.0, "motor_housing": 300.0}, 5))[1] == []


def test_one_disturbed_reading_of_all_is_refused():
    fusion, begun = fed(rest(ALL, 60) + [dict.fromkeys(SENSORS, 280.0)] + rest(ALL, 5))
    assert begun == [] and abs(fusion.state.dynamic[NODE_INDEX["tank_oil"]] - 300.0) < 0.2


def test_those_that_read_seldom_have_no_say_until_they_read():
    """Three of nine read each second, the others every half minute."""
    often = ("tank_oil", "tank_wall", "line_a")

    def read(kelvin, seconds):
        return [{s: kelvin for s in SENSORS if s in often or k % 30 == 0} for k in range(seconds)]

    fusion, begun = fed(read(300.0, 119) + read(285.0, 70)[5:])
    assert [sensors for _, sensors in begun] == [tuple(sorted(often, key=SENSORS.index))] and begun[0][0] <= 122
    assert np.all(np.abs(fusion.state.dynamic[READ] - 285.0) < 0.5)


def test_sensors_that_come_off_one_after_the_other_are_refused():
    steps = rest(ALL, 60)
    for k in range(3):
        now = {**ALL, **dict.fromkeys(SENSORS[: k + 1], 308.0)}
        steps += rest(now, 15)
    assert fed(steps)[1] == []


def test_how_intervals_are_dealt_out_to_calls_does_not_matter():
    steps = rest({**ALL, "ambient": 296.0}, 60) + rest({**dict.fromkeys(SENSORS, 285.0), "ambient": 284.0}, 40)
    one, begun = fed(steps)
    other, again = fed(steps, calls=25)
    assert begun == again and len(begun) == 1
    np.testing.assert_array_equal(one.state.dynamic, other.state.dynamic)
    np.testing.assert_array_equal(one.state.covariance, other.state.covariance)
