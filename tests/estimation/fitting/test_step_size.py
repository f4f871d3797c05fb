"""Steps are as fine as the recording needs, and no finer."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.estimation.fitting.problem import _STEP
from ddh_twin_py.estimation.fitting.step_size import times_finer
from ddh_twin_py.rig import load_rig
from support.simulated import DUTY, of_the_sheet

SHORT = """
payload_kg: 500
ambient_degC: 20
start_position_m: 0.05
ramp_rpm_per_s: 3000
repeat: 0
cycle:
  - lift: {speed_rpm: 500, to_m: 0.08}
  - dwell: {duration_s: 1}
  - lower: {speed_rpm: 500, to_m: 0.05}
  - dwell: {duration_s: 1}
"""


def off(experiment, parameters):
    predicted, signal = experiment.predict(parameters, _STEP), experiment.signals["pressure_piston_side"]
    used = signal.binning.bin >= 0
    return float(np.sqrt(np.mean((signal.measured - predicted["pressure_piston_side"])[used] ** 2))) / signal.noise


def test_a_heavy_load_on_steep_ramps_takes_finer_steps_and_a_gentle_duty_none():
    rig = load_rig()
    steep = Experiment(of_the_sheet(SHORT, 60.0, 5), rig)
    parameters = steep.parameters(rig)
    before = off(steep, parameters)
    assert before > 1.1 and steep.refine(parameters, _STEP) > 1
    assert off(steep, parameters) < 1.0 + 0.6 * (before - 1.0)
    gentle = Experiment(of_the_sheet((DUTY / "paper_cycle.yaml").read_text(), 60.0, 5), rig)
    assert gentle.refine(gentle.parameters(rig), _STEP) == 1


@pytest.mark.parametrize(("errors", "times"), [({1: 0.2}, 1), ({1: 0.9, 2: 0.3}, 2), ({1: 0.9, 2: 0.6, 4: 0.1}, 4),
                                               ({1: 1.0, 2: 1.1, 4: 0.9}, 1)])
def test_the_coarsest_that_is_fine_enough(errors, times):
    binning = SimpleNamespace(bin=np.zeros(10, int), phase=np.zeros(1, int))
    signals = {"speed": SimpleNamespace(binning=binning, measured=np.zeros(10), noise=2.0)}
    found = times_finer(signals, lambda finer: {"speed": np.full(10, 2.0 * errors.get(finer, 0.0))})
    assert found == times
