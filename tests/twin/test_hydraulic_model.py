"""The hydraulic model on telemetry: where a measured rod position is taken over and where an end stop knows better."""

import numpy as np
import pytest
from ddh_twin_py.physics.cylinder import holding_pressure
from ddh_twin_py.physics.free_run import COMMAND_PARTS
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.hydraulic_model import UNSEEN, HydraulicModel, off_the_stops
from ddh_twin_py.twin.intervals import INTERVAL, command_size

STANDING, MOVING = 100, 20  # intervals


def run(position):
    """Pressures (n, 2), bar, and rod positions (n,), m, of a free run that stands and then lifts."""
    rig, n = load_rig(), STANDING + MOVING
    measured = np.zeros(n, MEASURED_DTYPE)
    measured["rod_position"] = position
    measured["pressure_piston_side"] = 2.0e5
    measured["standstill"][:STANDING] = INTERVAL * np.arange(1, STANDING + 1)
    command = np.zeros(command_size(n))
    parts = (command_size(n) - 1) // n
    command[STANDING * parts :] = np.minimum(60.0, 6.0 * np.arange(command.size - STANDING * parts) / parts)
    model = HydraulicModel(rig, 300.0)
    free = model.advance(measured, command, np.full(n, 295.0)).free
    return np.column_stack([free["pressure_piston_side"], free["pressure_rod_side"]]) / 1e5, free["rod_position"]


@pytest.mark.parametrize("stop", ["retracted", "extended"])
def test_a_rod_at_an_end_stop_is_not_pressed_by_the_noise_of_its_position(stop):
    rig = load_rig()
    at = 0.0 if stop == "retracted" else rig["cylinder.stroke"]
    noise = np.random.default_rng(0).normal(0.0, rig.sensors["rod_position"].noise, STANDING + MOVING)
    still, noisy = run(at)[0][:STANDING], run(at + noise)[0][:STANDING]
    assert np.abs(noisy - still).max() < 1.0
    between = run(0.5 * rig["cylinder.stroke"] + noise)[0][:STANDING]
    assert np.abs(np.diff(between, axis=0))[10:].max() < 1.0


@pytest.mark.parametrize("beyond", [3.0e-4, 1.0e-3])
@pytest.mark.parametrize("stop", ["retracted", "extended"])
def test_a_run_whose_first_position_lies_beyond_a_stop_begins_at_the_stop(stop, beyond):
    at, way = (0.0, -1.0) if stop == "retracted" else (load_rig()["cylinder.stroke"], 1.0)
    there, off = (np.full(STANDING + MOVING, at) for _ in range(2))
    off[0] += way * beyond
    np.testing.assert_array_equal(run(off)[0], run(there)[0])


def test_elsewhere_a_standing_rod_is_where_it_was_measured():
    rig = load_rig()
    position = np.full(STANDING + MOVING, 0.5 * rig["cylinder.stroke"])
    position[STANDING // 2 :] += 0.01
    assert run(position)[1][STANDING - 1] == pytest.approx(position[STANDING - 1], abs=1e-4)


def test_how_near_a_stop_may_be():
    rig = load_rig()
    noise, stroke = rig.sensors["rod_position"].noise, rig["cylinder.stroke"]
    near, free = np.array([0.0, 2.9 * noise, stroke - 2.9 * noise]), np.array([3.1 * noise, stroke - 3.1 * noise])
    assert np.isnan(off_the_stops(near, rig)).all()
    assert off_the_stops(free, rig) == pytest.approx(free)
    assert off_the_stops(near[1:], rig, samples=4.0) == pytest.approx(near[1:]), "a mean of more is surer"


def test_the_free_run_is_settled_only_once_what_moved_before_no_longer_matters():
    model, n = HydraulicModel(load_rig(), 300.0), round(0.6 * UNSEEN / INTERVAL)
    measured = np.zeros(n, MEASURED_DTYPE)
    settled = [model.advance(measured, np.zeros(command_size(n)), np.full(n, 295.0)).settled for _ in range(3)]
    assert not settled[0].any() and settled[2].all()
    assert settled[1].tolist() == [INTERVAL * k >= UNSEEN for k in range(n, 2 * n)]


def pieces(model, measured, command, sizes):
    """The free run of a model that is given so many intervals at a time, in turn; and whether it was off."""
    free, off, k, turn = [], [], 0, 0
    while k < measured.size:
        stop = min(measured.size, k + sizes[turn % len(sizes)])
        edges = command[k * COMMAND_PARTS : stop * COMMAND_PARTS + 1]
        result = model.advance(measured[k:stop].copy(), edges, np.full(stop - k, 295.0))
        free.append(result.free)
        off.append(result.off)
        k, turn = stop, turn + 1
    return np.concatenate(free), np.concatenate(off)


def falling(position, pressure):
    """A rod that the run drives onto its lower stop while it stands at ``position``, m, under ``pressure``, Pa; and commands, rad/s."""
    n = 200
    measured = np.zeros(n, MEASURED_DTYPE)
    measured["rod_position"], measured["pressure_piston_side"] = position, pressure
    command = np.zeros(command_size(n))
    command[20 * COMMAND_PARTS : 90 * COMMAND_PARTS] = -150.0
    measured["standstill"][100:] = 0.3 + INTERVAL * np.arange(100)
    return measured, command


@pytest.mark.parametrize("share", [1.0, 0.0], ids=["pressures that hold it", "pressures that do not"])
def test_a_rod_that_falls_where_it_is_put_back_gives_no_power(share):
    rig, position = load_rig(), 0.1
    held = float(holding_pressure(position, 0.0, rig.parameters[0]))
    measured, command = falling(position, held)
    measured["pressure_piston_side"][100:] *= share
    free, _ = pieces(HydraulicModel(rig, 300.0), measured, command, [200])
    lifted = np.diff(free["rod_position"], prepend=free["rod_position"][0]) - INTERVAL * free["rod_velocity"]
    assert np.count_nonzero(lifted[101:] > 0.5 * position) <= 1, "it is put back at the first interval, and once more at most"
    heat = INTERVAL * free["heat"][110:].sum()
    assert heat < 2.0 * rig["load.payload_mass"] * 9.81 * position
    if share:
        assert free["rod_position"][-1] == pytest.approx(position, abs=2e-3)
    apart, _ = pieces(HydraulicModel(rig, 300.0), measured, command, [3, 1, 11])
    assert apart.tobytes() == free.tobytes()


def test_a_run_is_taken_up_alike_however_its_intervals_come():
    measured, command = falling(0.2, 30e5)
    measured["speed"], measured["rod_velocity"] = -80.0, -0.1
    command[30 * COMMAND_PARTS + 2 : 60 * COMMAND_PARTS + 3] = np.nan
    measured["rod_position"][30:61] = np.nan
    free, off = pieces(HydraulicModel(load_rig(), 300.0), measured, command, [200])
    assert np.flatnonzero(off).tolist() == list(range(30, 61))
    assert free["rod_position"][61] == pytest.approx(0.2 - 0.1 * 0.5 * INTERVAL, abs=3e-3) and abs(free["rod_velocity"][61] + 0.1) < 0.05
    apart, again = pieces(HydraulicModel(load_rig(), 300.0), measured, command, [2, 1, 7])
    assert apart.tobytes() == free.tobytes() and np.array_equal(off, again)


def test_a_run_whose_position_comes_back_later_waits_for_it():
    measured, command = falling(0.2, 30e5)
    command[30 * COMMAND_PARTS : 60 * COMMAND_PARTS] = np.nan
    measured["rod_position"][30:70] = np.nan
    assert np.flatnonzero(pieces(HydraulicModel(load_rig(), 300.0), measured, command, [200])[1]).tolist() == [*range(29, 70)]


def test_a_first_message_of_the_drive_that_comes_a_little_later_than_others_loses_no_course():
    measured, command = falling(0.2, 30e5)
    command[: 3 * COMMAND_PARTS] = np.nan
    assert not pieces(HydraulicModel(load_rig(), 300.0), measured, command, [200])[1].any()


def test_a_rig_of_which_no_position_is_read_follows_the_next_command():
    measured, command = falling(np.nan, 30e5)
    command[30 * COMMAND_PARTS : 60 * COMMAND_PARTS] = np.nan
    assert np.flatnonzero(pieces(HydraulicModel(load_rig(), 300.0), measured, command, [200])[1]).tolist() == [*range(29, 60)]
