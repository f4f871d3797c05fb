"""The model against limits, closed forms and a second formulation."""

import math
import runpy

import numpy as np
import pytest
from ddh_twin_py.physics import thermal_network as network
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.cylinder import coulomb_friction
from ddh_twin_py.physics.free_run import COMMAND_PARTS, free_run, settle
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES, POSITION, PRESSURE_B, VELOCITY
from ddh_twin_py.physics.motor import LEAST_FLUX, magnet_factor
from ddh_twin_py.physics.oil import ATMOSPHERE, VAPOUR_PRESSURE, compressibility, compressibility_nearby, dynamic_viscosity
from ddh_twin_py.rig import load_rig
from scipy.integrate import solve_ivp
from support.cycles import INTERVAL, START, lift_and_lower, run


@pytest.fixture(scope="module")
def rig():
    return load_rig()


def test_lift_meets_the_papers_torque_and_pressure(rig):
    """Lifting 149.5 kg at 500 rpm: about 16 N*m and 100 bar (paper, section 5)."""
    points, *_ = run(rig, lift_and_lower(stroke_seconds=5.0))
    lifting = points[80:100]
    assert lifting["torque"].mean() == pytest.approx(16.0, abs=1.5)
    assert lifting["pressure_piston_side"].mean() == pytest.approx(100e5, rel=0.08)
    assert lifting["pressure_rod_side"].max() > lifting["pressure_piston_side"].max()  # 0.632 against 0.75
    assert lifting["rod_velocity"].mean() == pytest.approx(22.8e-6 * 500 / 60 / (math.pi / 4 * 0.06**2), rel=0.08)


def test_walther_viscosity_of_vg_32(rig):
    """ISO VG 32 by name: 32 cSt at 40 degC within the grade's 10 %."""
    p = rig.parameters[0]
    kinematic = dynamic_viscosity(313.15, p) / (870.0 * (1 - 6.8e-4 * 25)) * 1e6
    assert kinematic == pytest.approx(32.0, rel=0.1)


def test_entrained_air_matters_at_low_pressure_alone(rig):
    p = rig.parameters[0]
    assert 1 / compressibility(0.0, p) < 0.02 * p["oil_bulk_modulus"]
    assert 1 / compressibility(2e7, p) > 0.9 * p["oil_bulk_modulus"]


@pytest.mark.parametrize("pressure", [-0.99e5, VAPOUR_PRESSURE, 0.0, 2e5, 1e7])
@pytest.mark.parametrize("step", [-0.5, -0.0099, -1e-4, 0.0, 1e-3, 0.0099, 0.02, 3.0])
def test_compressibility_nearby_is_that_of_the_pressure(rig, pressure, step):
    p = rig.parameters[0]
    to = pressure + step * (max(pressure, VAPOUR_PRESSURE) + ATMOSPHERE)
    assert compressibility_nearby(compressibility(pressure, p), pressure, to, p) == pytest.approx(compressibility(to, p), rel=2e-9)


def test_step_size_does_not_matter(rig):
    """Second order: halving the step quarters the error; temperatures good to 1e-4 of their rise."""
    command = lift_and_lower(cycles=2)
    reference = run(rig, command, step=1e-4, start_position=0.08)
    errors = {}
    for step in (1e-3, 2e-3):
        points, temperatures, *_ = run(rig, command, step=step, start_position=0.08)
        rise = np.maximum(np.ptp(reference[1], axis=0), 0.01)  # the valve block stays as it is
        errors[step] = np.max(np.abs(temperatures - reference[1]).max(axis=0) / rise)
        assert points["pressure_rod_side"].max() == pytest.approx(reference[0]["pressure_rod_side"].max(), rel=0.01)
    assert errors[1e-3] < 1e-4
    assert errors[1e-3] < 0.5 * errors[2e-3]


def test_a_drive_that_misses_its_command_runs_as_one_that_was_told_so(rig):
    """Within what the step size changes: where a command bends, steps are finer."""
    command = lift_and_lower()
    missing = rig.with_values({"motor.speed_loop_gain": 0.97, "motor.speed_loop_zero": 0.4})
    points, temperatures, *_ = run(missing, command, start_position=0.08)
    told, as_warm, *_ = run(rig, 0.97 * command + 0.4, start_position=0.08)
    assert points["speed"] == pytest.approx(told["speed"], abs=1e-6) and points["speed"][-1] == pytest.approx(0.4)
    assert points["pressure_piston_side"] == pytest.approx(told["pressure_piston_side"], rel=1e-3, abs=1e3)
    assert temperatures == pytest.approx(as_warm, abs=1e-4)


def test_the_piston_sticks(rig):
    """At rest friction holds any load below its own size: without creep velocity it does not move at all."""
    rig = rig.with_values({"cylinder.creep_velocity": 0.0})
    # 1467 N of load against 4.5e5 Pa on 28.3 cm2 = 1272 N: the rest is within 300 N of friction
    points, _, before, after, _ = run(rig, np.zeros(4), pressures=(4.5e5, 0.0), start_position=0.2)
    assert after[VELOCITY] == 0.0
    np.testing.assert_allclose(points["rod_position"], before[POSITION], rtol=1e-14)
    assert np.all(points["rod_velocity"] == 0.0)


def test_a_loaded_piston_creeps_in_proportion_to_its_load(rig):
    """Sealed chambers give way by their softness alone, so that the first moments show the creep."""
    slow = rig.with_values({"cylinder.creep_velocity": 1.0e-4})
    points, *_ = run(slow, np.zeros(4), pressures=(4.5e5, 0.0), start_position=0.2)
    load = 149.5 * 9.81 - 4.5e5 * np.pi / 4 * rig["cylinder.bore"] ** 2
    share = load / (coulomb_friction(0.0, 4.5e5, slow.parameters[0]) + 1e-4 * rig["cylinder.friction_viscous"])
    assert points["rod_velocity"][0] == pytest.approx(-1.0e-4 * share, rel=0.1)
    assert points["friction_force"][0] == pytest.approx(-load, rel=0.1)


def test_the_load_sinks_once_leakage_has_emptied_the_side(rig):
    _, _, before, after, _ = run(rig, np.zeros(2000), start_position=0.2)
    assert after[POSITION] < before[POSITION] - 1e-3


def test_pressure_stays_above_vapour(rig):
    blocked = rig.with_values({"check_valve.conductance": 1e-15})
    points, _, _, after, _ = run(blocked, lift_and_lower(stroke_seconds=3.0))
    assert points["pressure_rod_side"].min() >= VAPOUR_PRESSURE
    assert points["pressure_rod_side"].min() == pytest.approx(VAPOUR_PRESSURE, rel=1e-6)


def test_a_void_must_fill_before_pressure_rises(rig):
    """Lowering without check valves leaves a void of the missing oil; lifting again gives it back."""
    blocked = rig.with_values({"check_valve.conductance": 1e-15})
    lower = np.concatenate([np.interp(np.arange(0, 3, INTERVAL), [0, 0.4, 2.6, 3.0], [0, -40, -40, 0]), np.zeros(20)])
    _, _, _, emptied, _ = run(blocked, lower, start_position=0.3)
    assert emptied[PRESSURE_B] < VAPOUR_PRESSURE  # the state counts the void


def test_end_stop_holds(rig):
    points, _, _, after, _ = run(rig, np.concatenate([np.interp(np.arange(0, 4, INTERVAL), [0, 0.2, 4], [0, 30, 30])]), start_position=0.38)
    assert after[POSITION] < rig["cylinder.stroke"] + 2e-3


def test_current_limit_is_kept_and_the_shaft_slows(rig):
    heavy = rig.with_values({"load.payload_mass": 4000.0})
    points, *_ = run(heavy, lift_and_lower(stroke_seconds=2.0, speed=100.0), pressures=(1.2e7, 0.0), start_position=0.1)
    assert points["current"].max() <= rig["motor.current_limit"] * 1.05
    assert points["current"].max() > rig["motor.current_limit"] * 0.9


def test_a_drive_at_its_limit_goes_the_way_that_short_steps_show(rig):
    """What the current limit holds back takes no long steps, even where the command is constant."""
    heavy = rig.with_values({"load.payload_mass": 4000.0})
    command, held = lift_and_lower(cycles=2, stroke_seconds=3.0, speed=60.0), 4000.0 * 9.81 / (math.pi / 4 * 0.06**2)
    fine, default = (run(heavy, command, step=step, start_position=0.2, pressures=(held, 0.0))[0] for step in (5e-5, 1e-3))
    assert fine["current"].max() > 0.99 * heavy["motor.current_limit"]
    assert np.abs(default["rod_position"] - fine["rod_position"]).max() < 5e-3  # of 0.2 m


@pytest.mark.parametrize("mass", [2800.0, 3200.0])  # the load's torque below and above the limit's, within dry friction of it
def test_a_stalled_shaft_takes_the_limit_of_current(rig, mass):
    heavy = rig.with_values({"load.payload_mass": mass})
    pressure = mass * rig["load.gravity"] / (0.25 * np.pi * rig["cylinder.bore"] ** 2)
    points, *_ = run(heavy, np.full(60, 20.0), pressures=(pressure, 0.0), start_position=0.1)
    stalled = points[20:]
    assert np.abs(stalled["speed"]).max() < 0.1
    assert stalled["current"] == pytest.approx(rig["motor.current_limit"], rel=1e-3)
    assert stalled["loss_copper"] == pytest.approx(3.0 * rig["motor.phase_resistance_20C"] * rig["motor.current_limit"] ** 2, rel=0.2)


def test_speed_follows_as_first_order_lag(rig):
    command = np.zeros(60)
    command[20:] = 5.0
    points, *_ = run(rig, command)
    assert points["speed"][30:].mean() == pytest.approx(5.0, abs=1e-6)
    # linear ramp over one interval, then exp(-t/tau): mean of the interval after it
    tau = rig["motor.speed_loop_time_constant"]
    at_end = 5.0 - 100.0 * tau * (1 - math.exp(-INTERVAL / tau))
    expected = 5.0 - (5.0 - at_end) * tau / INTERVAL * (1 - math.exp(-INTERVAL / tau))
    assert points["speed"][20] == pytest.approx(expected, rel=1e-3)


def test_warm_oil_leaks_more_and_drags_less(rig):
    cold = run(rig, lift_and_lower(), temperature=START)[0][60:80]
    warm = run(rig, lift_and_lower(), temperature=START + 30.0)[0][60:80]
    assert warm["pressure_rod_side"].mean() < cold["pressure_rod_side"].mean()
    assert warm["torque"].mean() < cold["torque"].mean()


def test_network_at_rest_cools_to_ambient_and_keeps_order(rig):
    _, temperatures, *_ = run(rig, np.zeros(20 * 3600), temperature=START + 20.0)
    assert np.all(np.diff(temperatures[:, network.HOUSING]) <= 1e-12)
    assert np.all(temperatures[-1] > START)
    assert temperatures[-1, network.END_WINDING] > temperatures[-1, network.HOUSING]


def test_network_step_against_lsoda(rig):
    """One formulation against another: the network under constant load by solve_ivp."""
    params = rig.parameters
    edge, wall, surface, capacity = (np.empty(network.N_EDGES), np.empty(network.N_WALLS),
                                     np.empty((network.N_SURFACES, 3)), np.empty(network.N))
    network.conductances(params, edge, wall, surface)
    network.capacities(params, 0.2, capacity)
    rng = np.random.default_rng(3)
    heat = rng.uniform(0.0, 40.0, network.N)
    flow = np.zeros(network.N_FLOWS)
    flow[[0, 2, 4]] = 1.9e-4
    flow[[8, 10, 12]] = 1.4e-4

    def rates(_, temperature):
        out = np.empty(network.N)
        network.network_rates(params, edge, wall, surface, capacity, temperature, START, heat, 80.0, flow, out)
        return out

    start = np.full(network.N, START)
    reference = solve_ivp(rates, (0.0, 300.0), start, method="LSODA", rtol=1e-9, atol=1e-9).y[:, -1]
    temperature, work = start.copy(), np.empty((network.N + 3, network.N))
    for _ in range(6000):
        network.network_step(params, edge, wall, surface, capacity, temperature, START, heat, 80.0, flow, INTERVAL, work)
    assert np.max(np.abs(temperature - reference) / (reference - START)) < 1e-4


def test_network_jacobian_is_the_derivative_of_the_rates(rig):
    params = rig.parameters
    edge, wall, surface, capacity = (np.empty(network.N_EDGES), np.empty(network.N_WALLS),
                                     np.empty((network.N_SURFACES, 3)), np.empty(network.N))
    network.conductances(params, edge, wall, surface)
    network.capacities(params, 0.1, capacity)
    rng = np.random.default_rng(4)
    temperature = START + rng.uniform(5.0, 40.0, network.N)
    flow = rng.uniform(0.0, 2e-4, network.N_FLOWS)
    heat = np.zeros(network.N)
    jacobian = np.empty((network.N, network.N))
    network.network_jacobian(params, edge, wall, surface, capacity, temperature, START, 50.0, flow, jacobian)

    def rate(at):
        out = np.empty(network.N)
        network.network_rates(params, edge, wall, surface, capacity, at, START, heat, 50.0, flow, out)
        return out

    numeric = np.column_stack([(rate(temperature + h) - rate(temperature - h)) / 2e-3 for h in 1e-3 * np.eye(network.N)])
    np.testing.assert_allclose(jacobian, numeric, rtol=1e-5, atol=1e-8)


def test_sparse_elimination_solves(rig):
    rng = np.random.default_rng(5)
    matrix = np.eye(network.N)
    for i, j in [(e[1], e[2]) for e in network.EDGES] + [(f[2], f[3]) for f in network.FLOWS]:
        matrix[i, j] -= rng.uniform(0.0, 0.1)
        matrix[j, i] -= rng.uniform(0.0, 0.1)
    b = rng.normal(size=network.N)
    lu, x = matrix.copy(), b.copy()
    network.factorise(lu)
    network.solve(lu, x)
    np.testing.assert_allclose(matrix @ x, b, rtol=1e-10, atol=1e-12)


def test_the_elimination_is_that_of_the_tables(repo_root):
    made = runpy.run_path(str(repo_root / "scripts" / "network_elimination.py"))
    assert made["FILE"].read_text(encoding="utf-8") == made["source"](), "python scripts/network_elimination.py writes it anew"


def test_every_conductance_of_the_tables_reaches_the_kernel(rig):
    """The tables name the sheet's entries; the kernel must read those very entries."""
    edge, wall, surface = np.empty(network.N_EDGES), np.empty(network.N_WALLS), np.empty((network.N_SURFACES, 3))
    network.conductances(rig.parameters, edge, wall, surface)
    upper = rig["tank.top_share"]  # the layers of the tank share its wall
    layer = {("tank.oil_to_wall", network.TANK): 1.0 - upper, ("tank.oil_to_wall", network.TANK_TOP): upper}
    mixed = {"tank.mixing_resistance": 1.0 / (network.MIXED + rig["tank.mixing_resistance"])}
    np.testing.assert_array_equal(edge, [mixed.get(e[0], rig[e[0]] * layer.get(e[:2], 1.0)) for e in network.EDGES])
    np.testing.assert_array_equal(wall, [rig[w[0]] for w in network.WALLS])
    np.testing.assert_array_equal(surface, [[rig[path] for path in row[:3]] for row in network.SURFACES])
    capacity = np.empty(network.N)
    network.capacities(rig.parameters, 0.0, capacity)
    for path, node in network.CAPACITIES:
        assert capacity[node] == rig[path]


def test_a_stalled_drive_does_not_burn_for_ever(rig):
    """Against the end stop at full current for ten minutes: hot, finite, cut back."""
    command = np.concatenate([np.interp(np.arange(0.0, 2.0, INTERVAL), [0.0, 0.5, 2.0], [0.0, 52.0, 52.0]), np.full(20 * 600, 52.0)])
    points, temperatures, *_ = run(rig, command, start_position=0.39)
    assert 400.0 < temperatures[-1, network.SLOT_WINDING] < 600.0
    assert points["current"][-1] < points["current"].max()


def test_a_stratified_tank_is_warmer_on_top_and_ends_alike(rig):
    """Warm oil returns on top; poor mixing keeps it there, and the heat in the tank is the same."""
    command = lift_and_lower(cycles=4)
    mixed = run(rig.with_values({"tank.mixing_resistance": 0.0}), command, start_position=0.08)[1][-1]
    still = rig.with_values({"tank.mixing_resistance": 1.0, "tank.suction_from_top": 0.0})
    _, temperatures, _, after, _ = run(still, command, start_position=0.08)
    layered, capacity = temperatures[-1], np.empty(network.N)
    network.capacities(still.parameters, after[POSITION], capacity)
    circling = run(rig.with_values({"tank.mixing_resistance": 1.0, "tank.suction_from_top": 1.0}), command, start_position=0.08)[1][-1]
    share = capacity[network.TANK_TOP] / (capacity[network.TANK_TOP] + capacity[network.TANK])
    assert abs(mixed[network.TANK_TOP] - mixed[network.TANK]) < 0.01
    assert layered[network.TANK_TOP] - layered[network.TANK] > 0.05
    mean = share * layered[network.TANK_TOP] + (1.0 - share) * layered[network.TANK]
    assert mean == pytest.approx(mixed[network.TANK], abs=0.05)
    assert circling[network.PUMP_1_OIL] > mixed[network.PUMP_1_OIL] + 0.01  # the same oil goes round and stays warmer


def test_oil_under_pressure_is_thicker_where_a_rig_says_so(rig):
    """Barus: 2e-8 1/Pa makes 22 % more at 100 bar, so less leaks at the same pressure."""
    command = lift_and_lower(cycles=1)
    leaks, pressure = [], 0.0
    for coefficient in (0.0, 2e-8):
        points = run(rig.with_values({"oil.viscosity_pressure_coefficient": coefficient}), command, start_position=0.08)[0]
        k = np.flatnonzero(points["speed"] > 52.0)[-5]  # steady, late in the lift
        pressure = points["pressure_piston_side"][k]
        leaks.append(points["pump_1_leakage"][k] / points["pump_1_port_pressure"][k])
    assert leaks[0] / leaks[1] == pytest.approx(np.exp(2e-8 * pressure), rel=0.02)  # the oil is a little warmer, too


def test_a_state_of_the_wrong_length_is_refused(rig):
    with pytest.raises(ValueError, match="wrong length"):
        settle(rig.parameters, np.zeros(7), 0.1, 0.0, 0.0)


@pytest.mark.parametrize("short", ["command", "ambient", "measured_position", "temperatures"])
def test_arrays_that_are_shorter_than_the_run_are_refused(rig, short):
    n = 3
    sizes = {"command": n * COMMAND_PARTS + 1, "ambient": n, "measured_position": n, "temperatures": n}
    given = {name: np.full((size - (name == short), network.N) if name == "temperatures" else size - (name == short), 300.0)
             for name, size in sizes.items()}
    given["measured_position"][:] = np.nan
    with pytest.raises(ValueError, match="shorter than the run"):
        free_run(rig.parameters, np.zeros(len(HYDRAULIC_STATES)), np.full(network.N, 300.0), 0.0 * given["command"], given["ambient"], 0.05,
                 1e-3, given["measured_position"], np.zeros(n, OPERATING_DTYPE), given["temperatures"])


def test_a_piston_that_meets_the_end_stop_leaves_no_false_void(rig):
    command = lift_and_lower(cycles=3)  # lowers onto the stop while the command is constant
    points, finer = (run(rig, command, step=step)[0] for step in (1.0e-3, 2.5e-4))
    assert finer["rod_position"].min() < 0.0
    assert points["mean_square_current"].sum() == pytest.approx(finer["mean_square_current"].sum(), rel=2e-3)


def test_magnets_keep_a_fifth_of_their_flux_however_steep_their_slope():
    record = load_rig().with_values({"motor.torque_constant_slope": -0.025}).parameters
    assert magnet_factor(273.15 + 23.0, record[0]) == 1.0
    assert magnet_factor(273.15 + 33.0, record[0]) == pytest.approx(0.75)
    assert magnet_factor(273.15 + 90.0, record[0]) == LEAST_FLUX
