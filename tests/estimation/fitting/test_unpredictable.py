"""Sticking and slipping, sinking onto a stop, commands that were lost: what is left out, and what is not."""

import numpy as np
from ddh_twin_py.estimation.fitting.unpredictable import command_lost, sticks_and_slips, sunk_onto_a_stop

NOISE = 1.5e-3
RATE = 50.0


def lifting(swing, lag=0.1, seconds=10.0, speed=0.012):
    """A rod lifted at a steady command from 1 s on, whose velocity swings by a share of its mean at 3 Hz."""
    random = np.random.default_rng(5)
    time = np.arange(0.0, seconds, 1.0 / RATE)
    command = np.where(time >= 1.0, 10.0, 0.0)
    velocity = speed * np.where(time >= 1.0, 1.0 - np.exp(-(time - 1.0) / lag), 0.0) * (1.0 + swing * np.sin(2.0 * np.pi * 3.0 * time))
    return time, velocity + NOISE * random.standard_normal(time.size), command


def test_a_rod_that_sticks_and_slips_is_found_where_the_command_is_steady():
    time, velocity, command = lifting(1.0)
    found = sticks_and_slips(time, velocity, command, NOISE)
    assert not found[time < 1.2].any() and found[time > 1.22].all()


def test_a_rod_that_moves_steadily_is_not():
    for swing, lag, speed in ((0.0, 0.1, 0.012), (0.3, 0.1, 0.012), (0.0, 0.6, 0.1), (0.0, 0.1, 2e-3)):
        time, velocity, command = lifting(swing, lag, speed=speed)
        assert not sticks_and_slips(time, velocity, command, NOISE).any(), (swing, lag, speed)


def test_samples_that_are_not_known_are_no_slips():
    time, velocity, command = lifting(1.0)
    velocity[::7] = np.nan
    found = sticks_and_slips(time, velocity, command, NOISE)
    assert found.any() and not found[::7].any()
    assert not sticks_and_slips(time, np.full(time.size, np.nan), command, NOISE).any()
    assert sticks_and_slips(np.zeros(0), np.zeros(0), np.zeros(0), NOISE).size == 0


def resting(rate, begin=0.2, dwell=600):
    """A rod that rests from the 100th interval on, and is moved again after the dwell."""
    position = np.full(dwell + 200, begin)
    position[100:] = np.clip(begin + rate * np.arange(dwell + 100), 0.0, 0.4)
    standing = np.zeros(position.size, bool)
    standing[100 : 100 + dwell] = True
    return position, standing


def test_a_load_that_sinks_onto_the_stop_is_left_out_from_when_it_may_meet_it_until_it_is_moved():
    position, standing = resting(-5e-4)
    found = sunk_onto_a_stop(position, standing, 0.4)
    first = int(np.argmax(found))
    assert 0.02 < position[first] < 0.045 and found[first:700].all() and not found[700:].any()
    assert sunk_onto_a_stop(*resting(5e-4), 0.4)[650] and not sunk_onto_a_stop(*resting(5e-4), 0.4)[300]


def test_a_load_that_stops_short_of_it_and_one_that_rests_on_it_are_compared():
    assert not sunk_onto_a_stop(*resting(-3e-4), 0.4).any()
    assert not sunk_onto_a_stop(*resting(0.0, begin=0.0), 0.4).any()


def test_gaps_in_the_position_are_bridged():
    position, standing = resting(-5e-4)
    whole = sunk_onto_a_stop(position, standing, 0.4)
    position[300:320] = np.nan
    assert np.count_nonzero(sunk_onto_a_stop(position, standing, 0.4) != whole) < 3
    assert not sunk_onto_a_stop(np.full(50, np.nan), np.ones(50, bool), 0.4).any()


INTERVAL = 0.05


def lifted(lost):
    """A rod that is lifted from 5 to 9 s and from 15 s on, placed where it rests, and what of its command is known."""
    time = np.arange(0.0, 20.0, 0.02)
    command = np.where(((time >= 5.0) & (time < 9.0)) | (time >= 15.0), 50.0, 0.0)
    axis = np.arange(0.0, 20.0, INTERVAL)
    position = 0.1 + 0.05 * (np.clip(axis - 5.0, 0.0, 4.0) + np.clip(axis - 15.0, 0.0, 4.0))
    placed = np.where((axis < 5.0) | ((axis >= 9.3) & (axis < 15.0)), position, np.nan)
    kept = ~((time > lost[0]) & (time < lost[1]))
    return time[kept], command[kept], position, placed, INTERVAL


def test_a_command_that_changes_while_it_is_lost_is_unknown_until_the_rod_is_moved_on_from_its_place():
    found = command_lost(*lifted((4.5, 5.5)))
    at = INTERVAL * np.arange(found.size)
    assert found[(at > 4.5) & (at < 14.9)].all() and not found[(at < 4.4) | (at > 15.6)].any()
    whole = command_lost(*lifted((4.0, 11.0)))
    assert whole[(at > 4.0) & (at < 14.9)].all() and not whole[(at < 3.9) | (at > 15.6)].any()


def test_a_clock_set_ahead_leaves_the_rod_behind_until_it_is_moved_on_from_its_place():
    found = command_lost(*lifted((6.0, 8.0)), [7.0])
    at = INTERVAL * np.arange(found.size)
    assert found[(at > 6.0) & (at < 14.9)].all() and not found[(at < 5.9) | (at > 15.6)].any()
    assert not command_lost(*lifted((6.0, 8.0)), [5.5]).any()


def test_what_is_lost_while_the_command_stays_is_no_matter():
    for lost in ((6.0, 8.0), (1.0, 3.0), (12.0, 14.9), (4.95, 5.15), (0.0, 0.0)):
        assert not command_lost(*lifted(lost)).any(), lost
    assert not command_lost(np.zeros(0), np.zeros(0), np.zeros(5), np.full(5, np.nan), INTERVAL).any()
