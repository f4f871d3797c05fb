"""What a test is expected to tell, against what a diagnosis of its rehearsal then says."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.drive.design import by_effect, classes, design
from ddh_twin_py.gap.drive.direct_drive import DirectDrive
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.detection import DETECTED, SIZES, detections
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.rehearsal import rehearse
from support.simulated import DUTY

NAMES = ("pump_1.friction", "pump_2.friction", "drive.torque_estimate", "load.mass", "cylinder.cooling")
LENGTH = 60.0


@pytest.fixture(scope="module")
def rig():
    return load_rig()


def rehearsed(rig, of=None, sensors=("motor_housing",)):
    duty = load_duty(DUTY / "paper_cycle.yaml")
    return Experiment(rehearse(of or rig, duty, LENGTH, sensors), rig)


def taken(rig, field, commissioning=None, names=NAMES):
    model = DirectDrive([] if commissioning is None else [commissioning], [field], rig)
    with ThreadPoolExecutor(2) as pool:
        return linearise(Question(model, [EFFECTS[name] for name in names]), np.zeros(model.size), pool)


@pytest.fixture(scope="module")
def linearised(rig):
    return taken(rig, rehearsed(rig), rehearsed(rig))


def test_a_larger_effect_gains_more_and_the_smallest_is_just_detected(linearised):
    with ThreadPoolExecutor(2) as pool:
        (d,) = detections(linearised, [EFFECTS["load.mass"]], pool)
    assert d.gain["faint"] < d.gain["moderate"] < d.gain["clear"]
    assert 0.5 < d.rise < SIZES["clear"] and d.smallest != 0.0
    for size, rise in SIZES.items():
        assert (d.gain[size] >= DETECTED) == (rise >= d.rise), size


def test_what_is_found_only_beyond_what_machines_reach_is_told_so(linearised):
    mass = EFFECTS["load.mass"]
    narrow = [replace(c, effect=replace(mass, reached=(-1e-3, 1e-3))) if c.effect.id == mass.id else c for c in linearised.columns]
    with ThreadPoolExecutor(2) as pool:
        near, gain = detections(linearised, [mass, EFFECTS["drive.torque_estimate"]], pool)
        (far,) = detections(replace(linearised, columns=narrow), [mass], pool)
    record = linearised.model.record(linearised.model.altered.index(True), linearised.theta)
    assert (near.nominal, gain.nominal) == (record["load_payload_mass"][0], 1.0)
    assert not near.beyond and far.beyond and far.smallest is not None


def test_an_effect_that_is_known_for_growing_is_asked_for_as_it_grows(linearised):
    mass = EFFECTS["load.mass"]
    ways = [replace(c, rise=c.rise * (3.0 if c.x < 0.0 else 1.0)) if c.effect.id == mass.id else c for c in linearised.columns]
    with ThreadPoolExecutor(2) as pool:
        either, grown = detections(replace(linearised, columns=ways), [mass, replace(mass, grows=True)], pool)
    assert {c.x > 0.0 for c in ways if c.effect.id == mass.id} == {True, False}
    assert either.smallest < 0.0 < grown.smallest


def test_a_valve_is_found_only_where_it_opens(rig):
    setting = EFFECTS["relief_valve.setting"]
    linearised = taken(rig, rehearsed(rig), names=[setting.id])
    with ThreadPoolExecutor(2) as pool:
        (d,) = detections(linearised, [setting], pool)
    model = linearised.model
    without, acting = (model.run_one(0, linearised.theta, acts)["pressure_rod_side"] for acts in ((), [(setting, 0, d.smallest)]))
    assert np.sqrt(np.mean((acting - without) ** 2)) > 0.4 * d.rise * model.signals[0]["pressure_rod_side"].noise


def test_the_expected_gain_is_the_one_that_a_recording_gives(rig, linearised):
    index = next(i for i, c in enumerate(linearised.columns) if c.effect.id == "pump_1.friction")
    column = linearised.columns[index]
    torque = SIZES["clear"] / column.rise * column.x
    recorded = taken(rig, rehearsed(rig, rig.with_values({"pump_1.friction_added": torque})), rehearsed(rig))
    sums = linearised.basis.sums([rows[:, [index]] for rows in linearised.of_columns()], recorded.values())
    information = linearised.evidence.sums.information[index, index]
    estimate = sums.score[0] / information * column.x
    assert estimate == pytest.approx(torque, abs=5.0 * column.x / math.sqrt(information))
    gain = 0.5 * sums.score[0] ** 2 / information
    expected = 0.5 * information * (torque / column.x) ** 2
    assert expected > 5.0
    assert gain == pytest.approx(expected, abs=5.0 * math.sqrt(2.0 * expected))


def test_effects_are_told_apart_the_better_the_less_alike_they_are(linearised):
    names, apart = by_effect(linearised)
    at = {name: i for i, name in enumerate(names)}
    assert np.all(np.diagonal(apart) == 0.0) and np.all(apart >= 0.0)
    alike = apart[at["pump_1.friction"], at["pump_2.friction"]]
    unlike = apart[at["pump_1.friction"], at["load.mass"]]
    assert alike < unlike


def test_without_commissioning_less_is_detected(rig):
    effects = [EFFECTS[name] for name in NAMES]
    with ThreadPoolExecutor(2) as pool:
        without = design(rehearsed(rig), None, rig, effects, pool)
        beside = design(rehearsed(rig), rehearsed(rig), rig, effects, pool)
    for one, other in zip(without.detections, beside.detections, strict=True):
        if one.gain["clear"] is not None:
            assert one.gain["clear"] < other.gain["clear"], one.effect
    assert without.commissioning == 0.0 and beside.commissioning == pytest.approx(LENGTH, abs=0.5)
    assert beside.sensors == ("motor_housing",) and beside.pressures


def test_classes_are_those_of_which_no_pair_is_told_apart():
    apart = np.full((4, 4), 10.0)
    apart[0, 1] = 1.0  # one way is enough
    apart[1, 2] = 2.0  # but 0 and 2 are told apart
    names = ["a", "b", "c", "d"]
    assert classes(names, apart, set(names)) == [["a", "b"]]
    assert classes(names, apart, {"b", "c", "d"}) == [["b", "c"]]
    assert classes(names, np.full((4, 4), 10.0), set(names)) == []
