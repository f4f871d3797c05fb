"""The running test of a gap: false alarms at the declared rate or below, delay, gaps in the data, clock jumps, its file."""

import json
import math

import numpy as np
import pytest
from ddh_twin_py.gap.watch.normal_level import (
    LEAST_BINS,
    Bins,
    NormalLevel,
    NormalLevelError,
    load_levels,
    normal_level,
    save_levels,
    whitened,
)
from ddh_twin_py.gap.watch.running_test import RunningTest, Settings, SignalTest, run_length, threshold
from scipy.signal import lfilter

RATE = 10  # samples per bin
SECOND = 1_000_000_000


def autoregressive(rng, n, phi):
    """Standard deviation 1."""
    return lfilter([1.0], [1.0, -phi], rng.standard_normal(n + 400))[400:] * math.sqrt(1.0 - phi**2)


def with_slow_part(rng, n, _):
    """White, with a slow part that a process of first order does not hold."""
    return rng.standard_normal(n) + 0.5 * autoregressive(rng, n, 0.97)


def learned(x):
    n = x.size
    return normal_level(Bins(np.arange(n), RATE * x[:, None], RATE * x[:, None] ** 2, np.full((n, 1), float(RATE))), math.nan)


@pytest.mark.parametrize("k", [0.0, 0.25, 0.5, 1.0])
def test_run_length_is_that_of_a_simulated_cusum(k):
    rng, h = np.random.default_rng(3), 4.0
    lengths = []
    for _ in range(1500):
        value, n = 0.0, 0
        while value <= h:
            value, n = max(0.0, value + rng.standard_normal() - k), n + 1
            if n > 20_000:
                break
        lengths.append(n)
        if sum(lengths) > 400_000:
            break
    error = 4.0 / math.sqrt(len(lengths))
    assert np.mean(lengths) == pytest.approx(run_length(k, h), rel=0.08 + error)


def test_the_threshold_gives_the_run_length_that_was_asked_for():
    for k in (0.05, 0.3, 0.6):
        h = threshold(k, 50_000.0)
        assert 0.5 * run_length(k, h) == pytest.approx(50_000.0, rel=1e-6) or h == 6.0


@pytest.mark.parametrize(("make", "phi"), [(autoregressive, 0.0), (autoregressive, 0.6), (autoregressive, 0.9), (with_slow_part, 0.0)])
def test_false_alarms_are_no_more_frequent_than_declared(make, phi):
    """Levels learned from 180 bins, 1500 bins watched, 60 times; declared is one in 1000."""
    rng, declared = np.random.default_rng(11), 1000.0
    alarms, watched = 0, 0
    for _ in range(60):
        x = make(rng, 1680, phi)
        level = learned(x[:180])
        test = SignalTest(level, 1.0, declared)
        for i, value in enumerate((x[180:] - level.level[0]).tolist()):
            test.step(i, value)
            if test.status("x", 1.0).opened:
                alarms += 1
                test.reset()
        watched += 1500
    assert alarms <= watched / declared + 2.0 * math.sqrt(watched / declared)


def feed(test, bins, x, first=0, works=True):
    """Each bin has RATE samples of its own value; x (n, S)."""
    index = np.repeat(np.arange(first, first + bins), RATE)
    part = np.tile(np.arange(1, RATE + 1), bins)
    stamps = index * 10 * SECOND + part * SECOND
    return test.advance(stamps, np.repeat(x, RATE, axis=0), np.zeros(stamps.size, int), np.full(stamps.size, works))


def made(noise=0.5, **given):
    return RunningTest(["p", "q"], [noise, noise], 1, Settings(10.0, 1000.0, 1000.0 * 3600.0, 1.0), **given)


def test_a_step_of_two_floors_is_found_soon_with_its_beginning_and_size():
    rng, scale = np.random.default_rng(5), 0.4
    for phi, longest in ((0.0, 12), (0.5, 80)):
        test, delay = made(), None
        x = scale * np.column_stack([autoregressive(rng, 100, phi), autoregressive(rng, 100, phi)]) + [3.0, -1.0]
        feed(test, 101, np.vstack([x, x[:1]]))
        p, q = test.status()
        assert p.learned == q.learned == 1.0 and not p.opened
        floor = p.floor
        assert floor == pytest.approx(math.hypot(0.5, x[:, 0].std()), rel=1e-6)
        more = scale * np.column_stack([autoregressive(rng, 200, phi), autoregressive(rng, 200, phi)]) + [3.0, -1.0]
        more[100:, 0] += 2.0 * floor
        for i in range(200):
            feed(test, 1, more[i : i + 1], 101 + i)
            if test.status()[0].opened:
                delay = i - 100
                break
        feed(test, 199 - i, more[i + 1 :], 101 + i + 1)
        p, q = test.status()
        assert p.opened and not q.opened
        assert p.since == pytest.approx(2010.0, abs=60.0)
        assert abs(p.size - 2.0 * floor) < 3.0 * p.size_deviation < 2.0 * floor
        assert delay is not None and 1 <= delay <= longest


def test_a_gap_that_is_gone_closes():
    rng, test = np.random.default_rng(6), made()
    feed(test, 101, rng.standard_normal((101, 2)))
    feed(test, 60, rng.standard_normal((60, 2)) + [4.0, 0.0], 101)
    assert [s.opened for s in test.status()] == [True, False]
    feed(test, 90, rng.standard_normal((90, 2)), 161)
    assert [s.opened for s in test.status()] == [False, False]


def test_one_odd_bin_opens_no_gap():
    rng, test = np.random.default_rng(7), made()
    x = rng.standard_normal((130, 2))
    x[115] = 1000.0
    feed(test, 130, x)
    assert not any(s.opened for s in test.status())


def test_missing_samples_and_bins_are_left_out():
    rng, test = np.random.default_rng(8), made()
    x = rng.standard_normal((300, 2)) * 0.3
    x[rng.random((300, 2)) < 0.5] = np.nan
    feed(test, 300, x)
    p, _ = test.status()
    assert p.learned == 1.0 and test.levels["p"].bins == 100
    feed(test, 1, np.full((1, 2), np.nan), 300)  # finishes the one before
    value = test.status()[0].statistic
    feed(test, 19, np.full((19, 2), np.nan), 301)
    feed(test, 20, np.full((20, 2), 50.0), 320, works=False)  # the machine stands
    assert test.status()[0].statistic == value


def test_a_signal_that_falls_silent_while_the_machine_works_is_not_tested_until_it_is_heard_again():
    rng, test = np.random.default_rng(9), made()
    feed(test, 201, rng.standard_normal((201, 2)) * 0.3)
    x = rng.standard_normal((6, 2)) * 0.3
    x[:, 1] = np.nan
    for at, tested in ((201, True), (202, True), (203, True), (204, False), (205, False)):  # a bin is finished by the next
        feed(test, 1, x[:1], at)
        assert [status.tested for status in test.status()] == [True, tested], at
    assert test.status()[1].unheard == 4 * test.bin_length
    feed(test, 40, np.full((40, 2), np.nan), 206, works=False)
    assert [status.tested for status in test.status()] == [True, False]
    feed(test, 2, rng.standard_normal((2, 2)) * 0.3, 246)
    assert [status.unheard for status in test.status()] == [0.0, 0.0]


def test_white_noise_stays_white_across_missing_bins():
    rng = np.random.default_rng(9)
    x = autoregressive(rng, 40_000, 0.8)
    kept = np.flatnonzero(rng.random(x.size) < 0.6)
    own = whitened(x[kept], kept, 0.8)
    assert own.std() == pytest.approx(0.6, rel=0.03)
    assert abs(np.corrcoef(own[1:], own[:-1])[0, 1]) < 0.03


def test_a_clock_that_jumps_back_resets_the_test_and_keeps_what_is_learned():
    rng, test = np.random.default_rng(10), made()
    feed(test, 101, rng.standard_normal((101, 2)))
    feed(test, 60, rng.standard_normal((60, 2)) + 4.0, 101)
    levels = dict(test.levels)
    assert all(s.opened for s in test.status()) and test.resets == 0
    feed(test, 2, rng.standard_normal((2, 2)), 3)
    assert test.resets == 1 and test.levels == levels
    assert not any(s.opened for s in test.status())


def test_the_newest_end_is_that_of_the_newest_finished_bin():
    test, ends = made(), []
    for first in (4, 5, 90, 3):  # the second finishes the first one; then a pause; then the clock jumps back
        feed(test, 1, np.zeros((1, 2)), first)
        ends.append(test.newest_end_ns)
    assert ends == [0, 50 * SECOND, 60 * SECOND, 0]


def test_a_jump_while_learning_begins_to_learn_anew():
    test = made()
    feed(test, 50, np.random.default_rng(1).standard_normal((50, 2)), 1000)
    feed(test, 2, np.zeros((2, 2)), 0)
    assert test.resets == 1 and test.status()[0].learned == pytest.approx(0.01)


def test_a_reference_that_ends_early_is_taken_as_it_is():
    rng, test = np.random.default_rng(18), made()
    feed(test, LEAST_BINS, rng.standard_normal((LEAST_BINS, 2)))
    test.end_learning()  # one bin is not finished yet
    assert not test.levels
    feed(test, 20, np.column_stack([rng.standard_normal(20), np.full(20, np.nan)]), LEAST_BINS)
    test.end_learning()
    assert test.levels["p"].bins == LEAST_BINS + 19 and test.levels["q"].bins == LEAST_BINS


def test_a_bin_is_the_same_however_it_comes_in():
    rng = np.random.default_rng(12)
    x = rng.standard_normal((140, 2))
    whole, parts = made(), made()
    feed(whole, 140, x)
    stamps = np.arange(1, 1401) * SECOND
    rows, cuts = np.repeat(x, RATE, axis=0), sorted(rng.choice(1400, 200, replace=False))
    for a, b in zip([0, *cuts], [*cuts, 1400], strict=True):
        parts.advance(stamps[a:b], rows[a:b], np.zeros(b - a, int), np.ones(b - a, bool))
    for one, other in zip(whole.status(), parts.status(), strict=True):
        assert one.statistic == pytest.approx(other.statistic, abs=1e-9) and one.floor == pytest.approx(other.floor)


def test_the_mix_of_phases_is_no_gap_and_a_phase_never_seen_is_not_tested():
    rng = np.random.default_rng(13)
    test = RunningTest(["p"], [0.1], 3, Settings(10.0, 600.0, 3.6e6, 1.0))

    def mixed(first, bins, share, phases=(0, 1)):
        for i in range(first, first + bins):
            phase = rng.choice(phases, RATE, p=[1.0 - share, share])
            level = np.array([5.0, -5.0, 40.0])[phase]
            stamps = i * 10 * SECOND + np.arange(1, RATE + 1) * SECOND
            test.advance(stamps, (level + 0.2 * rng.standard_normal(RATE))[:, None], phase, np.ones(RATE, bool))

    mixed(0, 61, 0.5)
    (level,) = test.levels.values()
    assert level.level[:2] == pytest.approx((5.0, -5.0), abs=0.1) and math.isnan(level.level[2])
    assert level.floor == pytest.approx(math.hypot(0.1, 0.2), rel=0.1)
    mixed(61, 100, 0.9)
    mixed(161, 100, 0.4, (0, 2))
    assert not test.status()[0].opened and test.status()[0].unheard == 0.0
    mixed(261, 1, 0.95, (0, 2))
    before = test.status()[0].statistic
    mixed(262, 100, 0.95, (0, 2))
    assert test.status()[0].statistic == before and test.status()[0].unheard > 0.0, "a sample or two are no bin, whatever else was read"
    assert test.expected(np.array([1, 2]))[:, 0] == pytest.approx((level.level[1], 0.0))


def test_a_level_that_comes_and_goes_counts_into_the_floor():
    n = 40
    x = 2.0 + 0.1 * np.random.default_rng(14).standard_normal(n)
    bins = Bins(np.arange(n), RATE * x[:, None], RATE * x[:, None] ** 2, np.full((n, 1), float(RATE)))
    assert normal_level(bins, 0.0).floor == pytest.approx(x.std(), rel=1e-6)
    assert normal_level(bins, 0.0, floor_with_level=True).floor == pytest.approx(math.sqrt(np.mean(x**2)), rel=1e-6)


def test_too_few_bins_and_a_dead_signal_teach_nothing():
    few = LEAST_BINS - 1
    assert learned(np.random.default_rng(15).standard_normal(few)) is None
    assert learned(np.zeros(50)) is None


def test_levels_survive_in_a_file(tmp_path):
    rng, test = np.random.default_rng(16), made()
    feed(test, 101, rng.standard_normal((101, 2)))
    path = tmp_path / "deep" / "normal.json"
    save_levels(path, "rig_7", 10.0, test.levels)
    rig_id, levels = load_levels(path, 10.0, dict.fromkeys(test.levels, test.phases))
    assert rig_id == "rig_7" and levels == test.levels
    assert made(known=levels).status()[0].learned == 1.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.update(version=9), "version is 9"),
        (lambda c: c.update(bin=5.0), "bin is 5.0 s, the test's bins are 10 s"),
        (lambda c: c["signals"]["p"].update(spread=-1.0), "signals.p.spread: value is -1.0"),
        (lambda c: c["signals"]["p"].pop("floor"), "KeyError: 'floor'"),
        (lambda c: c.update(rig_id=None), "rig_id is None, a string is needed"),
        (lambda c: c.update(signals=[1]), "is no file of normal levels"),
        (lambda c: c["signals"]["p"].update(level=[0.0]), "signals.p.level: found 1 of the 2 needed, one for each phase"),
        (lambda c: c["signals"]["p"].update(level=[None, None]), "signals.p.level: value is [None, None], which no normal level has"),
    ],
)
def test_a_file_that_cannot_be_used_says_why(tmp_path, change, words):
    path = tmp_path / "normal.json"
    save_levels(path, "rig_7", 10.0, {"p": NormalLevel((0.0, math.nan), 1.0, 0.5, 0.2, 50, 200.0)})
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    with pytest.raises(NormalLevelError, match="normal.json") as caught:
        load_levels(path, 10.0, {"p": 2})
    assert words in str(caught.value) and "\n" not in str(caught.value)
    path.write_text("{")
    with pytest.raises(NormalLevelError, match="is no JSON"):
        load_levels(path, 10.0)
    with pytest.raises(NormalLevelError, match="No such file"):
        load_levels(tmp_path / "none.json", 10.0)
