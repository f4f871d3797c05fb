"""A sensor that was left out is used again once it agreed for a while, and silence is no agreement."""

import numpy as np
import pytest
from ddh_twin_py.estimation.doubts.agrees_again import AGREES, AgreesAgain
from ddh_twin_py.estimation.doubts.out_of_place import OutOfPlace
from ddh_twin_py.estimation.fusion.inputs import Readings
from ddh_twin_py.estimation.fusion.result import FusionResult
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.sensor_errors import temperature_zero_errors

TANK, WINDING, AIR = SENSORS.index("tank_oil"), SENSORS.index("motor_winding"), 300.0
CALL = 5  # intervals, 0.25 s
INTERVAL = 0.05


@pytest.fixture
def followed():
    again = AgreesAgain(load_rig(), 0.05)
    again.follow(OutOfPlace(("tank_oil",), "8 K off", off=8.0))
    return again


def fused(call=CALL, winding=AIR):
    """What is fused in a call of so many intervals: everything at the air's temperature, but for the winding."""
    reading = np.full((call, len(SENSORS)), AIR)
    reading[:, WINDING] = winding
    return FusionResult(np.full((call, N), AIR), np.full((call, N), 0.2), np.full(call, AIR), reading, np.full(len(SENSORS), 0.1), [], [])


def used_after(again, reads, seconds):
    """s after which the sensor is used again, that tells where it is read at a second, None where it is not."""
    zero = temperature_zero_errors(load_rig())[0][TANK]
    for call in range(4 * seconds):
        there = call % 4 == 0 and reads(call // 4)
        read = Readings(np.zeros(int(there), np.int64), np.full(int(there), TANK), np.full(int(there), AIR + zero + 0.01 * (call % 3)))
        if again.take(read, np.full(CALL, np.nan), fused()):
            return call / 4
    return None


def test_one_that_is_read_and_agrees_is_used_again_after_a_while(followed):
    assert used_after(followed, lambda second: True, 300) == pytest.approx(AGREES, abs=3.0)


def test_silence_is_no_agreement(followed):
    since = 125
    assert used_after(followed, lambda second: second >= since, 400) == pytest.approx(since + AGREES, abs=3.0)


def test_of_a_sensor_that_died_nothing_piles_up(followed):
    assert used_after(followed, lambda second: second < 30, 600) is None
    (agreement,) = followed._followed.values()
    assert agreement.seconds == 0.0 and not agreement._off


def pair_used_after(call, offset, seconds, tank_until=np.inf, winding=330.0):
    """s after which winding and tank are used again, told to be exchanged and read each second, so many intervals apart, in such calls."""
    again, zero = AgreesAgain(load_rig(), INTERVAL), temperature_zero_errors(load_rig())[0]
    again.follow(OutOfPlace(("motor_winding", "tank_oil"), "exchanged"))
    for start in range(0, seconds * 20, call):
        at = np.arange(start, start + call)
        read = [(i, k) for i in at.tolist() for k, shift in ((WINDING, 0), (TANK, offset))
                if i % 20 == shift and (k == WINDING or i * INTERVAL < tank_until)]
        index, sensor = (np.array([one[k] for one in read], np.int64) for k in (0, 1))
        readings = Readings(index - start, sensor, np.where(sensor == WINDING, winding, AIR) + zero[sensor])
        if again.take(readings, np.full(call, np.nan), fused(call, winding)):
            return start * INTERVAL
    return None


@pytest.mark.parametrize("offset", [0, 6])
@pytest.mark.parametrize("call", [1, 5, 20, 40])
def test_two_that_were_put_right_are_used_again_in_whichever_calls_they_are_read(call, offset):
    assert pair_used_after(call, offset, 200) == pytest.approx(AGREES, abs=3.0)


@pytest.mark.parametrize("call", [1, 5, 40])
def test_two_of_which_one_died_or_whose_places_are_alike_are_not(call):
    assert pair_used_after(call, 6, 300, tank_until=30.0) is None
    assert pair_used_after(call, 6, 200, winding=AIR + 0.1) is None
