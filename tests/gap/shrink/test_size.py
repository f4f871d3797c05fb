"""How large a gap is: ratios, floors, the closed fraction and its interval."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.binning import by_time
from ddh_twin_py.gap.shrink.size import WITHOUT_COMMISSIONING, closed, floors, gap, interval, pooled, ratios


def signal(measured, noise=0.5, used=None):
    time = 0.1 * np.arange(measured.size)
    binning = by_time(time, np.ones(time.size, dtype=bool) if used is None else used, 1.0)
    return SimpleNamespace(time=time, measured=measured, noise=noise, binning=binning)


def test_ratios_count_only_samples_that_were_binned_and_are_numbers():
    measured = np.array([1.0, -1.0, np.nan, 50.0])
    used = np.array([True, True, True, False])
    assert ratios({"a": signal(measured, 0.5, used)}, {"a": np.zeros(4)}) == {"a": pytest.approx(2.0)}
    nothing = lambda own: np.zeros(4, dtype=bool)  # noqa: E731
    assert ratios({"a": signal(measured)}, {"a": np.zeros(4)}, nothing) == {}


def test_a_run_that_predicts_no_number_is_infinitely_off_and_not_better():
    astray = np.where(np.arange(100) < 10, 0.0, np.nan)
    assert ratios({"a": signal(np.zeros(100))}, {"a": astray}) == {"a": np.inf}
    missing = signal(np.where(np.arange(100) < 10, 1.0, np.nan))
    assert ratios({"a": missing}, {"a": np.zeros(100)}) == {"a": pytest.approx(2.0)}
    assert gap({"a": np.inf, "b": 1.0}, {"a": 1.0, "b": 1.0}) == np.inf


def test_floor_is_what_the_fitted_twin_leaves_but_not_below_the_noise():
    left = {"a": np.full(100, 1.5), "b": np.full(100, 0.1)}
    signals = {name: signal(values) for name, values in left.items()}
    twin = {name: np.zeros(100) for name in left}
    assert floors([(signals, twin)], ["a", "b", "c"]) == {"a": pytest.approx(3.0), "b": 1.0, "c": WITHOUT_COMMISSIONING}
    assert floors([], ["a"]) == {"a": WITHOUT_COMMISSIONING}
    twice = [(signals, twin), ({"a": signal(np.full(50, 0.5))}, {"a": np.zeros(50)})]
    assert floors(twice, ["a"])["a"] == pytest.approx(np.sqrt((9.0 + 1.0) / 2.0))


def test_gap_is_the_rms_over_signals_and_1_at_the_floor():
    floor = {"a": 2.0, "b": 4.0}
    assert gap({"a": 2.0, "b": 4.0}, floor) == pytest.approx(1.0)
    assert gap({"a": 6.0, "b": 4.0}, floor) == pytest.approx(np.sqrt((9.0 + 1.0) / 2.0))
    assert gap({"a": 6.0}, floor) == pytest.approx(3.0)


def test_closed_fraction():
    assert closed(3.0, 1.0) == pytest.approx(1.0) and closed(3.0, 2.0) == pytest.approx(0.5) and closed(3.0, 4.0) == pytest.approx(-0.5)
    assert closed(1.19, 1.0) is None


def test_a_run_that_went_astray_and_does_so_no_more_is_a_gap_that_is_closed():
    assert closed(np.inf, 1.4) == 1.0 and closed(np.inf, np.inf) == 0.0


def test_interval_covers_the_true_rms_and_grows_where_errors_hang_together():
    rng = np.random.default_rng(1)
    covered = 0
    for _ in range(60):
        low, high = interval([(signal(rng.normal(0.0, 2.0, 6000)), np.zeros(6000))])
        covered += low <= 2.0 <= high
    assert 48 <= covered
    white = interval([(signal(rng.normal(0.0, 2.0, 6000)), np.zeros(6000))])
    slow = interval([(signal(np.repeat(rng.normal(0.0, 2.0, 20), 300)), np.zeros(6000))])
    assert slow[1] - slow[0] > 3.0 * (white[1] - white[0])
    assert np.isnan(interval([(signal(np.full(10, np.nan)), np.zeros(10))])).all()


def test_the_interval_of_recordings_of_unlike_length_holds_their_rms():
    rng = np.random.default_rng(1)
    long, short = signal(rng.normal(0.0, 1.0, 36000)), signal(rng.normal(0.0, 5.0, 1200))
    both = [({"a": one}, {"a": np.zeros(one.time.size)}) for one in (long, short)]
    low, high = interval([(own["a"], run["a"]) for own, run in both])
    assert low < pooled(both)["a"] * long.noise < high < 1.2 * low
