"""The paper's equation 6: where the constant equivalent current holds, and where it does not."""

import math

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.physics.equivalent_current import compare, equivalent_current, mean_square, ripple
from ddh_twin_py.physics.motor_condensed import condense
from ddh_twin_py.physics.motor_geometry import motor_network, reference_load
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.machine import load_machine

RIG, MACHINE = load_rig(), load_machine()
AMPLITUDE = 7.16  # its equivalent is the rated current, 5.06 A


@pytest.fixture(scope="module")
def network():
    return motor_network(MACHINE, RIG, 3)


@pytest.fixture(scope="module")
def without_copper_s_rise():
    return motor_network(MACHINE, RIG.with_values({"motor.copper_temperature_coefficient": 0.0}), 3)


def run(network, period):
    return compare(network, AMPLITUDE, period, reference_load(MACHINE))


def rise(c):
    return c.steady - (273.15 + MACHINE["reference.ambient"])


def mean_square_of(time, current):
    """Mean of the squared current of any cycle, A^2, by the trapezoidal rule."""
    return float(np.trapezoid(np.square(current), time) / (time[-1] - time[0]))


def test_equation_6():
    time = np.linspace(0.0, 7.0, 4001)
    current = 9.3 * np.cos(2.0 * math.pi * time / 7.0 + 0.4)
    assert mean_square(9.3) == pytest.approx(mean_square_of(time, current), rel=1e-6)
    assert equivalent_current(9.3) ** 2 == pytest.approx(mean_square(9.3))


def test_a_current_that_is_no_cosine_around_zero_is_not_met():
    """A load that is held has a mean; the largest value then says little about the heat."""
    time = np.linspace(0.0, 7.0, 4001)
    held = 6.0 + 3.3 * np.cos(2.0 * math.pi * time / 7.0)
    assert mean_square_of(time, held) == pytest.approx(6.0**2 + 3.3**2 / 2.0, rel=1e-3)
    assert mean_square_of(time, held) > 0.95 * mean_square(9.3)
    switched = np.where(time < 3.5, 9.3, -9.3)
    assert mean_square_of(time, switched) == pytest.approx(2.0 * mean_square(9.3), rel=1e-3)


def test_on_the_paper_s_cycle_the_largest_current_overstates_the_heat(paper_cycle_bag):
    """A recording and no cosine: the mean of the square is measured, eq. 6 with the largest current is two thirds above."""
    drive = next(stream for topic, stream in read_recording(paper_cycle_bag, None).streams() if "drive" in topic)
    current = np.abs(drive.column("current"))
    measured, largest = mean_square_of(np.asarray(drive.time), current), float(np.percentile(current, 99.5))
    assert measured == pytest.approx(31.9, rel=0.01)
    assert mean_square(largest) == pytest.approx(54.0, rel=0.02)


def test_it_holds_for_a_cycle_that_is_short_against_the_winding(network):
    c = run(network, 2.0)
    assert abs(c.mean - c.steady) < 1e-4 * rise(c)
    assert 0.0 < c.largest - c.steady < 1e-3 * rise(c)
    assert c.mean_loss == pytest.approx(c.steady_loss, rel=1e-5)


def test_it_misses_the_largest_temperature_of_a_long_cycle(network):
    """An hour per cycle: more than 20 K missed, a fifth of the rise."""
    c = run(network, 3600.0)
    assert c.largest - c.steady > 20.0
    assert c.largest - c.steady > 0.2 * rise(c)


def test_the_excess_grows_with_the_period(network):
    excess = [c.largest - c.steady for c in (run(network, period) for period in (2.0, 60.0, 1200.0))]
    assert excess[0] < 0.05 * excess[1] and excess[1] < 0.15 * excess[2]


def test_resistance_that_follows_temperature_raises_the_mean_of_long_cycles(network, without_copper_s_rise):
    """Resistance is highest when the current is: the equivalent current then makes too little heat in the mean."""
    with_rise, without = run(network, 3600.0), run(without_copper_s_rise, 3600.0)
    assert with_rise.mean_loss / with_rise.steady_loss - 1.0 == pytest.approx(0.031, abs=0.006)
    assert with_rise.mean - with_rise.steady > 2.0
    assert without.mean_loss == pytest.approx(without.steady_loss, rel=1e-4)
    assert abs(without.mean - without.steady) < 0.5  # what is left is the surface's own bend


def test_the_first_order_formula_says_when(network):
    """Ripple of the winding above its iron, for short cycles, where the iron stands still."""
    values = condense(network).values
    capacity = values["motor.thermal.slot_winding_capacity"] + values["motor.thermal.end_winding_capacity"]
    tau = capacity / values["motor.thermal.slot_to_teeth"]
    assert 20.0 < tau < 100.0
    for period in (2.0, 20.0):
        c = run(network, period)
        over_iron = c.steady_loss / values["motor.thermal.slot_to_teeth"]
        assert c.largest - c.steady == pytest.approx(ripple(period, tau) * over_iron, rel=0.2), period
    assert ripple(1e-3, tau) < 1e-4 and ripple(1e6, tau) == pytest.approx(1.0, abs=1e-3)
