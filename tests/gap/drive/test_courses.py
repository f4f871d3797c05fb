"""What an effect adds at its place: what a better cooled surface loses more."""

import numpy as np
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.drive.case import DriveCase
from ddh_twin_py.gap.drive.direct_drive import STEP
from ddh_twin_py.physics.thermal_network import TANK_WALL
from ddh_twin_py.rig import load_rig
from support.simulated import simulated


def test_more_convection_cools_a_wall_that_is_warmer_than_the_air_and_warms_one_that_is_colder():
    rig = load_rig()
    case = DriveCase([], [Experiment(simulated(1, "mixed", 60.0)[0], rig)], rig)
    effect, theta = EFFECTS["tank.cooling"], np.zeros(case.size)
    without, acting = case.record(0, theta), case.record(0, theta, [(effect, 0, 0.3)])
    added = case.course(effect, without, acting)
    _, temperatures = case.field[0].operating(acting, STEP)
    above = temperatures[:, TANK_WALL] - case.field[0].air
    more = 0.3 * without["tank_convection"][0] * without["tank_area"][0]
    assert added.unit == "W" and above.min() < -0.03 and above.max() > 0.1
    np.testing.assert_allclose(added.value, more * np.sign(above) * np.abs(above) ** 1.25, rtol=1e-6, atol=1e-9)
