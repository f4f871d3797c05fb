"""Every fault of the plant moves a signal, and a fault of size 0 moves nothing."""

import numpy as np
import pytest
import yaml
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.plant.condition import NEUTRAL, sound
from ddh_twin_py.plant.listed_faults import LISTED
from ddh_twin_py.plant.machine import nominal
from ddh_twin_py.plant.sensors import ideal
from ddh_twin_py.plant.unlisted_faults import UNLISTED
from ddh_twin_py.rig import load_rig
from support.plants import course, exercise, quiet

FAULTS = {**LISTED, **UNLISTED}
DURATION = 200.0
LOWERED = {"relief_valve.setting"}  # what lies above the working pressure is not seen when it rises


@pytest.mark.parametrize("name", LISTED)
def test_the_diagnosis_looks_as_far_as_the_plant_may_go(name):
    effect, fault = EFFECTS[name], LISTED[name]
    sign = -1.0 if name == "motor.demagnetisation" else 1.0
    lowest, highest = sorted((sign * fault.lowest, sign * fault.highest))
    assert effect.lowest <= lowest and highest <= effect.highest


@pytest.fixture(scope="module")
def sheet():
    return load_rig()


@pytest.fixture(scope="module")
def bare(sheet):
    """Readings of the sound rig and the commands that it got: warm, and fast enough to reach the relief valve."""
    what = exercise(DURATION, 240.0, 900.0)
    what.start[:-1] += 10.0  # all but the frame
    done = course(nominal(sheet), what)
    return what, done, _read(sheet, what, done)


def _read(sheet, what, done):
    return ideal(done, quiet(sheet), what.ambient, np.arange(10.0, DURATION - 5.0, 5.0))


def _rise(bare, other, skew=0.0):
    what, done, readings = bare
    noise = {kind: spec.noise for kind, spec in load_rig().sensors.items()}
    worst = 0.0
    for name, values in readings.items():
        if name in ("speed_command", "torque"):
            continue
        kind = "pressure" if name.startswith("pressure") else name.split("/")[0]
        theirs = other[name]
        if skew and name.startswith(("pressure", "rod_")):
            theirs = np.interp(done.hydraulic_time, done.hydraulic_time + skew, theirs)
        worst = max(worst, float(np.sqrt(np.mean((theirs - values) ** 2))) / noise[kind])
    return worst


def test_catalogue_is_whole(shared_dir):
    listed = yaml.safe_load((shared_dir / "effects.yaml").read_text())
    assert set(LISTED) == set(listed["effects"])
    for name, row in listed["effects"].items():
        assert (LISTED[name].parameter, LISTED[name].unit) == (row["parameter"], row["unit"])
    components = set(listed["components"])
    assert {fault.component for fault in FAULTS.values()} <= components


def test_unlisted_are_not_in_the_catalogue():
    assert len(UNLISTED) >= 12
    assert not set(UNLISTED) & set(LISTED)
    assert all(not fault.listed for fault in UNLISTED.values())


@pytest.mark.parametrize("name", sorted(FAULTS))
def test_a_fault_of_no_size_changes_nothing(sheet, name):
    params, condition = sheet.parameters, sound()
    FAULTS[name].apply(params, condition, 0.0)
    assert np.allclose(params.view(np.float64), sheet.parameters.view(np.float64), rtol=1e-12)
    for field, value in NEUTRAL.items():
        if field == "payload":
            assert condition[field][0] == sheet["load.payload_mass"] if name == "load.mass" else condition[field][0] == 0.0
        elif field == "surface_lag" and name == "sensor.temperature_lag":
            assert condition[field][0] == sheet["sensors.temperature.time_constant"]
        else:
            assert condition[field][0] == value


@pytest.mark.parametrize("name", sorted(FAULTS))
def test_a_fault_is_seen_and_a_larger_one_better(sheet, bare, name):
    fault = FAULTS[name]
    what, done, _ = bare
    sign = -1.0 if name in LOWERED else 1.0
    rises = []
    for share in (0.25, 1.0):
        size = share * sign * min(fault.limit(sign), 12.0 * fault.step)
        other = course(nominal(sheet), what, [(fault, size)], done)
        moving = np.isfinite(other.drive).all() and np.isfinite(other.hydraulic).all()
        assert moving
        rises.append(_rise(bare, _read(sheet, what, other), float(other.condition["skew"][0])))
    assert rises[1] > rises[0] > 0.0
    assert rises[1] > 2.0
