"""Where temperatures begin: what a minute of readings says beyond the first ones."""

import numpy as np
import pytest
from ddh_twin_py.estimation.start import EARLY, spread_start, start_error
from ddh_twin_py.physics.thermal_network import NODES

NOISE = 0.1


def drawn(random, change, error=0.07, n=30):
    time = np.linspace(0.0, EARLY, n)
    slope = 0.15 * change * random.standard_normal()
    return time, error + slope * time / EARLY + NOISE * random.standard_normal(n)


@pytest.mark.parametrize("change", [0.0, 0.5, 10.0])
def test_it_is_as_sure_as_it_says(change):
    random = np.random.default_rng(3)
    errors, said = [], 0.0
    for _ in range(400):
        time, off = drawn(random, change)
        found, said = start_error(time, off, change, NOISE)
        errors.append((found - 0.07) / said)
    assert 0.9 < np.std(errors) < 1.1 and abs(np.mean(errors)) < 0.15
    assert NOISE / np.sqrt(30) * 0.999 <= said < 0.4 * NOISE


def started(ambient=293.0, **read):
    return dict(zip(NODES, spread_start(read, ambient), strict=True))


def test_oil_that_is_not_read_is_as_warm_as_what_it_flows_through():
    assert started(pump_1_case=303.0)["tank_oil"] == 303.0
    assert started(pump_1_case=303.0, line_b_wall=297.0)["tank_oil"] == 303.0  # walls of lines cool soonest
    assert started(cylinder_barrel=301.0, pump_1_case=303.0)["chamber_a_oil"] == 301.0


def test_a_node_that_is_read_keeps_its_own():
    begun = started(tank_oil=305.0, cylinder_barrel=301.0, housing=310.0)
    assert begun["tank_oil"] == 305.0 and begun["cylinder_barrel"] == 301.0 and begun["slot_winding"] == 310.0


def test_where_nothing_is_read_all_begin_at_ambient():
    assert set(started().values()) == {293.0}
