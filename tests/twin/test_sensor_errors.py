"""Sensors whose errors the rig file knows: what is compared with the model is what it would be without them."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC
from ddh_twin_py.twin.sensor_errors import delay_ns, take_off_delay
from support.erring import ERRORS, erring


@pytest.fixture(scope="module")
def plain(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 30.0)


def test_known_errors_change_nothing_that_is_compared(plain):
    rig = load_rig()
    base, known = replay(plain, rig), replay(erring(plain), rig.with_values(ERRORS))
    unknown = replay(erring(plain), rig)
    assert base.time.size == known.time.size
    for name in ("current", "current_square", "torque", "electrical_power", "rod_position", "rod_velocity", "pressure_piston_side"):
        a, b = base.measured[name], known.measured[name]
        size = np.nanmax(np.abs(a))
        assert np.nanmax(np.abs(b - a)) < 1e-9 * size, name
        if name != "pressure_piston_side":
            assert np.nanmax(np.abs(unknown.measured[name][: a.size] - a)) > 0.1 * size, name
    assert np.abs(known.fused - base.fused).max() < 1e-6
    np.testing.assert_allclose(known.soft["torque"], base.soft["torque"], atol=1e-9)


def test_the_skew_is_of_the_hydraulic_stream_alone(plain):
    rig = load_rig().with_values({"measurement.time_skew": 0.02})
    assert (delay_ns(rig, DRIVE_TOPIC), delay_ns(rig, HYDRAULIC_TOPIC)) == (0, 20_000_000)
    shifted = take_off_delay(plain, rig)
    np.testing.assert_allclose(shifted.hydraulic.time, plain.hydraulic.time - 0.02, atol=1e-12)
    assert shifted.drive is plain.drive and take_off_delay(plain, load_rig()) is plain
    alone = replace(plain, hydraulic=None)
    assert take_off_delay(alone, rig) is alone
