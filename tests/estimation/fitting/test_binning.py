"""Bins: every sample once, transients finely, classes by the place in the cycle."""

import numpy as np
from ddh_twin_py.estimation.fitting.binning import HOLDING, LIFTING, LOWERING, TRANSIENT, by_cycle, by_time, cycle_of, one_by_one

STEP = 0.01


def cycle():
    """Twice: 5 s lift, 5 s rest, 5 s lowering, 5 s rest, with ramps of 0.3 s."""
    command = np.concatenate([np.full(470, 50.0), np.linspace(50, 0, 30), np.zeros(470), np.linspace(0, -50, 30),
                              np.full(470, -50.0), np.linspace(-50, 0, 30), np.zeros(470), np.linspace(0, 50, 30)])
    return np.tile(command, 2)


def test_each_usable_sample_is_in_one_bin_and_means_are_exact():
    cut = cycle_of(cycle(), STEP)
    time = np.sort(np.random.default_rng(0).uniform(0.0, 39.9, 3000))
    usable = np.random.default_rng(1).random(3000) > 0.1
    binning = by_cycle(cut, time, usable, begin=5.0)
    assert ((binning.bin >= 0) == (usable & (time >= 5.0))).all()
    assert binning.count.sum() == (usable & (time >= 5.0)).sum()
    for b in (0, binning.count.size // 2):
        np.testing.assert_allclose(binning.mean(time)[b], time[binning.bin == b].mean(), rtol=1e-12)
        np.testing.assert_allclose(binning.time[b], time[binning.bin == b].mean(), rtol=1e-12)


def test_phases_follow_the_command():
    command = cycle()
    cut = cycle_of(command, STEP)
    middle = {LIFTING: 300, HOLDING: 850, LOWERING: 1300}
    assert all(cut.phase[i] == phase for phase, i in middle.items())
    assert (cut.phase[1500:1510] == TRANSIENT).all()


def test_transients_are_cut_finer_than_steady_stretches():
    cut = cycle_of(cycle(), STEP)
    time = STEP * np.arange(cut.time.size)
    binning = by_cycle(cut, time, np.ones(time.size, bool))
    transient = binning.phase == TRANSIENT
    assert binning.count[transient].max() <= 7  # 50 ms
    assert np.median(binning.count[~transient]) >= 50


def test_the_same_place_of_each_cycle_is_one_class():
    cut = cycle_of(cycle(), STEP)
    half = cut.kind.size // 2
    # from the first transient on: what comes before it began from nothing
    assert np.mean(cut.kind[500:half] == cut.kind[half + 500:]) > 0.95
    assert np.unique(cut.label).size > np.unique(cut.kind).size


def test_slow_and_single_bins():
    time = np.arange(0.0, 100.0, 0.5)
    usable = time != 3.0
    slow = by_time(time, usable, 20.0)
    assert slow.count.tolist() == [39, 40, 40, 40, 40]
    single = one_by_one(time[:4], np.array([True, False, True, True]))
    assert single.bin.tolist() == [0, -1, 1, 2]


def test_nothing_usable_is_no_bin():
    nothing = by_time(np.arange(5.0), np.zeros(5, bool), 1.0)
    assert nothing.count.size == 0 and (nothing.bin == -1).all()
