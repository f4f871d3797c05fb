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

TANK, AIR = SENSORS.index("tank_oil"), 300.0
CALL = 5  # intervals, 0.25 s


@pytest.fixture
def followed():
    again = AgreesAgain(load_rig(), 0.05)
    again.follow(OutOfPlace(("tank_oil",), "8 K off", off=8.0))
    return again


def fused():
    """What is fused in a call: everything at the air's temperature."""
    m = len(SENSORS)
    return FusionResult(np.full((CALL, N), AIR), np.full((CALL, N), 0.2), np.full(CALL, AIR), np.full((CALL, m), AIR),
                        np.full(m, 0.1), [], [])


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
