"""The steps in which a channel is given."""

import math

import numpy as np
import pytest
from ddh_twin_py.telemetry.resolution import resolution, rounding_error

RNG = np.random.default_rng(3)
WARMING = 300.0 + np.linspace(0.0, 12.0, 3000) + RNG.normal(0.0, 0.1, 3000)


@pytest.mark.parametrize(("step", "warms"), [(1.0, 1.0), (0.5, 1.0), (0.1, 1.0), (1 / 32, 0.1), (1 / 64, 0.1), (1 / 128, 0.1)])
def test_rounded_readings_tell_their_step(step, warms):
    rounded = 273.15 + np.round((300.0 + warms * (WARMING - 300.0) - 273.15) / step) * step
    assert resolution(rounded) == pytest.approx(step, abs=1e-4)
    assert resolution(rounded.astype(np.float32).astype(float)) == pytest.approx(step, abs=1e-4)
    assert rounding_error(rounded) == pytest.approx(step / math.sqrt(12.0), abs=1e-3)
    rounded[::7] = np.nan
    assert resolution(rounded) == pytest.approx(step, abs=1e-3)


def test_what_is_not_rounded_has_no_step():
    assert resolution(WARMING) == 0.0
    assert resolution(np.full(100, 300.0)) == 0.0, "a reading that never changes tells none"
    assert resolution(np.full(100, np.nan)) == 0.0
    assert resolution(np.array([300.0, 301.0, 303.0])) == 0.0, "three readings may lie so by chance"
    two_steps = np.repeat([300.0, 301.0, 302.4], 50)
    assert resolution(two_steps) == 0.0
