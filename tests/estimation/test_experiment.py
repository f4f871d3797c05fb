"""Free runs over recordings that lack something."""

import numpy as np
import pytest
from ddh_twin_py.bags.damage import with_value
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.experiment import Experiment
from ddh_twin_py.physics.cylinder import piston_area
from ddh_twin_py.rig import load_rig


def test_a_load_of_unknown_pressure_is_held_at_the_start(paper_cycle_bag):
    rig, recording = load_rig(), read_recording(paper_cycle_bag).between(0.0, 60.0)
    blind = recording
    for name in ("pressure_piston_side", "pressure_rod_side"):
        blind = with_value(blind, "hydraulics/telemetry", name, np.nan)
    known, held = (Experiment(r, rig) for r in (recording, blind))
    points = held.operating(held.parameters(rig))[0]
    force = recording.rig.payload_mass * rig["load.gravity"]
    assert points["pressure_piston_side"][0] == pytest.approx(force / piston_area(held.parameters(rig)[0]), rel=0.15)
    measured = known.operating(known.parameters(rig))[0]
    assert np.abs(points["rod_position"] - measured["rod_position"]).max() < 2e-3
