"""What sensors read of the network: one node each, the tank's the mean of both layers, whoever asks."""

import numpy as np
import pytest
from ddh_twin_py.physics.thermal_network import N, NODES, TANK, TANK_TOP
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.rehearsal import rehearse
from ddh_twin_py.twin.simulated_rig import SimulatedRig, Surroundings
from ddh_twin_py.twin.temperature_sensors import NODE_OF_SENSOR, SENSORS, all_sensed, sensed
from support.simulated import DUTY


def parted(layers=20.0):
    """K above the air, the tank's upper layer warmer than the lower, all else as cold as it."""
    start = np.zeros(N)
    start[TANK_TOP] = layers
    return start


def test_each_sensor_reads_its_node_and_the_tanks_the_mean_of_its_layers():
    temperature = np.arange(2.0 * N).reshape(2, N)
    met = all_sensed(temperature, 0.3)
    for sensor, column in zip(SENSORS, met.T, strict=True):
        np.testing.assert_array_equal(column, sensed(temperature, sensor, 0.3))
        if sensor == "tank_oil":
            np.testing.assert_allclose(column, 0.7 * temperature[:, TANK] + 0.3 * temperature[:, TANK_TOP])
        else:
            np.testing.assert_array_equal(column, temperature[:, NODES.index(NODE_OF_SENSOR[sensor])])
    with pytest.raises(KeyError):
        sensed(temperature, "ambient", 0.3)


def test_recordings_of_the_model_read_the_mean_of_the_tank():
    rig, duty = load_rig(), load_duty(DUTY / "mixed.yaml")
    share = rig["tank.top_share"]
    noise = rig.sensors["temperature"]
    simulated = SimulatedRig(rig, duty, 0, Surroundings(parted(), lambda now: np.zeros(N)))
    read = next(simulated.run(1.0)).temperatures["tank_oil"].values[0, 0]
    assert read - duty.ambient[0] == pytest.approx(20.0 * share, abs=4.0 * np.hypot(noise.noise, noise.offset_tolerance))
    rehearsed = rehearse(rig, duty, 2.0, ["tank_oil"], start=duty.ambient[0] + parted())
    assert rehearsed.temperatures["tank_oil"].values[0, 0] - duty.ambient[0] == pytest.approx(20.0 * share, abs=5.0 * noise.noise)
