"""Bins and intervals of recordings."""

import numpy as np
from ddh_twin_py.real_rigs.figures import interval, rms, surely_smaller
from ddh_twin_py.real_rigs.signals import binned, signal


def test_bins_hold_one_kind_and_their_mean_time():
    time = np.arange(12) * 1.0
    kind = np.array([0] * 5 + [1] * 7)
    bins = binned(time, 4.0, kind)
    np.testing.assert_array_equal(bins.bin, [0, 0, 0, 0, 1, 2, 2, 2, 3, 3, 3, 3])
    np.testing.assert_array_equal(bins.kind, [0, 0, 1, 1])
    np.testing.assert_allclose(bins.time, [1.5, 4.0, 6.0, 9.5])
    assert (bins.phase == -1).all()


def test_what_is_held_out_or_missing_is_in_no_bin():
    time = np.arange(10) * 1.0
    measured = np.where(time == 3.0, np.nan, time)
    for width in (None, 2.0):
        found = signal(time, measured, 0.1, "V", width, used_until=6.0, held_from=7.0)
        np.testing.assert_array_equal(found.binning.bin >= 0, [True, True, True, False, True, True, True, False, False, False])
        assert found.held_from == 7.0 and found.binning.count.sum() == 6


def test_the_interval_of_a_root_mean_square_holds_it():
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(60):
        values = rng.normal(0.0, 2.0, 800)
        low, high = interval(values)
        assert low < rms(values) < high
        held += low < 2.0 < high
    assert held > 48


def test_surely_smaller_asks_for_more_than_chance():
    rng = np.random.default_rng(2)
    noise = rng.normal(0.0, 1.0, 2000)
    wave = np.sin(np.arange(2000) / 50.0)
    assert surely_smaller([{"a": noise + wave}], [{"a": noise}])
    assert not surely_smaller([{"a": noise}], [{"a": noise + wave}])
    assert not surely_smaller([{"a": noise}], [{"a": noise}])
    once = noise.copy()
    once[500:520] += 5.0  # one event of twenty blocks is no evidence
    assert not surely_smaller([{"a": once}], [{"a": noise}])
