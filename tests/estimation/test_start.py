"""Where temperatures begin: what a minute of readings says beyond the first ones."""

import numpy as np
import pytest
from ddh_twin_py.estimation.start import EARLY, spread_start, start_error
from ddh_twin_py.physics.thermal_network import NODES

NOISE = 0.1


LAG = 6.0


def drawn(random, change, error=0.07, behind=-0.4, n=30):
    """Readings less those of a run whose node begins 0.07 K too low and whose sensor 0.33 K too high, and their times."""
    time = np.linspace(0.0, EARLY, n)
    slope, fading = 0.15 * change * random.standard_normal(), np.exp(-time / LAG)
    return time, error + behind * fading + slope * time / EARLY + NOISE * random.standard_normal(n)


@pytest.mark.parametrize("change", [0.0, 0.5, 10.0])
def test_it_is_as_sure_as_it_says(change):
    random = np.random.default_rng(3)
    errors, sensor, said = [], [], 0.0
    for _ in range(400):
        time, off = drawn(random, change)
        found, of_sensor, said = start_error(time, off, change, NOISE, LAG, 1.0)
        errors.append((found - 0.07) / said)
        sensor.append(of_sensor)
    assert 0.9 < np.std(errors) < 1.1 and abs(np.mean(errors)) < 0.2
    assert np.mean(sensor) == pytest.approx(0.07 - 0.4, abs=0.02)
    assert NOISE / np.sqrt(30) * 0.999 <= said < NOISE


def test_a_single_reading_tells_a_node_as_well_as_a_sensor_follows_it():
    rested = start_error(np.linspace(0.0, EARLY, 30), np.full(30, 0.5), 1.0, NOISE, LAG, 1e-3)
    assert rested[0] == pytest.approx(rested[1], abs=1e-3) and rested[2] < 0.4 * NOISE
    found, of_sensor, said = start_error(np.zeros(1), np.array([0.5]), 1.0, NOISE, LAG, 1.0)
    assert found == pytest.approx(0.5) and of_sensor == pytest.approx(0.5) and said > 0.9


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
