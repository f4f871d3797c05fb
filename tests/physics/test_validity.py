"""What is said of oil outside the range of its viscosity law."""

from dataclasses import replace

import numpy as np
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.physics.validity import outside_stated
from ddh_twin_py.rig import load_rig
from support.simulated import simulated


def test_oil_alone_counts_and_the_furthest_is_named():
    temperatures = np.full((3, len(NODES)), 293.15)
    assert outside_stated(temperatures) == ""
    temperatures[1, NODES.index("slot_winding")] = 420.0
    assert outside_stated(temperatures) == ""
    temperatures[1, NODES.index("line_a_oil")] = 273.15 - 21.0
    temperatures[2, NODES.index("tank_oil")] = 273.15 - 25.5
    said = outside_stated(temperatures)
    assert "tank_oil is at -25.5 degC" in said and "-20 to 100 degC" in said
    assert outside_stated(np.full(len(NODES), np.nan)) == ""


def test_a_replay_says_that_it_extrapolates():
    recording, _ = simulated(1)
    assert not [f for f in replay(recording, load_rig()).recording.findings if "extrapolated" in f.message]
    cold = {}
    for name, stream in recording.temperatures.items():
        values = stream.values.copy()
        values[:, 0] -= 50.0
        cold[name] = type(stream)(stream.time, values, stream.fields)
    told = replay(replace(recording, temperatures=cold), load_rig()).recording.findings
    assert any("extrapolated" in f.message and recording.path in f.message for f in told)
