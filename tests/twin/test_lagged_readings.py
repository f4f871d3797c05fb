"""Sensors that lag behind temperatures that come piece by piece."""

import numpy as np
import pytest
from ddh_twin_py.twin.lagged_readings import LaggedReadings, lagged

LAG, INTERVAL = np.array([2.0, 10.0]), 0.05


def warming(n=400):
    return 300.0 + np.outer(np.arange(n) * INTERVAL, [0.1, 0.02]) + np.where(np.arange(n)[:, None] >= 250, [3.0, 0.0], 0.0)


@pytest.mark.parametrize("cuts", [[100], [1, 2, 250], [250, 251, 399]])
def test_pieces_are_read_as_the_whole_is_jumps_between_them_too(cuts):
    whole, sensors = warming(), LaggedReadings(LAG)
    seen = np.vstack([sensors.follow(piece, INTERVAL) for piece in np.split(whole, cuts)])
    np.testing.assert_allclose(seen, lagged(whole, whole[0], INTERVAL, LAG), atol=1e-9)


def test_at_a_begin_sensors_read_what_they_are_at():
    sensors = LaggedReadings(LAG)
    behind = sensors.follow(warming(200), INTERVAL)[-1]
    sensors.begin_anew()
    again = sensors.follow(warming(201)[-1:], INTERVAL)
    assert np.all(behind < warming(200)[-1] - 0.05) and np.allclose(again, warming(201)[-1:])
