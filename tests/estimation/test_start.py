"""Where temperatures begin: what a minute of readings says beyond the first ones."""

import numpy as np
import pytest
from ddh_twin_py.estimation.start import EARLY, start_error

NOISE = 0.1


def drawn(random, change, error=0.07, n=30):
    time = np.linspace(0.0, EARLY, n)
    slope = 0.15 * change * random.standard_normal()
    return time, error + slope * time / EARLY + NOISE * random.standard_normal(n)


@pytest.mark.parametrize("change", [0.0, 0.5, 10.0])
def test_it_is_as_sure_as_it_says(change):
    random = np.random.default_rng(3)
    errors, said = [], 0.0
    for _ in range(400):
        time, off = drawn(random, change)
        found, said = start_error(time, off, change, NOISE)
        errors.append((found - 0.07) / said)
    assert 0.9 < np.std(errors) < 1.1 and abs(np.mean(errors)) < 0.15
    assert NOISE / np.sqrt(30) * 0.999 <= said < 0.4 * NOISE
