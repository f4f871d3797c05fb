"""A drive's current ten times too large is told by the pressures, and neither heats the winding nor costs it its sensor."""

from dataclasses import fields, replace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.doubts.doubted_current import CurrentWatch
from ddh_twin_py.estimation.fusion.inputs import FusionInputs
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.sensors import NODE_INDEX
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.units.unit_scales import UnitScales
from ddh_twin_py.twin.intervals import INTERVAL

AT = NODE_INDEX["motor_winding"]


@pytest.fixture(scope="module")
def recording(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 120.0)


@pytest.fixture(scope="module")
def truth(recording):
    return replay(recording, load_rig())


def scaled(recording, times, until=np.inf):
    """All that the drive makes of its current is so many times as much up to s."""
    drive = recording.drive
    size = np.isin(drive.fields, ("current", "torque", "electrical_power"))
    return replace(recording, drive=replace(drive, values=drive.values * np.where(size & (drive.time[:, None] < until), times, 1.0)))


def told(result):
    return [f.message for f in result.recording.findings if "pressures and speed ask of the shaft" in f.message]


@pytest.mark.parametrize("times", [10.0, 0.1])
def test_a_current_that_is_off_by_a_decimal_place_is_told_and_the_winding_is_known(recording, truth, times):
    result = replay(scaled(recording, times), load_rig())
    (said,) = told(result)
    assert f"current is {'10' if times > 1.0 else '0.098'} times what pressures and speed ask of the shaft" in said
    assert result.left_out == () and all(sensor.used for sensor in result.sensors.values())
    off = np.abs(result.fused[:, AT] - truth.fused[:, AT])
    assert np.all(off[200:] < result.fused_std[200:, AT]) and off[-1] < 2.0
    assert all(i.accepted for i in result.innovations if i.sensor == "motor_winding")


def test_one_that_is_right_again_is_used_again(recording, truth):
    result = replay(scaled(recording, 10.0, until=50.0), load_rig())
    first, last = told(result)
    assert "current is what pressures and speed ask of the shaft again, and is used (now " in last
    assert result.fused_std[-1, AT] < 1.5 * truth.fused_std[-1, AT]
    assert np.abs(result.fused[-1, AT] - truth.fused[-1, AT]) < 2.0 * result.fused_std[-1, AT]


@pytest.mark.parametrize(("times", "since"), [(2.0, 0.0), (0.5, 0.0), (2.0, 50.0)])
@pytest.mark.parametrize("without", [(), ("motor_winding",)])
def test_one_that_is_off_by_less_is_told_and_what_it_heats_is_as_unsure(recording, truth, times, since, without):
    odd = scaled(scaled(recording, times), 1.0 / times, until=since)
    result = replay(odd, load_rig(), without=without)
    (said,) = told(result)
    assert f"current is on the whole {times:g} times what pressures and speed ask of the shaft, more than tolerances allow" in said
    assert result.left_out == ()
    settled = result.time > 90.0
    assert np.all(np.abs(result.fused - truth.fused)[settled] < 2.5 * result.fused_std[settled])


def test_of_one_that_is_right_again_what_it_heats_is_known_as_before(paper_cycle_bag):
    whole = read_recording(paper_cycle_bag)
    result, right = replay(scaled(whole, 2.0, until=100.0), load_rig(), smooth=True), replay(whole, load_rig(), smooth=True)
    assert [("on the whole what pressures and speed ask of the shaft again" in said) for said in told(result)] == [False, True]
    assert np.all(np.abs(result.fused - right.fused)[-1] < 2.0 * result.fused_std[-1])
    assert np.all(np.abs(result.smoothed - right.smoothed)[-50:] < 3.0 * result.smoothed_std[-50:])


def test_of_a_share_that_comes_and_goes_about_the_limit_one_word_is_said():
    watch, scales = CurrentWatch(load_rig(), INTERVAL), UnitScales.of(load_rig())
    found = [told for k in range(20) for told in watch.take(inputs(4.0 * (1.65 if k % 2 else 1.55), 200), asked(scales, 200))[1]]
    assert len(found) == 1 and found[0].unsure == pytest.approx(1.0 - 1.65**-2)


def test_of_a_sound_drive_nothing_is_told(truth):
    assert told(truth) == []


def inputs(current, n=40):
    return replace(FusionInputs.unknown(n), mean_square_current=np.full(n, current**2), hydraulics_known=np.ones(n, bool),
                   motor_known=np.ones(n, bool))


def asked(scales, n=40, load=1.0, current=4.0):
    """Of a shaft that turns, with pressures that carry so many times the load."""
    shown = {"speed": 100.0, "current": current, "pressure_piston_side": load * scales.load / scales.piston_area, "pressure_rod_side": 0.0}
    return {name: np.full(n, value) for name, value in shown.items()}


def told_nothing(watch, given, shown):
    used, found = watch.take(given, shown)
    return used is given and found == []


def test_pressures_that_do_not_carry_the_load_tell_nothing_of_the_current():
    watch, scales, given = CurrentWatch(load_rig(), INTERVAL), UnitScales.of(load_rig()), inputs(4.0)
    assert told_nothing(watch, given, asked(scales, load=0.1, current=0.4 * 4.0)) and watch.doubted == ""
    assert told_nothing(watch, given, asked(scales, load=10.0, current=40.0)) and watch.doubted == ""


def test_one_that_is_a_few_times_as_much_is_a_machine_that_runs_hard():
    watch, given = CurrentWatch(load_rig(), INTERVAL), inputs(9.5)
    assert told_nothing(watch, given, asked(UnitScales.of(load_rig())))


def test_one_that_is_twice_as_much_for_long_is_held_to_be_so_until_it_agrees():
    watch, scales = CurrentWatch(load_rig(), INTERVAL), UnitScales.of(load_rig())
    shown, n = asked(scales, 400), 400
    (found,) = watch.take(inputs(8.0, n), shown)[1]
    assert watch.unlike == found.why and "2 times" in watch.unlike and not watch.doubted
    (found,) = watch.take(inputs(4.0, n), shown)[1]
    assert found.again and watch.unlike == ""
    watch.take(inputs(8.0, n), shown)
    watch.begin_anew()
    assert watch.unlike == ""


@pytest.mark.parametrize("call", [1, 40, 200])
def test_single_odd_intervals_do_not_hide_what_the_current_is_on_the_whole_in_whichever_calls(call):
    watch, scales, given = CurrentWatch(load_rig(), INTERVAL), UnitScales.of(load_rig()), inputs(8.0, 400)
    given.mean_square_current[75::150] = 0.25
    rows = [slice(start, start + call) for start in range(0, 400, call)]
    parts = (FusionInputs(*(getattr(given, entry.name)[part] for entry in fields(FusionInputs))) for part in rows)
    found = [part.start + told.index for part, one in zip(rows, parts, strict=True) for told in watch.take(one, asked(scales, call))[1]]
    assert found == [pytest.approx(200, abs=max(call, 3))]


def test_the_motor_is_not_known_while_its_current_is_what_the_shaft_needs():
    watch, scales = CurrentWatch(load_rig(), INTERVAL), UnitScales.of(load_rig())
    used, (found,) = watch.take(inputs(40.0), asked(scales))
    assert found.index == 9 and "10 times" in found.why
    assert not used.motor_known[9:].any() and used.motor_known[:9].all() and np.all(used.mean_square_current[9:] == 16.0)
    silent = {name: np.full(40, np.nan) for name in asked(scales)}
    assert np.all(watch.take(inputs(4.0), silent)[0].mean_square_current == 0.0) and watch.doubted
    watch.take(inputs(4.0), asked(scales))
    assert watch.doubted  # it must agree for some seconds
    used, (found,) = watch.take(inputs(4.0, 100), asked(scales, 100))
    assert found.again and found.index == 59 and used.motor_known[59:].all() and watch.doubted == ""
    watch.take(inputs(40.0), asked(scales))
    watch.begin_anew()
    assert watch.doubted == ""


def without_hydraulics(current, n=40):
    return replace(inputs(current, n), hydraulics_known=np.zeros(n, bool))


def test_no_drive_gives_more_than_its_limit_whatever_the_pressures_do_not_tell():
    watch, silent = CurrentWatch(load_rig(), INTERVAL), {name: np.full(2000, np.nan) for name in asked(UnitScales.of(load_rig()))}
    limit = load_rig()["motor.current_limit"]
    short = {name: values[:40] for name, values in silent.items()}
    assert told_nothing(watch, without_hydraulics(1.4 * limit), short)
    used, (found,) = watch.take(without_hydraulics(4.0 * limit), short)
    assert f"94 A, more than the drive's limit of {limit:g} A allows" in found.why
    assert not used.motor_known[9:].any() and np.all(used.mean_square_current[9:] == 0.0)
    used, found = watch.take(without_hydraulics(0.5, 2000), silent)
    assert found == [] and watch.doubted, "at rest no current tells anything"
    used, (found,) = watch.take(without_hydraulics(5.0, 2000), silent)
    assert found.again and "within the drive's limit of 23.5 A for 60 s" in found.why and 1190 < found.index < 1210


def test_a_current_that_stays_wrong_does_not_agree_where_pressures_tell_nothing():
    watch, scales = CurrentWatch(load_rig(), INTERVAL), UnitScales.of(load_rig())
    assert watch.take(inputs(0.4), asked(scales))[1]
    for load in (0.1, 4.0):
        assert watch.take(inputs(0.4, 400), asked(scales, 400, load=load))[1] == [] and watch.doubted


def test_a_shaft_that_creeps_needs_no_more_than_pressures_ask():
    watch, scales = CurrentWatch(load_rig(), INTERVAL), UnitScales.of(load_rig())
    creeping = {**asked(scales), "speed": np.full(40, 6.0)}
    assert told_nothing(watch, inputs(0.4), creeping), "friction may hold it"
    assert watch.take(inputs(20.0), creeping)[1]


def test_each_turn_of_one_call_is_told():
    watch, scales = CurrentWatch(load_rig(), INTERVAL), UnitScales.of(load_rig())
    square = np.concatenate([np.full(40, 20.0), np.full(200, 4.0), np.full(40, 20.0)]) ** 2
    found = watch.take(replace(inputs(4.0, 280), mean_square_current=square), asked(scales, 280))[1]
    assert [told.again for told in found] == [False, True, False]


def test_a_current_of_nothing_has_no_decimal_place_to_lose():
    watch, scales = CurrentWatch(load_rig(), INTERVAL), UnitScales.of(load_rig())
    (found,) = watch.take(inputs(0.0), asked(scales))[1]
    assert "current is 0 where the shaft needs 4 A" in found.why
