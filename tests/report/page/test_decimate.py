"""Decimation keeps peaks, gaps and ends."""

import numpy as np
from ddh_twin_py.report.page.decimate import decimated, mean_and_ends, min_max_indices
from hypothesis import given
from hypothesis import strategies as st

samples = st.lists(st.floats(-1e6, 1e6) | st.just(float("nan")), min_size=1, max_size=300)


@given(samples, st.integers(1, 40))
def test_every_bucket_keeps_its_extremes_and_its_gap(values, buckets):
    values = np.array(values)
    kept = min_max_indices([values], buckets)
    assert (np.diff(kept) > 0).all()
    assert kept[0] == 0 and kept[-1] == values.size - 1
    assert kept.size <= 3 * buckets + 2
    width = -(-values.size // buckets)
    for start in range(0, values.size, width):
        run = values[start : start + width]
        shown = values[kept[(kept >= start) & (kept < start + width)]]
        if np.isfinite(run).any():
            assert np.nanmin(shown) == np.nanmin(run)
            assert np.nanmax(shown) == np.nanmax(run)
        assert np.isnan(shown).any() == np.isnan(run).any()


def test_one_sample_spike_of_one_series_stays_at_its_own_time():
    n = 200_000
    time = 0.05 * np.arange(n)
    calm, spiky = np.sin(time), np.zeros(n)
    spiky[123_457] = 9.0
    short, (first, second) = decimated(time, [calm, spiky], 2000)
    assert short.size < 6000 < n
    assert first.size == second.size == short.size
    assert short[second.argmax()] == time[123_457]
    assert first[second.argmax()] == calm[123_457]


def test_few_samples_are_left_alone():
    time = np.arange(10.0)
    assert decimated(time, [time], 10)[0] is time
    assert min_max_indices([np.zeros(0)], 5).size == 0


def test_mean_and_ends_of_spans_of_time():
    time, values = np.array([0.0, 0.5, 1.0, 1.5, 3.5, 4.0]), np.array([1.0, 3.0, 2.0, np.nan, 7.0, 9.0])
    mean, low, high = mean_and_ends(time, values, np.array([0.0, 1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(mean, [2.0, np.nan, 8.0])
    np.testing.assert_array_equal(low, [1.0, np.nan, 7.0])
    np.testing.assert_array_equal(high, [3.0, np.nan, 9.0])
