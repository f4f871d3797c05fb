"""The filter's derivatives against differences of its own mean, and what its uncertain heats do."""

import numpy as np
import pytest
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.estimation.temperature_filter import predict_covariance, predict_mean, scaled_heat
from ddh_twin_py.estimation.uncertain_parameters import HEAT_SPLITS, N_UNCERTAIN, SPLIT_AT, uncertain_parameters
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
    return {
        "params": load_rig().parameters, "lag": 6.0, "heat": rng.uniform(5.0, 80.0, N), "square": 60.0,
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
def test_a_split_moves_heat_and_makes_none_but_for_leakage(inputs, number):
    path, _, source, nodes = HEAT_SPLITS[number]
    deviation, plain, out = np.zeros(N_UNCERTAIN), np.empty(N), np.empty(N)
    rest = (inputs["params"], deviation, inputs["dynamic"][:N], inputs["heat"], inputs["square"], inputs["flow"])
    scaled_heat(*rest, plain)
    deviation[SPLIT_AT + number] = 0.1
    scaled_heat(*rest, out)
    gained = 0.1 * inputs["heat"][NODES.index(source)]
    assert out[NODES.index(source)] - plain[NODES.index(source)] == pytest.approx(gained)
    assert (out - plain).sum() == pytest.approx(gained if path.endswith(".leakage") else 0.0, abs=1e-12)
    assert {NODES[i] for i in np.flatnonzero(out != plain)} == set(nodes)
