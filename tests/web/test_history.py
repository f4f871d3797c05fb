"""Rings of all columns: what was written is read, peaks stay, a clock that jumps back leaves nothing behind."""

import numpy as np
import pytest
from ddh_twin_py.web.binning import RowMeans
from ddh_twin_py.web.history import GRID, GRID_NS, History, Level, row_index
from hypothesis import given
from hypothesis import strategies as st

LEVELS = (Level(1, 40), Level(4, 20))


@pytest.fixture
def history():
    return History(3, LEVELS)


def rows(*index):
    return np.array(index, np.int64)


def test_a_stamp_belongs_to_the_row_at_whose_end_it_lies():
    assert row_index(np.array([0, 1, GRID_NS, GRID_NS + 1])).tolist() == [0, 1, 1, 2]


def test_what_was_written_is_read_and_the_rest_is_unknown(history):
    history.write(1, rows(100, 102), np.array([[1.0, 2.0], [3.0, 4.0]]))
    first, values = history.read(0, [0, 2], 103, 5 * GRID)
    assert first == 99 and values.dtype == np.float32
    np.testing.assert_array_equal(values[:, 1], [np.nan, 2.0, np.nan, 4.0, np.nan])
    assert np.isnan(values[:, 0]).all()


def test_rows_that_have_left_the_ring_are_not_read(history):
    history.write(0, rows(5), np.ones((1, 3)))
    history.write(0, rows(5 + 40), np.full((1, 3), 2.0))
    assert history.read(0, [0], 45, 40 * GRID)[1][:, 0].tolist()[-1] == 2.0
    assert np.isnan(history.read(0, [0], 44, 40 * GRID)[1]).all()


def test_a_peak_is_in_every_level(history):
    values = np.zeros((32, 3))
    values[17, 0] = 50.0
    values[9, 1] = -7.0
    for start in range(0, 32, 5):  # bins are filled over several calls
        history.write(0, np.arange(start, min(start + 5, 32)), values[start : start + 5])
    first, coarse = history.read(1, [0, 1], 31, 32 * GRID)
    assert first == 0 and coarse.shape == (16, 2)
    assert coarse[:, 0].max() == 50.0 and coarse[:, 1].min() == -7.0
    assert int(coarse[:, 0].argmax()) == 2 * (17 // 4) + 1  # the higher half of its bin


def test_not_a_number_does_not_hide_the_rest_of_a_bin(history):
    history.write(0, rows(8, 9), np.array([[np.nan] * 3, [4.0] * 3]))
    assert history.read(1, [0], 11, 4 * GRID)[1][:, 0].tolist() == [4.0, 4.0]


def test_after_a_jump_back_the_later_times_are_of_nobody(history):
    history.write(0, np.arange(20, 30), np.ones((10, 3)))
    history.forget_from(0, 2, 24)
    _, values = history.read(0, [0, 2], 29, 10 * GRID)
    np.testing.assert_array_equal(np.isnan(values[:, 0]), [False] * 4 + [True] * 6)
    assert (values[:, 1] == 1.0).all()  # another stream, which has not jumped
    assert np.isnan(history.read(1, [0], 29, 4 * GRID)[1]).all()


@given(st.lists(st.integers(0, 400), min_size=1, max_size=60), st.integers(1, 7))
def test_means_do_not_depend_on_how_samples_come(stamps, pieces):
    stamps = np.sort(np.array(stamps, np.int64)) * 10_000_000
    values = np.sin(np.arange(stamps.size) + 1.0)[:, None]
    whole = RowMeans(1)
    index, mean = (np.concatenate(parts) for parts in zip(whole.add(stamps, values), whole.flush(), strict=True))
    parts = RowMeans(1)
    found = [parts.add(s, v) for s, v in zip(np.array_split(stamps, pieces), np.array_split(values, pieces), strict=True)]
    found.append(parts.flush())
    assert np.concatenate([f[0] for f in found]).tolist() == index.tolist() == sorted(set(row_index(stamps).tolist()))
    np.testing.assert_allclose(np.concatenate([f[1] for f in found]), mean)
    expected = [values[row_index(stamps) == row].mean() for row in index]
    np.testing.assert_allclose(mean[:, 0], expected)


def test_a_row_of_which_nothing_is_known_stays_unknown():
    means = RowMeans(2)
    means.add(np.array([10_000_000, 20_000_000]), np.array([[np.nan, 1.0], [np.nan, 3.0]]))
    index, mean = means.flush()
    assert index.tolist() == [1] and np.isnan(mean[0, 0]) and mean[0, 1] == 2.0
    assert means.flush()[0].size == 0
