"""Levels on a drifting base: found where there are any, none where there are none."""

import numpy as np
import pytest
from ddh_twin_py.real_rigs.zema import levels
from ddh_twin_py.real_rigs.zema.levels import Series, find, left_out, none

N, NOISE, DRIFT = 500, 0.01, 0.006


def made(shifts, seed=0, slope=0.0, known=40):
    rng = np.random.default_rng(seed)
    level = np.repeat(rng.integers(0, len(shifts), N // 10), 10)
    level[-known:] = 0
    warmth = np.interp(np.arange(N), [0, 250, N], [2.0, 1.0, 0.0])[:, None]
    value = np.asarray(shifts)[level] + np.cumsum(rng.normal(0.0, DRIFT, N)) + slope * warmth[:, 0] + rng.normal(0.0, NOISE, N)
    favour = np.where(np.arange(N) >= N - known, levels.KNOWN, 0.0)
    return Series(value, NOISE, np.full(N, DRIFT), favour, warmth, np.array([0.05]), 0.04), level


def test_levels_are_found_beside_drift_and_warmth():
    series, level = made([0.0, -0.12, -0.25], slope=0.05)
    found = find(series, (2, 3, 4), (-1.0,))
    assert found.shift == pytest.approx([0.0, -0.12, -0.25], abs=0.02)
    assert np.mean(found.probability.argmax(axis=1) == level) > 0.98
    assert np.mean((found.worse > 0.5) == (level > 0)) > 0.98
    np.testing.assert_allclose(found.probability.sum(axis=1), 1.0, atol=1e-6)
    assert np.all((found.worse >= 0.0) & (found.worse <= 1.0))


@pytest.mark.parametrize("seed", range(3))
def test_levels_are_found_beside_a_dependence_on_the_oil_that_is_larger_than_they_are(seed):
    n, rng = 600, np.random.default_rng(seed)
    level = np.repeat(rng.integers(0, 3, n // 10), 10)
    level[-40:] = 0
    warm, target = np.full(n, 2.0), np.repeat([2.0, 1.0, 0.0, -1.0, 1.5, 0.0], n // 6)
    for t in range(1, n):
        warm[t] = warm[t - 1] + 0.15 * (target[t] - warm[t - 1])
    columns, beta = np.stack([0.3 * warm + 0.1 * warm**2, warm], axis=1), np.array([-0.5, -0.1])
    shifts = np.array([0.0, 0.24, 0.36])
    value = shifts[level] + np.cumsum(rng.normal(0.0, 0.001, n)) + columns @ beta + rng.normal(0.0, 0.005, n)
    favour = np.where(np.arange(n) >= n - 40, levels.KNOWN, 0.0)
    found = find(Series(value, 0.005, np.full(n, 0.002), favour, columns, np.array([0.5, 0.05]), 0.04), (2, 3), (1.0,))
    assert found.shift == pytest.approx(shifts, abs=0.01) and np.mean((found.worse > 0.5) == (level > 0)) > 0.98


def test_the_side_may_be_unknown():
    series, level = made([0.0, 0.15])
    found = find(series, (2,), (-1.0, 1.0))
    assert found.shift == pytest.approx([0.0, 0.15], abs=0.02) and np.mean((found.worse > 0.5) == (level > 0)) > 0.98


@pytest.mark.parametrize("seed", range(3))
def test_a_base_that_drifts_is_no_level(seed):
    series, _ = made([0.0], seed)
    found = find(series, (2, 3), (-1.0,))
    assert found.shift.size == 1 and np.all(found.worse < 0.1)


def test_cycles_that_say_nothing_take_their_neighbours_level():
    series, level = made([0.0, -0.2])
    gone = np.arange(N) % 10 == 4
    found = find(Series(np.where(gone, np.nan, series.value), *list(vars(series).values())[1:]), (2,), (-1.0,))
    assert np.mean((found.worse > 0.5)[gone] == (level > 0)[gone]) > 0.95


def test_levels_that_are_there_make_left_out_cycles_better_known():
    series, _ = made([0.0, -0.2])
    before, after = left_out(series, find(series, (2,), (-1.0,)))
    assert np.mean(np.abs(after)) < 0.7 * np.mean(np.abs(before))


def test_one_level_follows_the_base():
    series, _ = made([0.0])
    assert np.sqrt(np.mean((series.value - none(series).base) ** 2)) < 1.2 * NOISE
