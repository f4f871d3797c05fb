"""The twin with a rig whose quantity is at the end of what a rig file may say: finite numbers, whatever they are."""

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.bounds import contradiction
from ddh_twin_py.rig.sheet import BOUNDS


@pytest.fixture(scope="module")
def lift(paper_cycle_bag):
    return read_recording(paper_cycle_bag).between(0.0, 6.0)


@pytest.mark.parametrize("path", BOUNDS)
def test_outputs_are_finite(lift, path):
    rig = load_rig()
    for end in (BOUNDS[path].lowest, BOUNDS[path].highest):
        changed = rig.with_values({path: end})
        if contradiction({name: q.value for name, q in changed.quantities.items()}):
            continue
        result = replay(lift, changed)
        for name in ("free_temperature", "fused", "fused_std"):
            assert np.isfinite(getattr(result, name)).all(), (end, name)
        for points in (result.free, result.soft):
            assert all(np.isfinite(points[name]).all() for name in points.dtype.names), end
