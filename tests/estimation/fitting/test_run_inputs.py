"""Inputs of a run in longer intervals."""

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.run_inputs import RunInputs
from ddh_twin_py.physics.free_run import COMMAND_PARTS


@pytest.mark.parametrize("n, group", [(6, 2), (7, 2), (7, 3), (1, 2), (5, 5), (4, 1)])
def test_longer_intervals_hold_every_edge_that_they_keep(n, group):
    edges = np.arange(n * COMMAND_PARTS + 1.0)
    longer = RunInputs(0.05, edges, np.arange(n) + 0.5, np.arange(n) + 0.25).of_every(group)
    m = -(-n // group)
    assert longer.interval == pytest.approx(0.05 * group)
    np.testing.assert_allclose(longer.axis, 0.05 * group * np.arange(1, m + 1))
    np.testing.assert_array_equal(longer.air, group * np.arange(m) + 0.5)
    np.testing.assert_array_equal(longer.placed, group * np.arange(m) + 0.25)
    assert longer.command.size == m * COMMAND_PARTS + 1
    np.testing.assert_array_equal(longer.command, np.minimum(group * np.arange(m * COMMAND_PARTS + 1.0), edges[-1]))
