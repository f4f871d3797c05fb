"""Input that is not as it should be: the replay says so, knows less, and never breaks."""

import numpy as np
import pytest
from ddh_twin_py.bags import damage
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.fusion.catch_up import FOLLOWS, MISSED
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.sensors import NODE_INDEX
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Stream

DRIVE, HYDRAULICS = "drive/telemetry", "hydraulics/telemetry"


@pytest.fixture(scope="module")
def rig():
    return load_rig()


@pytest.fixture(scope="module")
def sound(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 70.0)


@pytest.fixture(scope="module")
def healthy(sound, rig):
    return replay(sound, rig)


def in_bar(recording):
    for field in ("pressure_piston_side", "pressure_rod_side"):
        recording = damage.with_wrong_unit(recording, HYDRAULICS, field, 1e-5)
    return recording


def drive_nan(recording):
    for field in ("current", "speed"):
        recording = damage.with_value(recording, DRIVE, field, np.nan, 30.0)
    return recording


WINDING = "temperature/motor_winding"
# what happens, what the findings must name, the node that must be known less surely
DAMAGE = {
    "pressure in bar": (in_bar, "pressure", "pump_1_oil"),
    "speed NaN for a while": (lambda r: damage.with_value(r, DRIVE, "speed", np.nan, 20.0, 60.0), "speed", "rotor"),
    "all of the drive NaN": (drive_nan, "current", "end_winding"),
    "temperature NaN": (lambda r: damage.with_value(r, WINDING, "temperature", np.nan, 10.0), "motor_winding", "end_winding"),
    "pressure stuck": (
        lambda r: damage.with_stuck_sensor(r, HYDRAULICS, "pressure_rod_side", 20.0), "pressure_rod_side", "pump_2_oil"),
    "winding stuck": (lambda r: damage.with_stuck_sensor(r, WINDING, "temperature", 10.0), "motor_winding", "end_winding"),
    "drive stops and comes back": (lambda r: damage.without_samples(r, DRIVE, 20.0, 50.0), DRIVE, None),
    "drive stops for good": (lambda r: damage.without_samples(r, DRIVE, 30.0, 1e9), None, "slot_winding"),
    "no hydraulics": (lambda r: damage.without_stream(r, HYDRAULICS), None, "pump_1_oil"),
    "repeated stamps": (lambda r: damage.with_repeated_stamps(r, DRIVE), DRIVE, None),
    "late arrivals": (lambda r: damage.with_shuffled_arrival(r, HYDRAULICS, 0.4), HYDRAULICS, None),
    "clock jumps back": (lambda r: damage.with_clock_jump(r, 40.0, -30.0), "back", None),
    "clock jumps forward": (lambda r: damage.with_clock_jump(r, 40.0, 50.0), None, None),
    "clock jumps nine minutes forward": (lambda r: damage.with_clock_jump(r, 40.0, 540.0), None, None),
    "clock jumps a day forward": (lambda r: damage.with_clock_jump(r, 40.0, 86400.0), None, None),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_it_says_so_and_goes_on(name, sound, healthy, rig):
    change, said, node = DAMAGE[name]
    result = replay(change(sound), rig)
    for values in (result.fused, result.fused_std, result.free_temperature):
        assert np.all(np.isfinite(values))
    for values in (result.fused, result.free_temperature):
        assert np.all((values > 250.0) & (values < 400.0))
    if said is not None:
        assert any(said in str(finding) for finding in result.recording.warnings), [str(f) for f in result.recording.findings]
    if node is not None:
        at = NODES.index(node)
        # at its worst, once the wide prior of the start has gone
        n = min(len(result.time), len(healthy.time))
        assert np.max(result.fused_std[400:n, at] / healthy.fused_std[400:n, at]) > 1.05


def test_out_of_order_and_repeated_change_nothing(sound, healthy, rig):
    for change in (lambda r: damage.with_repeated_stamps(r, DRIVE), lambda r: damage.with_shuffled_arrival(r, HYDRAULICS, 0.4)):
        result = replay(change(sound), rig)
        np.testing.assert_array_equal(result.fused, healthy.fused)


def test_the_truth_stays_within_the_wider_interval(sound, healthy, rig):
    """With the drive's telemetry gone the winding may have done anything, and the estimate says so."""
    result = replay(damage.without_samples(sound, DRIVE, 20.0, 1e9), rig, without=("motor_winding", "motor_housing"))
    at = NODES.index("end_winding")
    last = min(len(result.time), len(healthy.time)) - 1
    assert abs(result.fused[last, at] - healthy.fused[last, at]) < 2.0 * result.fused_std[last, at]


def swapped(recording, one, other):
    """Two temperature sensors at each other's place."""
    streams = dict(recording.streams())
    a, b = streams[f"temperature/{one}"], streams[f"temperature/{other}"]
    streams[f"temperature/{one}"], streams[f"temperature/{other}"] = b, a
    return recording.with_streams(streams)


def drifting(recording, topic, kelvin_per_second):
    streams = dict(recording.streams())
    old = streams[topic]
    values = old.values.copy()
    values[:, 0] += kelvin_per_second * old.time
    return recording.with_streams(streams | {topic: Stream(old.time, values, old.fields)})


def jumped(recording, topic):
    """The sensor reads 20 K more from 60 s on."""
    streams = dict(recording.streams())
    old = streams[topic]
    values = old.values.copy()
    values[old.time > 60.0, 0] += 20.0
    return recording.with_streams(streams | {topic: Stream(old.time, values, old.fields)})


@pytest.fixture(scope="module")
def longer(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 240.0)


def test_a_sound_recording_leaves_nothing_in_doubt(longer, rig):
    assert not [str(finding) for finding in replay(longer, rig).recording.warnings]


@pytest.mark.parametrize("change, said", [
    (lambda r: swapped(r, "tank_oil", "motor_housing"), "standard deviations"),
    (lambda r: drifting(r, WINDING, 10.0 / 60.0), "standard deviations"),
])
def test_a_sensor_that_lies_leaves_the_rig_in_doubt(longer, rig, change, said):
    """The filter bends to it; what it had to bend is told, with the warning that its uncertainties do not hold."""
    result = replay(change(longer), rig)
    assert np.all(np.isfinite(result.fused)) and np.all(np.isfinite(result.fused_std))
    doubts = [str(finding) for finding in result.recording.warnings if "errors may exceed what is stated" in str(finding)]
    assert len(doubts) == 1 and said in doubts[0]


def test_ambient_and_winding_that_are_exchanged_are_not_used_and_named_and_the_estimate_bends_to_neither(longer, rig):
    result = replay(swapped(longer, "motor_winding", "ambient"), rig)
    told = [str(finding) for finding in result.recording.warnings]
    assert len(told) == 2 and all("their sensors are likely exchanged; not used" in text for text in told)
    truth, at = replay(longer, rig), NODE_INDEX["motor_winding"]
    assert abs(result.fused[-1, at] - truth.fused[-1, at]) < 2.0 * result.fused_std[-1, at]


def test_a_sensor_that_lies_alone_is_left_out_and_said_to_be(longer, rig):
    result = replay(jumped(longer, WINDING), rig)
    told = [str(finding) for finding in result.recording.warnings if "temperature/motor_winding is held to read +20" in str(finding)]
    assert len(told) == 1 and "it is not used" in told[0]
    assert not [finding for finding in result.recording.warnings if "errors may exceed what is stated" in str(finding)]


@pytest.fixture(scope="module", params=[(21.0, 31.0), (25.0, 36.5), (28.0, 28.9)], ids=lambda gap: f"{gap[0]:g} to {gap[1]:g} s")
def after_a_gap(request, sound, rig):
    """Where drive and hydraulics were silent, s, and the replay of that."""
    gapped = damage.without_samples(damage.without_samples(sound, DRIVE, *request.param), HYDRAULICS, *request.param)
    return request.param, replay(gapped, rig)


def test_a_run_that_lost_its_command_goes_on_from_what_is_measured(after_a_gap, healthy):
    (begin, end), result = after_a_gap
    n = min(len(result.time), len(healthy.time))
    later = (result.time[:n] > end + 1.0) & np.isfinite(result.measured["rod_position"][:n])
    apart = (result.free["rod_position"][:n] - healthy.free["rod_position"][:n])[later]
    assert np.abs(apart).max() < 2e-3
    pressure = (result.free["pressure_piston_side"][:n] - healthy.free["pressure_piston_side"][:n])[later]
    assert np.sqrt(np.mean(pressure**2)) < 2e5
    assert result.off.any() and result.settled[-1]
    assert not result.off[(result.time < begin) | (result.time > end + 0.2)].any()


def test_nothing_is_heated_by_a_rod_that_is_put_back(after_a_gap, healthy):
    """In the gap it stands and holds its load; since then it is heated as the run that knew every command, but while it follows what is
    fused, which it does as far as that is known."""
    (begin, end), result = after_a_gap
    n = min(len(result.time), len(healthy.time))
    later = result.time[:n] > end + 0.2
    hotter = (result.free_temperature[:n] - healthy.free_temperature[:n])[later]
    hotter -= np.maximum(hotter[0], 0.0)
    follows = (end - begin >= MISSED) & (result.time[:n][later] <= end + FOLLOWS + 0.5)
    assert hotter[~follows].max() < 0.3 and (hotter - result.fused_std[:n][later])[follows].max(initial=0.0) < 0.3


def test_the_first_finding_says_that_the_free_run_was_off(after_a_gap):
    (begin, end), result = after_a_gap
    first = result.recording.findings[0]
    assert first.severity == "warning" and first.topic.endswith(DRIVE) and first.value == pytest.approx(end - begin, abs=0.2)
    assert f"from {begin:.1f} to {end:.1f} s" in first.message and "free run was off" in first.message


def test_a_gap_in_which_the_rod_rests_is_no_loss(sound, rig):
    standing = replay(sound, rig)
    rest = standing.time[standing.measured["standstill"] > 1.0]
    begin = rest[0]
    end = min(begin + 1.5, standing.time[(standing.time > begin) & (standing.measured["standstill"] == 0.0)][0] - 0.1)
    assert end > begin + 0.6
    result = replay(damage.without_samples(sound, DRIVE, begin, end), rig)
    assert not result.off.any() and not any("free run was off" in str(f) for f in result.recording.findings)
    np.testing.assert_allclose(result.free["rod_position"], standing.free["rod_position"], atol=1e-3)
