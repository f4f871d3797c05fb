"""The hydraulic model on telemetry: where a measured rod position is taken over and where an end stop knows better."""

import numpy as np
import pytest
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
