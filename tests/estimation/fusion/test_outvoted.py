"""A sensor that all others contradict is not believed; a winding, and what is read by few, may be as warm as it likes, but no colder."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading
from ddh_twin_py.estimation.fusion.outvoted import outvoted
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.physics.thermal_network import N, NODES
from ddh_twin_py.report.replay.agreement import compare
from ddh_twin_py.rig import load_rig


def read(**others):
    """K, newest of each sensor: 300 but for those that are named; None is not read."""
    return np.array([np.nan if others.get(s, 300.0) is None else others.get(s, 300.0) for s in SENSORS])


def names(reading, air=np.nan):
    return {SENSORS[k] for k in np.flatnonzero(outvoted(reading, air))}


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


COLD = dict.fromkeys(SENSORS, 273.0)
OIL = dict.fromkeys([sensor for sensor in SENSORS if not sensor.startswith("motor_")], 318.0)


@pytest.mark.parametrize(("readings", "air", "out"), [
    (read(motor_winding=288.0), 300.0, {"motor_winding"}),
    (read(motor_housing=292.0), 300.0, {"motor_housing"}),
    (read(motor_winding=296.0), 300.0, set()),  # as a winding lags that warms
    (read(motor_winding=288.0), np.nan, set()),
    (read(motor_winding=288.0), 288.0, set()),  # the air is as cold
    (read(**{**COLD, "motor_winding": 270.0}), 296.0, set()),  # a cold unit in a warm hall
    (read(motor_winding=288.0, motor_housing=None), 300.0, {"motor_winding"}),  # all else has rested
    (read(**OIL, motor_winding=288.0, motor_housing=None), 300.0, set()),  # the oil is heated, and the hall warms
    (read(**{**dict.fromkeys(SENSORS), "line_a": 300.0, "motor_winding": 288.0}), 300.0, set()),  # one other is no majority
])  # fmt: skip
def test_a_motor_is_not_colder_than_all_that_is_around_it(readings, air, out):
    assert names(readings, air) == out


def sound(unit, seconds, every=20):
    """What sensors read of a unit that goes on without heat, with noise, by interval, K, (n,), of each second and sensor."""
    seen = unit.advance(FusionInputs.unknown(round(seconds / unit.interval))).reading
    noise = np.random.default_rng(0).normal(0.0, 0.1, seen.shape)
    return [Reading(row, sensor, float((seen + noise)[row, k])) for row in range(0, len(seen), every) for k, sensor in enumerate(SENSORS)]


def as_warm_as(temperature, air, **nodes):
    """A filter that holds a unit to be so warm, K, but for these nodes, in air of K."""
    unit, node = TemperatureFusion(load_rig(), ambient=air), np.full(N, temperature)
    for name, warm in nodes.items():
        node[NODES.index(name)] = warm
    unit.state.dynamic[:] = np.concatenate([node, node[list(NODE_INDEX.values())]])
    return unit


def follow(fusion, readings, seconds, without=()):
    """What is fused of these readings from now on."""
    kept = [reading for reading in readings if reading.sensor not in without]
    rests = FusionInputs.unknown(round(seconds / fusion.interval))
    return fusion.advance(replace(rests, motor_known=~rests.motor_known, hydraulics_known=~rests.hydraulics_known), kept)


def test_of_a_cold_unit_in_a_warm_hall_every_sensor_is_believed():
    unit, fusion = as_warm_as(268.0, 296.0), TemperatureFusion(load_rig(), ambient=296.0)
    for _ in range(6):
        result = follow(fusion, sound(unit, 600.0), 600.0)
        assert not fusion.contradicted and all(i.accepted for i in result.innovations)
    off = np.abs(result.temperature[-1] - unit.state.dynamic[:N])
    assert unit.state.dynamic[NODE_INDEX["motor_housing"]] > 275.0 and np.all(off < 3.0 * result.standard_deviation[-1])


def test_after_a_hot_restart_sensors_are_believed_that_speak_at_once_or_minutes_later():
    warm = {"slot_winding": 352.0, "end_winding": 352.0, "teeth": 345.0, "yoke": 340.0, "rotor": 340.0, "housing": 335.0}
    unit, fusion = as_warm_as(320.0, 296.0, **warm), TemperatureFusion(load_rig(), ambient=296.0)
    follow(fusion, sound(unit, 120.0), 120.0)
    unit.rest(600.0)
    again = TemperatureFusion(load_rig(), ambient=296.0)
    again.restore(fusion.state, 600.0)
    late = follow(again, sound(unit, 120.0), 120.0, without=("motor_winding", "tank_oil"))
    result = follow(again, sound(unit, 120.0), 120.0)
    assert not again.contradicted and all(i.accepted for i in (*late.innovations, *result.innovations))
    read = list(NODE_INDEX.values())
    off = np.abs(result.temperature[-1] - unit.state.dynamic[:N])[read]
    assert np.all(off < 3.0 * result.standard_deviation[-1, read]) and result.standard_deviation[-1, read].max() < 1.0


def test_where_most_sensors_speak_late_and_contradict_the_first_one_the_estimate_begins_anew_from_them():
    unit, fusion = as_warm_as(330.0, 296.0), TemperatureFusion(load_rig(), ambient=296.0)
    cold = [replace(r, temperature=300.0) if r.sensor == "line_a" else r for r in sound(unit, 120.0)]
    result = follow(fusion, [r for r in cold if r.sensor == "line_a" or r.index >= 2000], 120.0)
    assert len(result.begun_anew) == 1 and "tank_oil" in result.begun_anew[0].sensors
    off = np.abs(result.temperature[-1] - unit.state.dynamic[:N])
    assert off[[node for sensor, node in NODE_INDEX.items() if sensor != "line_a"]].max() < 1.0


def test_a_winding_that_reads_colder_than_a_rested_unit_is_told_and_moves_nothing():
    unit, fusion = as_warm_as(296.0, 296.0), TemperatureFusion(load_rig(), ambient=296.0)
    wrong = [replace(r, temperature=r.temperature - 12.0 * (r.sensor == "motor_winding")) for r in sound(unit, 300.0)]
    result, at = follow(fusion, wrong, 300.0), NODE_INDEX["motor_winding"]
    assert abs(result.temperature[-1, at] - 296.0) < 2.0 * result.standard_deviation[-1, at]
    (said,) = fusion.contradicted
    assert said.startswith("motor_winding: 1") and "K colder than the air and all other sensors" in said


def test_one_wrong_first_reading_of_a_cold_winding_costs_a_sound_sensor_nothing():
    unit, fusion = as_warm_as(296.0, 296.0), TemperatureFusion(load_rig(), ambient=296.0)
    readings = sound(unit, 60.0)
    first = next(k for k, r in enumerate(readings) if r.sensor == "motor_winding")
    readings[first] = replace(readings[first], temperature=270.0)
    result = follow(fusion, readings, 60.0)
    assert result.standard_deviation[-1, NODE_INDEX["motor_winding"]] < 0.5 and not fusion.contradicted


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
