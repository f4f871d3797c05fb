"""The plant by itself: energy is kept, oil is the sheet's, it shares nothing with the twin but the sheet."""

import ast
from pathlib import Path

import ddh_twin_py.plant
import numpy as np
import pytest
from ddh_twin_py.plant import heat
from ddh_twin_py.plant.machine import build, nominal
from ddh_twin_py.plant.oil import softness, viscosity, vogel, walther
from ddh_twin_py.plant.run import FAST
from ddh_twin_py.plant.sensors import SENSORS, measure
from ddh_twin_py.rig import load_rig
from support.plants import course, exercise, quiet


@pytest.fixture(scope="module")
def sheet():
    return load_rig()


def test_plant_imports_the_rig_and_nothing_else_of_the_project():
    folder = Path(ddh_twin_py.plant.__file__).parent
    imported = set()
    for file in folder.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0, file
                imported.add(node.module)
            elif isinstance(node, ast.Import):
                imported |= {alias.name for alias in node.names}
    own = {name.split(".")[1] for name in imported if name.startswith("ddh_twin_py.")}
    assert own == {"plant", "rig"}


@pytest.mark.parametrize(("payload", "rpm"), [(149.5, 500.0), (280.0, 1200.0), (70.0, 250.0)])
def test_energy_is_kept(sheet, payload, rpm):
    done = course(nominal(sheet), exercise(120.0, payload, rpm))
    e = done.ledger
    left = e["electrical"] - e["mechanical"] - e["stored_oil"] - e["given_heat"]
    assert abs(left) < 2e-3 * e["electrical"]


def test_heat_is_stored_or_lost(sheet):
    what = exercise(600.0)
    done = course(nominal(sheet), what)
    first, last = np.empty(heat.N), np.empty(heat.N)
    params, condition = done.params[0], done.condition[0]
    heat.capacities(params, condition, float(done.hydraulic[0, FAST.index("rod_position")]), first)
    heat.capacities(params, condition, float(done.hydraulic[-1, FAST.index("rod_position")]), last)
    ambient = what.ambient[0]
    stored = np.sum(last * (done.temperatures[-1] - ambient)) - np.sum(first * (done.temperatures[0] - ambient))
    assert stored + done.ledger["lost_heat"] == pytest.approx(done.ledger["given_heat"], rel=0.01)


def test_oil_is_the_sheets_within_half_a_per_cent(sheet):
    numbers = [sheet[f"oil.{name}"] for name in ("walther_a", "walther_b", "density_15C", "thermal_expansion")]
    constants = vogel(*numbers)
    for degc in range(5, 66, 5):
        assert viscosity(273.15 + degc, constants) == pytest.approx(walther(273.15 + degc, *numbers), rel=0.005)


def test_oil_stiffens_with_pressure():
    soft = [softness(p, 1.5e9, 0.007) for p in (-0.9e5, 0.0, 1e6, 1e7, 2e7)]
    assert all(a > b > 0.0 for a, b in zip(soft, soft[1:], strict=False))
    assert 1.0 / soft[3] == pytest.approx(1.5e9, rel=0.05)


def test_papers_lift(sheet):
    """16 N*m and about 100 bar at 149.5 kg and 500 rpm."""
    done = course(nominal(sheet), exercise(30.0, rpm=500.0))
    lifting = done.hydraulic[:, FAST.index("rod_velocity")] > 0.05
    assert np.median(done.hydraulic[lifting, FAST.index("pressure_piston_side")]) == pytest.approx(98e5, rel=0.05)
    assert 1.6 * np.median(done.drive[lifting, FAST.index("current")]) == pytest.approx(16.5, rel=0.06)


def test_same_seed_is_the_same_rig_and_another_is_not(sheet):
    one, same, other = (course(build(sheet, np.random.default_rng(k)), exercise(20.0)).drive for k in (3, 3, 4))
    assert np.array_equal(one, same)
    assert not np.allclose(one, other)


def test_replay_of_the_same_commands_is_the_same_course(sheet):
    machine, what = nominal(sheet), exercise(60.0)
    first = course(machine, what)
    again = course(machine, what, same_commands=first)
    assert np.abs(first.drive - again.drive).max(axis=0)[0] < 1e-9
    assert np.abs(first.hydraulic - again.hydraulic)[:, FAST.index("rod_position")].max() < 1e-6


def test_telemetry_has_noise_gaps_and_late_messages(sheet):
    what = exercise(400.0)
    done = course(nominal(sheet), what)
    read = measure(done, quiet(sheet), what.ambient, ("tank_oil",), 1.0, np.random.default_rng(0))
    time, values = read.drive
    assert set(read.temperatures) == {"tank_oil", "ambient"}
    assert 0 < done.drive_time.size - time.size < 100
    assert np.any(np.diff(time) < 0.0)
    assert 0 < np.isnan(values).sum() < 50
    near = np.argmin(np.abs(done.drive_time[:, None] - time[None, ::50]), axis=0)
    off = values[::50, 1] - done.drive[near, FAST.index("speed")]
    still = np.abs(done.drive[near, FAST.index("speed")]) < 0.5
    assert np.nanstd(off[still]) == pytest.approx(sheet.sensors["speed"].noise, rel=0.35)
    assert set(SENSORS) >= set(read.temperatures)
