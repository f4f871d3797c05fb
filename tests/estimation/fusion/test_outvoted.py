"""One sensor beside the oil that all others contradict is not believed; a winding, and what is read by few, may be as warm as it likes."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading
from ddh_twin_py.estimation.fusion.outvoted import outvoted
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.report.replay.agreement import compare
from ddh_twin_py.rig import load_rig


def read(**others):
    """K, newest of each sensor: 300 but for those that are named; None is not read."""
    return np.array([np.nan if others.get(s, 300.0) is None else others.get(s, 300.0) for s in SENSORS])


def names(reading):
    return {SENSORS[k] for k in np.flatnonzero(outvoted(reading, np.nan))}


@pytest.mark.parametrize(("readings", "out"), [
    (read(), set()),
    (read(tank_oil=363.0), {"tank_oil"}),
    (read(line_a=240.0), {"line_a"}),
    (read(tank_oil=329.0), set()),  # warm oil
    (read(motor_winding=390.0, motor_housing=350.0), set()),
    (read(tank_oil=340.0, tank_wall=335.0), set()),  # a tank that was heated
    (read(tank_oil=363.0, tank_wall=None, cylinder_barrel=None, line_a=None, line_b=None), set()),  # two others are no majority
    (read(tank_oil=363.0, tank_wall=280.0, line_a=320.0, line_b=290.0, cylinder_barrel=310.0), set()),  # nor are many that do not agree
    (np.full(len(SENSORS), np.nan), set()),
])  # fmt: skip
def test_who_is_outvoted(readings, out):
    assert names(readings) == out


@pytest.mark.parametrize("sensor", ["tank_oil", "pump_1_case"])
def test_a_sensor_wrong_from_the_start_moves_nothing_and_no_other_is_refused_for_it(sensor, paper_cycle_bag):
    sound = read_recording(paper_cycle_bag).between(0.0, 60.0)
    stream = sound.temperatures[sensor]
    values = stream.values.copy()
    values[:, 0] = 228.15 + 0.2 * np.random.default_rng(1).normal(size=len(values))  # K, what no other unit makes of what the others read
    wrong = replace(sound, temperatures={**sound.temperatures, sensor: replace(stream, values=values)})
    right, beside = replay(sound, load_rig()), replay(wrong, load_rig())
    node = NODE_INDEX[sensor]
    assert np.abs(beside.fused - right.fused).max() < 4.0 and abs(beside.fused[-1, node] - right.fused[-1, node]) < 1.0
    assert beside.fused_std[-1, node] > right.fused_std[-1, node]
    assert np.abs(beside.free_temperature - right.free_temperature).max() < 0.5
    assert {i.sensor for i in beside.innovations if not i.accepted} == {sensor}
    assert not any(i.accepted for i in beside.innovations if i.sensor == sensor)
    assert "from the sensor of which it believes no reading" in compare(beside).verdict


def test_sensors_that_have_stopped_outvote_none_that_goes_on():
    fusion, second = TemperatureFusion(load_rig(), 1.0), FusionInputs.unknown(1)
    for _ in range(10):
        fusion.advance(second, [Reading(0, sensor, 300.0) for sensor in ("tank_oil", "line_a", "line_b", "cylinder_barrel", "tank_wall")])
    for k in range(200):  # four cables are torn, the oil warms by 40 K
        fusion.advance(second, [Reading(0, "tank_oil", 300.0 + 0.2 * k)])
        assert not fusion.contradicted
