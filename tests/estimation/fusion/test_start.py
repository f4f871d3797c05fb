"""Where temperatures begin: what a minute of readings says beyond the first ones."""

import numpy as np
import pytest
from ddh_twin_py.estimation.fusion.inputs import Reading, Readings
from ddh_twin_py.estimation.fusion.start import (
    EARLY,
    UNDRIVEN,
    FirstReadings,
    spread_start,
    start_error,
    start_temperature,
)
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig

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
        found, of_sensor, said = start_error(time, off, change, NOISE, LAG, 1.0, np.zeros((time.size, 0)))
        errors.append((found - 0.07) / said)
        sensor.append(of_sensor)
    assert 0.9 < np.std(errors) < 1.1 and abs(np.mean(errors)) < 0.2
    assert np.mean(sensor) == pytest.approx(0.07 - 0.4, abs=0.02)
    assert NOISE / np.sqrt(30) * 0.999 <= said < NOISE


def test_a_single_reading_tells_a_node_as_well_as_a_sensor_follows_it():
    rested = start_error(np.linspace(0.0, EARLY, 30), np.full(30, 0.5), 1.0, NOISE, LAG, 1e-3, np.zeros((30, 0)))
    assert rested[0] == pytest.approx(rested[1], abs=1e-3) and rested[2] < 0.4 * NOISE
    found, of_sensor, said = start_error(np.zeros(1), np.array([0.5]), 1.0, NOISE, LAG, 1.0, np.zeros((1, 0)))
    assert found == pytest.approx(0.5) and of_sensor == pytest.approx(0.5) and said > 0.9


def test_what_no_sensor_reads_is_not_laid_to_the_start():
    """A line that is read begins as it is, and is warmed by oil that was warmer than a run had it."""
    random, time = np.random.default_rng(5), np.linspace(0.0, EARLY, 60)
    warmed = -np.expm1(-time / 30.0)
    errors, said = [], 0.0
    for _ in range(400):
        off = 0.3 + random.standard_normal() * warmed + NOISE * random.standard_normal(time.size)
        found, _, said = start_error(time, off, 0.0, NOISE, LAG, 0.0 + 1e-3, warmed[:, None])
        errors.append((found - 0.3) / said)
    assert 0.9 < np.std(errors) < 1.1 and abs(np.mean(errors)) < 0.2


def started(ambient=293.0, **read):
    return dict(zip(NODES, spread_start(read, ambient), strict=True))


def test_oil_that_is_not_read_is_as_warm_as_what_it_flows_through():
    assert started(pump_1_case=303.0)["tank_oil"] == 303.0
    assert started(pump_1_case=303.0, line_b_wall=297.0)["tank_oil"] == 303.0  # walls of lines cool soonest
    assert started(cylinder_barrel=301.0, pump_1_case=303.0)["chamber_a_oil"] == 301.0
    lines = started(pump_1_case=303.0, line_b_wall=297.0)
    assert lines["line_a_wall"] == lines["line_a_oil"] == 297.0  # one line is as warm as the other


def test_a_node_that_is_read_keeps_its_own():
    begun = started(tank_oil=305.0, cylinder_barrel=301.0, housing=310.0)
    assert begun["tank_oil"] == 305.0 and begun["cylinder_barrel"] == 301.0 and begun["slot_winding"] == 310.0


def test_where_nothing_is_read_all_begin_at_ambient():
    assert set(started().values()) == {293.0}


def readings(**at):
    """One reading of each sensor, K, in the interval given, `STEP` each."""
    return Readings.of([Reading(index, sensor, temperature) for sensor, (index, temperature) in at.items()])


STEP = 0.5
DRIVEN = np.ones(100, bool)


def test_a_start_is_told_by_the_readings_that_are_to_count():
    slow = readings(tank_oil=(0, 300.0), motor_housing=(16, 320.0))
    begun = start_temperature(slow, 293.0, STEP)
    assert begun[NODES.index("tank_oil")] == 300.0 and begun[NODES.index("housing")] == 293.0
    assert start_temperature(slow, 293.0, STEP, within=8.0)[NODES.index("housing")] == 320.0


def test_a_sensor_that_was_silent_moves_what_it_tells_of_and_one_that_spoke_moves_nothing():
    first = FirstReadings(load_rig(), STEP, readings(tank_oil=(0, 300.0)))
    (told,) = first.follow(DRIVEN, readings(tank_oil=(20, 301.0), motor_housing=(21, 320.0)))
    temperature = np.linspace(300.0, 310.0, len(NODES))
    before = temperature.copy()
    told.move(temperature)
    moved = dict(zip(NODES, temperature - before, strict=True))
    assert told.row == 21 and temperature[NODES.index("housing")] == pytest.approx(320.0)
    assert moved["rotor"] == pytest.approx(moved["housing"]) and moved["tank_oil"] == moved["cylinder_barrel"] == 0.0


def test_a_reading_that_comes_later_than_early_tells_no_start():
    first, late = FirstReadings(load_rig(), STEP, readings()), int(EARLY / STEP)
    assert not first.follow(np.ones(late, bool), readings())
    assert not first.follow(DRIVEN, readings(motor_housing=(0, 320.0)))


@pytest.mark.parametrize("cut", [1, 40, 77, 200])
def test_after_a_time_without_telemetry_each_sensor_tells_again_however_it_is_cut(cut):
    driven = np.ones(200, bool)
    driven[50:50 + round(UNDRIVEN / STEP)] = False
    read = [Reading(i, "tank_oil", 300.0 + i) for i in range(0, 200, 7)]
    first, told = FirstReadings(load_rig(), STEP, []), []
    first.follow(DRIVEN[:0], readings())
    for begin in range(0, 200, cut):
        part = [Reading(r.index - begin, r.sensor, r.temperature) for r in read if begin <= r.index < begin + cut]
        told += [begin + t.row for t in first.follow(driven[begin:begin + cut], Readings.of(part))]
    assert told == [0, 112]  # the first after the 110th interval, with which the telemetry is back


def test_a_short_time_without_telemetry_leaves_a_model_alone():
    driven = np.ones(200, bool)
    driven[50:50 + round(UNDRIVEN / STEP) - 1] = False
    first = FirstReadings(load_rig(), STEP, of_tank(300.0, 300.1))
    assert not first.follow(driven, Readings.of([Reading(i, "tank_oil", 310.0) for i in range(200)]))


def of_tank(*temperature):
    """Readings of the tank's oil, K, one an interval."""
    return Readings.of([Reading(i, "tank_oil", value) for i, value in enumerate(temperature)])


@pytest.mark.parametrize("cut", [1, 2, 5])
def test_a_first_reading_that_the_next_ones_deny_was_none_however_it_is_cut(cut):
    first, said = FirstReadings(load_rig(), STEP, readings()), [363.0, 300.0, 363.0, 301.0, 302.0, 310.0, 310.0]
    told = []
    first.follow(DRIVEN[:0], readings())
    for begin in range(0, len(said), cut):
        part = of_tank(*said[begin:begin + cut])
        told += [(begin + t.row, t.temperature) for t in first.follow(DRIVEN[:cut], part)]
    assert told == [(0, 363.0), (4, 302.0)]


@pytest.mark.parametrize(("start", "then"), [
    ((363.0,), [(1, 300.0)]), ((300.0,), []), ((363.0, 300.0), [(0, 300.0)]), ((300.0, 363.0, 300.0), [(0, 300.0)]),
])
def test_a_start_that_the_next_readings_deny_is_told_again(start, then):
    first = FirstReadings(load_rig(), STEP, of_tank(*start))
    assert not first.follow(DRIVEN[:len(start)], of_tank(*start)), "what told the start does not confirm itself"
    assert [(t.row, t.temperature) for t in first.follow(DRIVEN, of_tank(300.0, 300.0, 300.0))] == then


def test_a_reading_that_none_confirmed_in_time_moves_nothing_any_more():
    first, late = FirstReadings(load_rig(), STEP, of_tank(363.0)), round(2.0 * EARLY / STEP)
    assert not first.follow(np.ones(late, bool), of_tank(363.0))
    assert not first.follow(DRIVEN, of_tank(300.0, 300.0, 300.0))


def test_one_wrong_reading_of_many_does_not_warm_a_start():
    begun = start_temperature(of_tank(300.0, 363.0, 300.2), 293.0, STEP)
    assert begun[NODES.index("tank_oil")] == pytest.approx(300.1)


def test_a_start_is_the_mean_of_what_agrees():
    begun = start_temperature(of_tank(300.0, 300.1, 300.5, 300.4), 293.0, STEP)
    assert begun[NODES.index("tank_oil")] == pytest.approx(300.25)
    none = start_temperature(of_tank(280.0, 300.0), 293.0, STEP)
    assert none[NODES.index("tank_oil")] == pytest.approx(290.0), "two that contradict each other say no more than their middle"
