"""Energy is kept: electrical, mechanical, hydraulic and thermal accounts close to 0.1 %."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.hydraulics import POSITION, SPEED, VELOCITY
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE, soft_sensor
from ddh_twin_py.physics.thermal_network import N, capacities
from ddh_twin_py.rig import load_rig
from support.cycles import INTERVAL, START, lift_and_lower, run

LOSSES = [name for name in OPERATING_DTYPE.names if name.startswith("loss_")]


def starving(rig, **unfilled):
    """The rig with pumps that their suctions do not fill."""
    quantities = {name: replace(rig.quantities[name.replace("__", ".")], value=value) for name, value in unfilled.items()}
    return replace(rig, quantities={**rig.quantities, **{name.replace("__", "."): q for name, q in quantities.items()}})


@pytest.fixture(scope="module", params=[{}, {"pump_1__unfilled_by_speed": 1e-3, "pump_2__unfilled_by_viscosity": 0.05}])
def rig(request):
    return starving(load_rig(), **request.param)


@pytest.fixture(scope="module")
def cycle(rig):
    return run(rig, lift_and_lower(cycles=3))


def integral(points, name):
    return points[name].sum() * INTERVAL


def stored_heat(rig, temperatures, position_before, position_after):
    """Heat in all nodes above the start temperature, J."""
    capacity = np.empty(N)
    capacities(rig.parameters, position_after, capacity)
    return float(capacity @ (temperatures[-1] - START))


def test_free_run_electrical_to_everything(rig, cycle):
    points, _, before, after, _ = cycle
    mass, inertia = rig["load.payload_mass"], rig["motor.inertia"]
    kinetic = 0.5 * mass * (after[VELOCITY] ** 2 - before[VELOCITY] ** 2) + 0.5 * inertia * (after[SPEED] ** 2 - before[SPEED] ** 2)
    lifted = mass * rig["load.gravity"] * (after[POSITION] - before[POSITION])
    losses = sum(integral(points, name) for name in LOSSES)
    electrical = integral(points, "electrical_power")
    assert electrical == pytest.approx(losses + kinetic + lifted + integral(points, "compression_power"), rel=1e-3)
    assert losses > 0.5 * electrical  # the unit gives most of it away


def test_free_run_shaft_to_ports(cycle):
    points = cycle[0]
    pumps = integral(points, "loss_pump_1") + integral(points, "loss_pump_2")
    assert integral(points, "shaft_power") == pytest.approx(integral(points, "hydraulic_power") + pumps, rel=1e-6)


def test_free_run_heat_is_stored_or_lost(rig, cycle):
    points, temperatures, before, after, lost = cycle
    brought = points["heat"].sum() * INTERVAL + integral(points, "loss_copper")
    stored = stored_heat(rig, temperatures, before[POSITION], after[POSITION])
    assert stored + lost == pytest.approx(brought, rel=1e-3)


def test_heat_of_the_nodes_is_all_of_the_losses(cycle):
    points = cycle[0]
    losses = sum(points[name] for name in LOSSES if name != "loss_copper")
    np.testing.assert_allclose(points["heat"].sum(axis=1), losses, rtol=1e-9, atol=1e-6)


def test_soft_sensor_heat_is_stored_or_lost(rig, cycle):
    driven, _, before, after, _ = cycle
    n = driven.size
    measured = np.zeros(n, MEASURED_DTYPE)
    for name in ("speed", "current", "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity"):
        measured[name] = driven[name]
    measured["current_square"] = driven["mean_square_current"]
    points, temperatures = np.zeros(n, OPERATING_DTYPE), np.empty((n, N))
    nodes = np.full(N, START)
    lost = soft_sensor(rig.parameters, measured, nodes, False, INTERVAL, nodes, np.full(n, START), points, temperatures)
    brought = points["heat"].sum() * INTERVAL + integral(points, "loss_copper")
    assert stored_heat(rig, temperatures, before[POSITION], after[POSITION]) + lost == pytest.approx(brought, rel=1e-3)
    # driven by the free run's own pressures and speeds it must find the free run's losses
    total = sum(integral(points, name) for name in LOSSES)
    assert total == pytest.approx(sum(integral(driven, name) for name in LOSSES), rel=0.02)


def test_soft_sensor_electrical_account(rig, cycle):
    driven = cycle[0]
    n = driven.size
    measured = np.zeros(n, MEASURED_DTYPE)
    for name in ("speed", "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity"):
        measured[name] = driven[name]
    points, temperatures = np.zeros(n, OPERATING_DTYPE), np.empty((n, N))
    measured["current_square"] = driven["mean_square_current"]
    nodes = np.full(N, START)
    soft_sensor(rig.parameters, measured, nodes, False, INTERVAL, nodes, np.full(n, START), points, temperatures)
    pumps = integral(points, "loss_pump_1") + integral(points, "loss_pump_2")
    assert integral(points, "shaft_power") == pytest.approx(integral(points, "hydraulic_power") + pumps, rel=1e-6)
    motion = integral(points, "shaft_power") + integral(points, "loss_motor_friction") + integral(points, "loss_iron")
    copper = 3.0 * rig["motor.phase_resistance_20C"] * (points["current"] ** 2).sum() * INTERVAL
    assert integral(points, "electrical_power") == pytest.approx(motion + copper, rel=0.02)


def test_a_pump_that_starves_lifts_slower_and_lowers_as_fast():
    rig = load_rig()
    full, starved = (run(there, lift_and_lower(cycles=1))[0] for there in (rig, starving(rig, pump_1__unfilled_by_speed=1e-3)))
    speed = full["speed"]
    up, down = speed > 0.9 * speed.max(), speed < 0.9 * speed.min()
    lost = 1e-3 * speed[up].mean()
    swept, filled = ((p["pump_1_flow"] + p["pump_1_leakage"])[up].mean() for p in (full, starved))
    assert filled / swept == pytest.approx(1.0 - lost, abs=0.02 * lost)
    assert starved["rod_velocity"][down].mean() == pytest.approx(full["rod_velocity"][down].mean(), rel=1e-3)
