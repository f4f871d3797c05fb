"""The filter's derivatives against differences of its own mean, and what its uncertain heats do."""

import numpy as np
import pytest
from ddh_twin_py.estimation.fusion.covariance_prediction import predict_covariance
from ddh_twin_py.estimation.fusion.deviating_network import scaled_heat
from ddh_twin_py.estimation.fusion.temperature_filter import predict_mean
from ddh_twin_py.estimation.fusion.uncertain_parameters import (
    HEAT_SPLITS,
    N_PUMP_LOSS,
    N_UNCERTAIN,
    PUMP_LOSS_AT,
    SPLIT_AT,
    uncertain_parameters,
)
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE, soft_sensor
from ddh_twin_py.physics.thermal_network import N, N_FLOWS, NODES
from ddh_twin_py.rig import load_rig

M = len(SENSORS)
D = N + M
INTERVAL = 1.0e-3
"""s; so short that the two steps, of first and of second order, agree."""
NODE = np.array([NODE_INDEX[sensor] for sensor in SENSORS])


@pytest.fixture(scope="module")
def inputs():
    rng = np.random.default_rng(5)
    heat = rng.uniform(5.0, 80.0, N)
    heat[[NODES.index(f"pump_{k}_oil") for k in (1, 2)]] += 1500.0
    heat[[NODES.index(f"pump_{k}_case") for k in (1, 2)]] += 300.0  # friction of either kind, and leakage
    return {
        "params": load_rig().parameters, "lag": np.full(NODE.size, 6.0), "heat": heat, "square": 60.0,
        "flow": rng.uniform(1.0e-5, 2.0e-4, N_FLOWS), "position": 0.2, "ambient": 296.0,
        "dynamic": 296.0 + rng.uniform(2.0, 40.0, D),
    }


def moved(inputs, dynamic, deviation):
    dynamic, deviation = dynamic.copy(), deviation.copy()
    predict_mean(inputs["params"], dynamic, deviation, NODE, inputs["lag"], inputs["heat"], inputs["square"], inputs["flow"],
                 inputs["position"], inputs["ambient"], INTERVAL, np.empty((N + 3, N)))
    return dynamic


def test_every_column_of_the_transition_is_the_derivative_of_the_mean(inputs):
    size = D + M + N_UNCERTAIN
    transition = np.empty((D, D + N_UNCERTAIN))
    predict_covariance(inputs["params"], inputs["dynamic"], np.zeros(N_UNCERTAIN), np.zeros((size, size)), NODE, inputs["lag"],
                       inputs["heat"], np.zeros(N), inputs["square"], inputs["flow"], inputs["position"], inputs["ambient"], INTERVAL,
                       transition)
    names = uncertain_parameters(load_rig()).names
    for j in range(D + N_UNCERTAIN):
        step = 0.1
        shift = np.zeros(D + N_UNCERTAIN)
        shift[j] = step
        up = moved(inputs, inputs["dynamic"] + shift[:D], shift[D:])
        down = moved(inputs, inputs["dynamic"] - shift[:D], -shift[D:])
        slope = (up - down) / (2.0 * step)
        still = np.eye(D)[j] if j < D else np.zeros(D)
        change = np.abs(slope - still).max()
        if j >= D and names[j - D] in ("motor.flange_conductance", "tank.mount_conductance"):
            assert change == 0.0  # a deviation of nothing
        else:
            assert change > 0.0, j if j < D else names[j - D]
        np.testing.assert_allclose(transition[:, j], slope, atol=0.03 * change, err_msg=str(j if j < D else names[j - D]))


@pytest.mark.parametrize("number", range(len(HEAT_SPLITS)))
def test_a_split_moves_heat_and_makes_none(inputs, number):
    _, source, nodes = HEAT_SPLITS[number]
    deviation, plain, out = np.zeros(N_UNCERTAIN), np.empty(N), np.empty(N)
    rest = (inputs["params"], deviation, inputs["dynamic"][:N], inputs["heat"], inputs["square"], inputs["flow"])
    scaled_heat(*rest, plain)
    deviation[SPLIT_AT + number] = 0.1
    scaled_heat(*rest, out)
    gained = 0.1 * inputs["heat"][NODES.index(source)]
    assert out[NODES.index(source)] - plain[NODES.index(source)] == pytest.approx(gained)
    assert (out - plain).sum() == pytest.approx(0.0, abs=1e-12)
    assert {NODES[i] for i in np.flatnonzero(out != plain)} == set(nodes)


@pytest.mark.parametrize("pump", [1, 2])
def test_the_parts_of_a_pumps_loss_are_those_of_the_model(pump):
    """At an operating point of the soft sensor: friction with pressure, friction with speed, leakage, and where their heat goes."""
    rig = load_rig()
    measured = np.zeros(1, MEASURED_DTYPE)
    delivered = 50.0 * rig["pump_1.displacement"] / (2.0 * np.pi) - rig["pump_1.leakage"] * 1.0e7
    velocity = delivered / (0.25 * np.pi * rig["cylinder.bore"] ** 2)
    displaced = delivered * (1.0 - (rig["cylinder.rod"] / rig["cylinder.bore"]) ** 2)  # at the rod side; pump 2 leaks what it does not take
    rod_side = (displaced - 50.0 * rig["pump_2.displacement"] / (2.0 * np.pi)) / rig["pump_2.leakage"]
    for name, value in {"speed": 50.0, "pressure_piston_side": 1.0e7, "pressure_rod_side": rod_side, "rod_position": 0.2,
                        "rod_velocity": velocity, "current": 8.0, "current_square": 64.0}.items():
        measured[name] = value
    temperature, points = np.full(N, 296.15), np.zeros(1, OPERATING_DTYPE)
    soft_sensor(rig.parameters, measured, temperature, False, 0.05, temperature.copy(), np.full(1, 296.15), points, np.empty((1, N)))
    point, name = points[0], f"pump_{pump}"
    expected = np.array([
        rig[f"{name}.friction_pressure"] * rig[f"{name}.displacement"] / (2.0 * np.pi) * point[f"{name}_port_pressure"] * 50.0,
        50.0 * (rig[f"{name}.friction_constant"] + rig[f"{name}.friction_viscous"] * 50.0),
        point[f"{name}_leakage"] * point[f"{name}_port_pressure"],
    ])
    assert expected.sum() == pytest.approx(point[f"loss_{name}"], rel=1e-3)
    share, case, oil = rig[f"{name}.friction_share_to_case"], NODES.index(f"{name}_case"), NODES.index(f"{name}_oil")
    for part, heat in enumerate(expected):
        deviation, plain, out = np.zeros(N_UNCERTAIN), np.empty(N), np.empty(N)
        rest = (rig.parameters, deviation, temperature, point["heat"], 64.0, point["flow"])
        scaled_heat(*rest, plain)
        deviation[PUMP_LOSS_AT + (pump - 1) * N_PUMP_LOSS + part] = 1.0
        scaled_heat(*rest, out)
        to_case = share * heat if part < 2 else 0.0
        assert (out - plain)[case] == pytest.approx(to_case, rel=0.02, abs=1e-9)
        assert (out - plain)[oil] == pytest.approx(heat - to_case, rel=0.02)
