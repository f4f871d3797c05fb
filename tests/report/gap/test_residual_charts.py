"""Residuals against other variables: binning, gaps, and whether what is left is noise."""

import numpy as np
import pytest
from ddh_twin_py.gap.findings import Trace
from ddh_twin_py.report.gap.residual_charts import along, binned, broken, varies
from ddh_twin_py.report.gap.rest import followed, judged, persistence
from ddh_twin_py.report.page.curve_plot import Curve, curve_plot, ticks
from ddh_twin_py.report.times import going_on

TIME = np.arange(0.0, 400.0, 0.05)


def trace(residual, floor=1.0):
    zero = np.zeros(residual.size)
    return Trace(0.05 * np.arange(residual.size), residual, zero, zero, "bar", floor, floor)


def test_a_known_law_comes_back_with_its_scatter():
    rng = np.random.default_rng(3)
    x = rng.uniform(-50.0, 50.0, TIME.size)
    found = binned(x, 0.2 * x + rng.normal(size=x.size))
    np.testing.assert_allclose(found.median, 0.2 * found.at, atol=0.25)
    np.testing.assert_allclose(found.high - found.low, 2.0, atol=0.9)  # two thirds of a normal scatter, and the slope within a class
    assert found.samples == x.size and (np.diff(found.at) > 0.0).all()


def test_missing_samples_and_thin_classes_count_for_nothing():
    x, y = np.linspace(0.0, 10.0, 1000), np.ones(1000)
    y[x > 5.0] = np.nan
    found = binned(x, y)
    assert found.at.max() < 5.1 and found.samples == np.isfinite(y).sum()
    assert binned(x[:3], y[:3]).at.size == 0
    lone = binned(np.full(50, 2.0), np.arange(50.0))
    assert lone.at.tolist() == [2.0] and lone.median.tolist() == [24.5]


def test_a_variable_is_taken_at_the_times_of_the_trace():
    slow = (TIME[::40], TIME[::40] * 2.0)
    at = along(trace(np.zeros(TIME.size)), slow)
    inside = TIME <= TIME[::40][-1]
    np.testing.assert_allclose(at[inside], 2.0 * 0.05 * np.arange(inside.sum()), rtol=1e-9)
    assert np.isnan(at[~inside]).all()
    assert np.isnan(along(trace(np.zeros(10)), (TIME, np.full(TIME.size, np.nan)))).all()


def test_a_variable_that_rested_whenever_the_signal_was_measured_says_nothing():
    speed = np.concatenate([np.linspace(-100.0, 100.0, 500), np.full(20, 1e-7), [np.nan]])
    assert varies(speed[:500], speed) and varies(speed[200:260], speed)
    assert not varies(speed[500:520], speed) and not varies(np.full(9, 5.0), np.full(30, 5.0))


def test_no_line_crosses_data_that_were_left_out():
    kept = (TIME < 60.0) | (TIME > 120.0)
    time, (series,) = broken(TIME[kept], [TIME[kept]])
    assert time.size == kept.sum() + 1 and np.isnan(series).sum() == 1
    assert 60.0 < time[np.isnan(series)][0] < 120.0
    assert broken(TIME, [TIME])[0].size == TIME.size
    back = going_on(np.concatenate([TIME[:100], TIME[:100]]))
    assert (np.diff(back) > 0.0).all()


def test_noise_is_told_from_a_pattern():
    rng = np.random.default_rng(1)
    white = rng.normal(size=4000)
    assert persistence(white) == pytest.approx(0.0, abs=0.06)
    assert persistence(np.sin(0.01 * np.arange(4000))) > 0.99
    assert persistence(white + 4.0) > 0.9, "an offset keeps its sign"
    assert persistence(np.tile([1.4, -1.4], 20)) > 0.9, "so do strokes in the same direction"
    assert np.isnan(persistence(white[:5]))
    assert "noise" in judged(1.1, trace(white)) and "beyond" not in judged(1.1, trace(white))
    assert "scatter beyond the noise" in judged(3.0, trace(3.0 * white))
    assert "a pattern remains" in judged(3.0, trace(3.0 * np.sin(0.01 * np.arange(4000))))
    assert "more than noise" in judged(3.0, None)
    assert "a pattern remains" in judged(2.8, trace(0.4 + 0.1 * white)), "an offset of some noises"
    assert "a pattern remains" in judged(2.3, trace(np.tile([1.4, 0.0], 8) + 0.1 * white[:16])), "strokes that err in one direction alone"


def test_what_follows_a_variable_is_no_scatter():
    rng = np.random.default_rng(3)
    white, pressure, at = rng.normal(size=4000), rng.uniform(1e6, 8e6, 4000), 0.05 * np.arange(4000)
    rising = white + 0.8 * (pressure - 4.5e6) / 2e6
    assert followed(white, pressure) == pytest.approx(0.0, abs=0.01) and followed(rising, pressure) == pytest.approx(0.39, abs=0.04)
    assert np.isnan(followed(white[:30], pressure[:30])) and np.isnan(followed(white, np.ones(4000)))
    axes = {"pressure, Pa": (at, pressure), "speed, rad/s": (at, rng.normal(size=4000))}
    assert "follows pressure" in judged(2.0, trace(rising), axes) and "scatter beyond the noise" in judged(2.0, trace(white), axes)
    assert "scatter beyond the noise" in judged(2.0, trace(rising)), "no variable was looked at"


@pytest.mark.parametrize(("count", "patterns", "scatters"), [(6, 0.1, 0.0), (10, 0.1, 0.0), (20, 0.1, 0.8)])
def test_few_samples_of_plain_noise_are_seldom_called_a_pattern(count, patterns, scatters):
    rng = np.random.default_rng(2)
    said = [judged(3.0, trace(rng.normal(size=count))) for _ in range(200)]
    assert sum("pattern" in one for one in said) <= 200 * patterns and sum("scatter" in one for one in said) >= 200 * scatters
    assert ("scatter" in "".join(said)) == (scatters > 0.0), "too few to tell"
    assert "a pattern remains" in judged(3.0, trace(1.0 + 0.1 * rng.normal(size=count)))


def test_plots_leave_out_what_is_missing():
    at = np.array([0.0, 1.0, np.nan, 3.0])
    svg = curve_plot([Curve("c", "fused", at, at, at - 1.0, at + 1.0)], "x <1>", "y", 0.5)
    assert svg.count("<circle") == 3 and "nan" not in svg and "x &lt;1&gt;" in svg and 'class="floor"' in svg
    assert curve_plot([Curve("c", "fused", at[:0], at[:0], at[:0], at[:0])], "x", "y") == ""
    same = curve_plot([Curve("c", "fused", np.ones(1), np.zeros(1), np.zeros(1), np.zeros(1))], "x", "y")
    assert same.count("<circle") == 1 and "nan" not in same


@pytest.mark.parametrize("low, high", [(0.0, 1.0), (-3e-7, 2e-7), (-1234.0, 999.0), (99.5, 101.0), (-497.0, 497.0)])
@pytest.mark.parametrize("about", [1.5, 4])
def test_ticks_are_round_and_inside(low, high, about):
    found = ticks(low, high, about)
    assert 2 <= len(found) <= 2.5 * about + 3 and found[0] >= low - 1e-9 * (high - low) and found[-1] <= high + 1e-9 * (high - low)
    step = found[1] - found[0]
    assert float(f"{step:.0e}") == pytest.approx(step)
